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
from .multistep import Motion, Step, kinds_of_step, leading_momentum
from .multistep import impulse as impulse_of_step
from .rotation import held_turn, impulse, momentum, velocity
from .run import Body, Run, State, number
from .turning import wrong_velocity

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
        self.weights: list[_Weights | None] = [_weights(body) for body in self.run.bodies]
        self.held: set[int] = held_bodies(self.run.scene)
        self.unknown: list[str] = [
            b.name
            for b, w in zip(self.run.bodies, self.weights, strict=True)
            if w is None and b.motion == "dynamic"
        ]
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
        gravity, size = self._gravity(end)
        self._compare("gravity", number(energy, "gravity"), gravity, _RELATIVE * size, where)
        steps = self._kinds(start, end, row, h)
        if not steps:
            return
        # Which kind of step it was is not recorded: the one that explains it best.
        found = [self._follow(step, start, end, row) for step in steps]
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

    def _follow(
        self, step: Step, start: State, end: State, row: dict[str, Any]
    ) -> tuple[Sums, dict[str, float]]:
        """Sums over all bodies after a step of that kind, and by part how far states are from what it makes
        of them, over what is allowed."""
        sums, parts = Sums(), {"turning": 0.0}
        # No contact has pushed, not even what was spent before, as restitution, or is gone at the end, as
        # friction that is older than it.
        pushed = any(row["energy"].get(kind) for kind in ("restitution", "friction"))
        is_free = number(row, "contact_count") == 0.0 and not pushed
        for i, weights in enumerate(self.weights):
            if weights is None:
                continue
            for masses, x0, x1 in weights.points(start, end, i):
                if self.integrator == "bdf2":
                    motion = weights.motion(start, end, i, (x0, x1))
                    v = motion.velocities[1]
                    parts["velocities"] = max(parts.get("velocities", 0.0), motion.wrong_velocity(step))
                    # What joints give in an impact is not recorded of points.
                    is_known = is_free and not (step.is_impact and i in self.held)
                    lag = motion.wrong_lag(step) if is_known else 0.0
                    parts["lags"] = max(parts.get("lags", 0.0), lag)
                elif (known := weights.velocities(start, end, i)) is not None:
                    v = known[1]
                    share = wrong_velocity(masses, (x0, x1), known, step.length)
                    parts["velocities"] = max(parts.get("velocities", 0.0), share)
                else:
                    v = (x1 - x0) / step.length
                self._add_points(sums, masses, x1, v, step.duration)
            wrong, allowed = self._add_turning(sums, weights, (start, end), i, row, step)
            parts["turning"] = max(parts["turning"], wrong / max(allowed, 1e-300))
        return sums, parts

    def _gravity(self, end: State) -> tuple[float, float]:
        """Gravitational energy, and the sum of absolute values [J]."""
        energy, size = 0.0, 0.0
        for i, weights in enumerate(self.weights):
            for masses, _, x in weights.points(end, end, i) if weights else []:
                energy -= float(masses @ (x @ self.gravity))
                size += float(masses @ np.abs(x * self.gravity).sum(axis=1))
        return energy, size

    def _add_points(self, sums: Sums, masses: Floats, x: Floats, v: Floats, duration: float) -> None:
        # Rounding of the positions, over the time step.
        error = 4.0 * _EPSILON * np.abs(x).max(initial=0.0) / duration
        speed = np.linalg.norm(v, axis=1)
        sums.kinetic += 0.5 * float(masses @ (v * v).sum(axis=1))
        sums.kinetic_error += float(masses @ (2.0 * error * speed + error * error))
        sums.linear += masses @ v
        sums.linear_error += float(masses @ (2.0 * error + _RELATIVE * speed))
        sums.angular += masses @ np.cross(x, v)
        reach = np.linalg.norm(x, axis=1)
        sums.angular_error += float(masses @ (reach * (2.0 * error + _RELATIVE * speed)))

    def _add_turning(
        self,
        sums: Sums,
        weights: _Weights,
        states: tuple[State, State],
        i: int,
        row: dict[str, Any],
        step: Step,
    ) -> tuple[float, float]:
        """Adds rotation, and returns the largest change of an angular momentum that the rotations do not
        explain, with what is allowed [kg m^2/s]."""
        turning = weights.turning(*states, i)
        if turning is None:
            return 0.0, 0.0
        h = step.length
        moments, (R0, w0), (R1, w1) = turning
        before, after = momentum(R0, moments, w0), momentum(R1, moments, w1)
        sums.kinetic += 0.5 * float((after * w1).sum())
        sums.angular += after.sum(axis=0)
        sums.angular_error += _RELATIVE * float(np.abs(after).sum())
        # What Newton's method leaves unbalanced is an error of the rotation; free motion is known to the
        # accuracy of a midpoint rule with substeps of 0.05 rad; the rest is rounding, of penalties of joints,
        # too.
        spins = weights.spins(states[0], i) if self.integrator == "bdf2" else None
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
        if weights.body.has_pose:
            # The residual is that of the end of the step, reported is that of the iterate before it.
            acceleration = max(number(row, "acceleration"), self.tolerance)
            allowed = allowed + h * acceleration * weights.inertia_per_reach(states[0], i)
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


