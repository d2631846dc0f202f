"""Kinetic and gravitational energy and momentum of the states, against what the solver reported.

Velocities are differences of positions over the time step, which is what they are in implicit Euler steps,
but for bodies that turn as a whole: theirs are recorded (turning.py), and so are all with bdf2; they must
follow from positions and the step before (multistep.py). Angular
velocities are recorded, and must follow from the rotations (rotation.py). Masses come from mesh and density
(recording/masses.py)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .certificate import INCONCLUSIVE, NOT_APPLICABLE, NOT_RECORDED, VERIFIED, VIOLATED, Claim, comparable
from .files import need
from .held_places import held_bodies
from .multistep import Step, kinds_of_step, leading_momentum, motion_of
from .multistep import impulse as impulse_of_step
from .rotation import held_turn, impulse, momentum, velocity
from .run import Run, State, number
from .turning import wrong_velocity
from .weights import Group, Moving, groups_of

Floats = NDArray[np.float64]

_RELATIVE = 1e-9  # of the sums of absolute values
_EPSILON = 2.0**-52
_TURNING_ROUNDING = 1e6 * _EPSILON  # [rad] joints are up to 1e4 times as stiff as inertia


#: What is compared of velocities that are recorded.
_OF_VELOCITIES = ("velocities", "lags")


@dataclass
class Sums:
    """Of all free masses; ``size`` are sums of absolute values, to bound rounding."""

    kinetic: float = 0.0
    linear: Floats = field(default_factory=lambda: np.zeros(3))
    angular: Floats = field(default_factory=lambda: np.zeros(3))
    kinetic_error: float = 0.0
    linear_error: float = 0.0
    angular_error: float = 0.0


@dataclass
class InertiaCheck:
    """``add(start, end, row)`` for each step, then ``claims()``."""

    run: Run
    worst: dict[str, tuple[float, dict[str, Any] | None]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.groups: list[Group] = groups_of(self.run.bodies, held_bodies(self.run.scene))
        self.unknown: list[str] = [
            body.name
            for body in self.run.bodies
            if body.motion == "dynamic" and not body.has_pose and body.masses is None
        ]
        #: Of the last state, which is the start of the next step.
        self._last: tuple[State, list[Moving]] | None = None
        gravity = self.run.settings.get("gravity", (0.0, 0.0, 0.0))
        self.gravity: NDArray[Any] = np.array(gravity, dtype=np.float64)
        need(
            self.gravity.shape == (3,) and bool(np.isfinite(self.gravity).all()),
            f"'{self.run.folder / 'manifest.json'}': setting gravity = {gravity!r} breaks an entry: "
            f"must be three finite numbers",
        )
        #: Without them nothing can be compared.
        self.lacking: str = self.run.lacks("gravity", "time.integrator")
        self.integrator: Any = self.run.settings.get("time.integrator")
        #: [m/s^2] Torques up to it may be left at the end of a step, and are none that turn a body.
        self.tolerance: float = number(self.run.settings, "newton.acceleration_tolerance")
        if not 0.0 <= self.tolerance < math.inf:
            self.tolerance = 0.0
        #: Of the steps, by their number [s].
        self.lengths: dict[float, float] = {
            number(row, "step"): number(row, "time_step") for row in self.run.rows
        }

    def add(self, start: State, end: State, row: dict[str, Any]) -> None:
        h = number(row, "time_step")
        energy = row.get("energy")
        if self.unknown or self.lacking or not 0.0 < h < math.inf or not isinstance(energy, dict):
            return
        where = {"time": end.time, "step": row.get("step")}
        before, after = self._moving(start), self._moving(end)
        self._last = end, after
        gravity, size = self._gravity(after)
        self._compare("gravity", number(energy, "gravity"), gravity, _RELATIVE * size, where)
        steps = self._kinds(start, end, row, h)
        if not steps:
            return
        # Which kind of step it was is not recorded: the one that explains it best.
        found = [self._follow(step, before, after, row) for step in steps]
        sums, parts = min(found, key=lambda one: max(one[1].values(), default=0.0))
        for name, share in parts.items():
            self._compare(name, share, 0.0, 1.0, where)
        self._compare(
            "kinetic",
            number(energy, "kinetic"),
            sums.kinetic,
            _RELATIVE * sums.kinetic + sums.kinetic_error,
            where,
        )
        for name, value, error in (
            ("momentum", sums.linear, sums.linear_error),
            ("angular_momentum", sums.angular, sums.angular_error),
        ):
            reported = row.get(name)
            if not isinstance(reported, dict):
                continue
            for axis, component in zip("xyz", value, strict=True):
                self._compare(name, number(reported, axis), float(component), error, where)

    def _kinds(self, start: State, end: State, row: dict[str, Any], h: float) -> list[Step]:
        """What the step may have been; empty where velocities are not known."""
        if self.integrator == "implicit_euler":
            return [Step(h, h)]
        if self.integrator != "bdf2" or not (_has_velocities(start) and _has_velocities(end)):
            return []
        step = number(row, "step")
        lasting = number(row, "lasting_contact")  # NaN in recordings without it
        return kinds_of_step(
            h,
            self.lengths.get(step - 1.0, 0.0),
            row.get("integrator") == "bdf2",
            lasting if 0.0 <= lasting <= 1.0 else 0.0,
        )

    def _moving(self, state: State) -> list[Moving]:
        if self._last is not None and self._last[0] is state:
            return self._last[1]
        return [group.moving(state) for group in self.groups]

    def _follow(
        self, step: Step, before: list[Moving], after: list[Moving], row: dict[str, Any]
    ) -> tuple[Sums, dict[str, float]]:
        """Sums over all bodies after a step of that kind, and by part how far states are from what it makes
        of them, over what is allowed."""
        sums, parts = Sums(), {"turning": 0.0}
        # No contact has pushed, not even what was spent before, as restitution, or is gone at the end, as
        # friction that is older than it.
        pushed = any(row["energy"].get(kind) for kind in ("restitution", "friction"))
        is_free = number(row, "contact_count") == 0.0 and not pushed
        for group, start, end in zip(self.groups, before, after, strict=True):
            if self.integrator == "bdf2":
                motion = motion_of(group, start, end)
                v = motion.velocities[1]
                parts["velocities"] = max(parts.get("velocities", 0.0), motion.wrong_velocity(step))
                # What joints give in an impact is not recorded of points.
                is_known = is_free and not (step.is_impact and group.is_held)
                lag = motion.wrong_lag(step) if is_known else 0.0
                parts["lags"] = max(parts.get("lags", 0.0), lag)
            elif start.velocities is not None and end.velocities is not None:
                v, places = end.velocities, (start.places, end.places)
                share = wrong_velocity(group.masses, places, (start.velocities, v), step.length)
                parts["velocities"] = max(parts.get("velocities", 0.0), share)
            else:
                v = (end.places - start.places) / step.length
            self._add_points(sums, group, end.places, v, step.duration)
            wrong, allowed = self._add_turning(sums, group, start, end, row, step)
            parts["turning"] = max(parts["turning"], wrong / max(allowed, 1e-300))
        return sums, parts

    def _gravity(self, after: list[Moving]) -> tuple[float, float]:
        """Gravitational energy, and the sum of absolute values [J]."""
        energy, size = 0.0, 0.0
        for group, end in zip(self.groups, after, strict=True):
            energy -= float(group.masses @ (end.places @ self.gravity))
            size += float(group.masses @ np.abs(end.places * self.gravity).sum(axis=1))
        return energy, size

    def _add_points(self, sums: Sums, group: Group, x: Floats, v: Floats, duration: float) -> None:
        # Rounding of the positions, over the time step.
        error = 4.0 * _EPSILON * group.largest(x)[:, 0] / duration
        masses, speed = group.masses, np.linalg.norm(v, axis=1)
        sums.kinetic += 0.5 * float(masses @ (v * v).sum(axis=1))
        sums.kinetic_error += float(masses @ (2.0 * error * speed + error * error))
        sums.linear += masses @ v
        sums.linear_error += float(masses @ (2.0 * error + _RELATIVE * speed))
        sums.angular += masses @ np.cross(x, v)
        reach = np.linalg.norm(x, axis=1)
        sums.angular_error += float(masses @ (reach * (2.0 * error + _RELATIVE * speed)))

    def _add_turning(
        self, sums: Sums, group: Group, start: Moving, end: Moving, row: dict[str, Any], step: Step
    ) -> tuple[float, float]:
        """Adds rotation, and returns the largest change of an angular momentum that the rotations do not
        explain, with what is allowed [kg m^2/s]."""
        moments, (R0, w0), (R1, w1) = group.moments, start.turning, end.turning
        if len(moments) == 0 or R0 is None or w0 is None or R1 is None or w1 is None:
            return 0.0, 0.0
        h = step.length
        before, after = momentum(R0, moments, w0), momentum(R1, moments, w1)
        sums.kinetic += 0.5 * float((after * w1).sum())
        sums.angular += after.sum(axis=0)
        sums.angular_error += _RELATIVE * float(np.abs(after).sum())
        # What Newton's method leaves unbalanced is an error of the rotation; free motion is known to the
        # accuracy of a midpoint rule with substeps of 0.05 rad; the rest is rounding, of penalties of joints,
        # too.
        spins = start.spins if self.integrator == "bdf2" else None
        change = (
            impulse(R0, R1, moments, before, h)
            if spins is None
            else impulse_of_step(R0, R1, moments, before, spins, step)
        )
        wrong = np.linalg.norm(after - before - change, axis=1)
        allowed = _RELATIVE * np.linalg.norm(before, axis=1) + moments.sum(axis=1) * _TURNING_ROUNDING / h
        leading = before if spins is None else leading_momentum(before, spins, step)
        rates = velocity(R0, moments, leading)
        allowed = allowed + 0.05**2 * h * np.linalg.norm(np.cross(rates, leading), axis=1)
        if start.reach is not None:
            # The residual is that of the end of the step, reported is that of the iterate before it. Torques
            # that it leaves accelerate the surface: the smallest moment of inertia over the largest arm.
            acceleration = max(number(row, "acceleration"), self.tolerance)
            allowed = allowed + h * acceleration * moments.min(axis=1) / np.maximum(start.reach, 1e-300)
        # Frames, too, may be held far from their free motion, as those of rods that bend for good.
        turn = held_turn(R0, R1, moments, before + change, change, h)
        wrong = np.fmin(wrong, np.linalg.norm(after - turn, axis=1))
        worst = int(np.argmax(wrong / np.maximum(allowed, 1e-300)))
        return float(wrong[worst]), float(allowed[worst])

    def _compare(
        self, name: str, reported: float, value: float, allowed: float, where: dict[str, Any]
    ) -> None:
        """Keeps the largest difference over what is allowed."""
        share = comparable(abs(reported - value) / max(allowed, 1e-300))
        if share > self.worst.get(name, (-1.0, None))[0]:
            self.worst[name] = share, {**where, "reported": reported, "measured": value}

    def claims(self) -> list[Claim]:
        return [
            self._claim(
                "reported_energies",
                "kinetic and gravitational energy that the solver reports are those of the states",
                ("kinetic", "gravity", *_OF_VELOCITIES),
            ),
            self._claim(
                "reported_momentum",
                "linear and angular momentum that the solver reports are those of the states, and angular "
                "momenta change as the rotations say",
                ("momentum", "angular_momentum", "turning", *_OF_VELOCITIES),
            ),
        ]

    def _claim(self, name: str, statement: str, parts: tuple[str, ...]) -> Claim:
        basis = "states against telemetry"
        found = [(part, *self.worst[part]) for part in parts if part in self.worst]
        if self.unknown:
            detail = f"masses of '{self.unknown[0]}' are not recorded"
            return Claim(name, statement, NOT_RECORDED, basis, detail=detail, required=False)
        if self.lacking:
            return Claim(name, statement, INCONCLUSIVE, basis, detail=self.lacking, required=False)
        if not found and self.integrator == "bdf2":
            detail = "velocities are not recorded, which are no differences of two states in steps of bdf2"
            return Claim(name, statement, NOT_RECORDED, basis, detail=detail, required=False)
        if not found:
            detail = f"velocities of {self.integrator} steps are not differences of two states"
            return Claim(name, statement, NOT_APPLICABLE, basis, detail=detail, required=False)
        part, worst, where = max(found, key=lambda entry: entry[1])
        status = VERIFIED if worst <= 1.0 else VIOLATED
        detail = "" if status == VERIFIED else f"{part} differs"
        if "kinetic" in parts and "kinetic" not in self.worst:
            detail = f"gravitational energy only: {self.integrator} steps"
        return Claim(name, statement, status, basis, worst, 1.0, "of rounding", where, detail, required=False)


def _has_velocities(state: State) -> bool:
    """Whether what bdf2 remembers of the bodies is recorded."""
    return all(array is not None for array in state.velocities)