#: Moments of inertia; rotations and angular velocities at the start, and at the end.
_Turning = tuple[Floats, tuple[Floats, Floats], tuple[Floats, Floats]]


class _Weights:
    """What of a body has inertia: points with masses, and axes with second moments."""

    def __init__(self, body: Body) -> None:
        self.body = body
        if body.has_pose:
            assert body.inertia is not None
            tensor = np.array(body.inertia["tensor"], dtype=np.float64)
            self.mass = float(body.inertia["mass"])
            self.centre = np.array(body.inertia["center_of_mass"], dtype=np.float64)
            # Integral of x x^T dm, diagonal in its own axes.
            self.moments, self.principal = np.linalg.eigh(0.5 * np.trace(tensor) * np.eye(3) - tensor)
            return
        assert body.masses is not None
        self.masses = body.masses.copy()
        self.masses[body.pins] = 0.0
        self.free = np.ones(body.vertex_count)
        self.free[body.clamped] = 0.0

    def points(self, start: State, end: State, i: int) -> list[tuple[Floats, Floats, Floats]]:
        if not self.body.has_pose:
            return [(self.masses, start.positions[i], end.positions[i])]
        poses = start.poses[i], end.poses[i]
        before, after = (pose[0] + pose[1:] @ self.centre for pose in poses if pose is not None)
        return [(np.array([self.mass]), before[None], after[None])]

    def turning(self, start: State, end: State, i: int) -> _Turning | None:
        """Moments of inertia (n, 3), then rotations of the principal axes and angular velocities at the start
        and at the end; None for bodies whose points only move."""
        states = start, end
        if self.body.has_pose:
            second = self.moments[None]
            rotations = [pose[1:] @ self.principal for s in states if (pose := s.poses[i]) is not None]
            rotations = [R[None] for R in rotations]
        elif self.body.second_moments is not None:
            second = np.pad(self.body.second_moments, ((0, 0), (0, 1)))[self.free > 0.0]
            rotations = [frames[self.free > 0.0] for s in states if (frames := s.frames[i]) is not None]
        else:
            return None
        moments = second.sum(axis=1, keepdims=True) - second
        rates = [w.reshape(-1, 3) for s in states if (w := s.angular_velocities[i]) is not None]
        if not self.body.has_pose:
            rates = [w[self.free > 0.0] for w in rates]
        if len(moments) == 0 or len(rotations) < 2 or len(rates) < 2:
            return None
        return moments, (rotations[0], rates[0]), (rotations[1], rates[1])

    def velocities(self, start: State, end: State, i: int) -> tuple[Floats, Floats] | None:
        """Of points() at the start and at the end, those that are recorded."""
        before, after = (s.velocities[i] if s.velocities else None for s in (start, end))
        return None if before is None or after is None else (before, after)

    def motion(self, start: State, end: State, i: int, places: tuple[Floats, Floats]) -> Motion:
        """Of points(); those without mass rest."""
        shown = [array for s in (start, end) for array in (s.velocities[i], s.lags[i]) if array is not None]
        rows = [array.reshape(-1, 3) for array in shown]
        if not self.body.has_pose:
            moves = self.masses > 0.0
            rows = [np.where(moves[:, None], row, 0.0) for row in rows]
            x0, x1 = places
            places = np.where(moves[:, None], x0, 0.0), np.where(moves[:, None], x1, 0.0)
        v0, lag0, v1, lag1 = rows
        return Motion(places, (v0, v1), (lag0, lag1))

    def spins(self, state: State, i: int) -> Floats | None:
        """A, p and Q of the angular momenta of turning(), (n, 3, 3) [kg m^2/s]."""
        spins = state.spins[i]
        if spins is None or self.body.has_pose:
            return None if spins is None else spins[None]
        found: Floats = spins[self.free > 0.0]
        return found

    def inertia_per_reach(self, state: State, i: int) -> float:
        """Torque that accelerates the surface of a rigid body by 1 m/s^2 [kg m]: the smallest moment of
        inertia over the largest distance of a vertex from the centre of mass."""
        pose = state.poses[i]
        if pose is None:
            return 0.0
        arms = state.positions[i] - (pose[0] + pose[1:] @ self.centre)
        smallest = float(self.moments.sum() - self.moments.max())
        return smallest / max(float(np.linalg.norm(arms, axis=1).max()), 1e-300)


def _has_velocities(state: State) -> bool:
    """Whether what bdf2 remembers of the bodies is recorded."""
    return bool(state.velocities) and all(array is not None for array in state.velocities)


def _weights(body: Body) -> _Weights | None:
    """None for bodies without inertia, or whose masses are not known."""
    if body.motion != "dynamic" or (not body.has_pose and body.masses is None):
        return None
    return _Weights(body)
