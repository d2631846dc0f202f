"""What a scene of the list is, and running one: everything that is looked at in every step."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

import stark

from .judge import Judge, Way

#: Unbalanced force over that which the tolerance of Newton's method allows. Contact forces are those of the
#: last iterate, and so are the momenta: what is left is the residual, of all bodies together.
_BALANCE = 3.0


@dataclass
class Setup:
    """A scene that is ready to run."""

    scene: stark.Scene
    until: float  # [s]
    settings: dict[str, Any] = field(default_factory=dict)
    #: Before each step.
    drive: Callable[[stark.Simulation], None] | None = None
    #: After each step: what is wrong, or nothing.
    watch: Callable[[stark.Simulation], str | None] | None = None
    #: After the last step: what is wrong, or nothing.
    check: Callable[[stark.Simulation], str | None] | None = None
    #: Text of the message of the step that must fail.
    fails: str | None = None
    #: Causes for which a step may fail.
    causes: frozenset[str] = frozenset()
    #: Text of the exception that making the simulation must raise.
    refused: str | None = None
    #: Whether all forces on free masses are gravity and contact: no pins, dampers of masses, joints.
    balanced: bool = True
    #: Whether mechanical energy cannot grow: nothing is driven.
    passive: bool = True
    most_iterations: int = 400  # of a step with its retries
    most_retries: int = 8
    #: Accepted steps after which a run is over, whatever the time.
    most_steps: int = 10**9
    #: Steps in which no way was found that is near the straight lines.
    most_open: int = 0
    #: Whether ways that are not straight are searched for, which takes minutes in heaps of cloth.
    searched: bool = True


@dataclass(frozen=True)
class Case:
    """``build(full)`` returns a Setup, of the full size or of a small one that runs in a second or so."""

    name: str
    build: Callable[[bool], Setup]
    slow: bool = False  # the small one, too


@dataclass
class Outcome:
    """Of a run. ``problems`` are what must not be; a failed step that leaves the state intact is none where
    it is expected."""

    name: str
    status: str = "complete"  # or failed, refused
    message: str = ""
    cause: str = ""  # of a failed step
    caveats: dict[str, int] = field(default_factory=dict)  # steps by caveat
    steps: int = 0
    iterations: int = 0
    most_iterations: int = 0
    retries: int = 0
    contacts: int = 0  # most in a step
    gap: float = math.inf  # smallest, over the largest contact distance of a body
    around: int = 0  # steps whose way is not straight
    open: int = 0
    imbalance: float = 0.0  # largest, over what the tolerance allows
    growth: float = 0.0  # of the mechanical energy, over the largest so far
    seconds: float = 0.0
    hash: str = ""
    problems: list[str] = field(default_factory=list)

    def row(self) -> dict[str, Any]:
        return asdict(self)


def simulate(setup: Setup, **settings: Any) -> stark.Simulation:
    return stark.Simulation(setup.scene, **{**setup.settings, **settings})


def is_over(sim: stark.Simulation, setup: Setup, steps: int) -> bool:
    return sim.time >= setup.until - 1e-9 * setup.until or steps >= setup.most_steps


def run(name: str, setup: Setup, *, judged: bool = True, **settings: Any) -> Outcome:
    """Runs a scene to its end. ``judged=False`` leaves out what takes time."""
    outcome = Outcome(name)
    began = time.process_time()
    try:
        sim = simulate(setup, **settings)
    except stark.Error as error:
        outcome.status, outcome.message = "refused", str(error)
        if setup.refused is None or setup.refused not in outcome.message:
            outcome.problems.append(f"refused: {error}")
        return outcome
    if setup.refused is not None:
        outcome.problems.append(f"must be refused with '{setup.refused}'")
    watcher = _Watcher(sim, setup, outcome, Judge(sim, setup.searched) if judged else None)
    while not is_over(sim, setup, outcome.steps):
        if setup.drive is not None:
            setup.drive(sim)
        before = sim.state
        report = sim.step(max_time_step=setup.until - sim.time)
        outcome.seconds = time.process_time() - began
        if report.failed:
            watcher.failed(report, before)
            break
        watcher.accepted(report)
    if outcome.status == "complete" and setup.fails is not None:
        outcome.problems.append(f"a step must fail with '{setup.fails}'")
    if outcome.status == "complete" and setup.check is not None:
        wrong = setup.check(sim)
        outcome.problems += [wrong] if wrong else []
    outcome.hash = sim.state.hash
    return outcome


class _Watcher:
    """Everything that must hold in every step."""

    def __init__(self, sim: stark.Simulation, setup: Setup, outcome: Outcome, judge: Judge | None) -> None:
        self._sim, self._setup, self._outcome, self._judge = sim, setup, outcome, judge
        self._contact_distance = max(sim.contact_distance(body) for body in sim.bodies)
        self._free = np.array([body.kind != "rigid" or body.motion == "dynamic" for body in sim.bodies])
        self._mass = sum(body.mass for body in sim.bodies)
        self._momentum: Any = None
        self._energy: float | None = None
        self._largest = 0.0  # energy so far

    def failed(self, report: Any, before: Any) -> None:
        outcome, expected = self._outcome, self._setup.fails
        outcome.status, outcome.message, outcome.cause = "failed", report.message, report.diagnosis.cause
        if outcome.cause not in self._setup.causes and (expected is None or expected not in report.message):
            self._note(f"step {report.step} failed: {report.message}")
        if not report.message:
            self._note("a step failed without a message")
        # Targets of scripted motion were set before the step, as controls are.
        old, new = before.arrays(), self._sim.state.arrays()
        changed = [
            k for k in old if not k.startswith(("script_", "pin_")) and not np.array_equal(old[k], new[k])
        ]
        if changed:
            self._note(f"a failed step changed the state: {changed}")
        if self._judge is not None and self._judge.intersects():
            self._note("the state that a failed step left intersects")

    def accepted(self, report: Any) -> None:
        outcome, setup = self._outcome, self._setup
        outcome.steps += 1
        outcome.iterations += report.newton_iterations
        outcome.most_iterations = max(outcome.most_iterations, report.newton_iterations)
        outcome.retries += report.rejected_steps
        outcome.contacts = max(outcome.contacts, report.contact_count)
        outcome.gap = min(outcome.gap, report.min_distance / self._contact_distance)
        if report.newton_iterations > setup.most_iterations:
            self._note(f"step {report.step} took {report.newton_iterations} iterations")
        if report.rejected_steps > setup.most_retries:
            self._note(f"step {report.step} was retried {report.rejected_steps} times")
        for caveat in report.caveats:
            outcome.caveats[caveat] = outcome.caveats.get(caveat, 0) + 1
        self._look(report)
        self._hold(report)
        self._balance(report)
        self._count_energy(report)
        if setup.watch is not None:
            wrong = setup.watch(self._sim)
            if wrong:
                self._note(f"step {report.step}: {wrong}")

    def _look(self, report: Any) -> None:
        arrays = self._sim.state.arrays()
        if not all(np.isfinite(arrays[name]).all() for name in arrays if arrays[name].dtype.kind == "f"):
            self._note(f"step {report.step}: the state is not finite")
        if self._judge is None:
            return
        if self._judge.intersects():
            self._note(f"step {report.step}: surfaces intersect: {self._judge.named(self._judge.wrong)}")
        if self._judge.prescribed and "prescribed_overlap" not in report.caveats:
            names = self._judge.named(self._judge.prescribed)
            self._note(f"step {report.step}: prescribed bodies meet and nothing says so: {names}")
        way = self._judge.way()
        self._outcome.around += way == Way.AROUND
        self._outcome.open += way in (Way.OPEN, Way.FAR)
        if way == Way.FAR:
            self._note(f"step {report.step}: no clear way, and something moved far")
        if way == Way.THROUGH:
            self._note(f"step {report.step}: something passed through a closed surface")
        if self._outcome.open > self._setup.most_open:
            self._note(f"step {report.step}: no clear way from the state before")

    def _hold(self, report: Any) -> None:
        """Joints are held, and actuators within their caps."""
        settings = self._sim.settings
        bound = 1.001 * max(settings["joints.length_tolerance"], settings["joints.angle_tolerance"])
        for joint in self._sim.joints if "old_friction" not in report.caveats else ():
            left = float(np.abs(joint.residuals).max(initial=0.0)) if joint.enabled else 0.0
            if not left <= bound:
                self._note(f"step {report.step}: joint '{joint.name}' is not held: {left:.3g}")
        for actuator in self._sim.actuators:
            cap = actuator.parameters.get("cap")
            if cap is not None and not abs(actuator.effort) <= (1.0 + 1e-9) * cap:
                self._note(f"step {report.step}: {actuator.kind} with {actuator.effort:.3g}, cap {cap:.3g}")

    def _balance(self, report: Any) -> None:
        """Change of momentum against gravity and the contact forces of what is not free."""
        momentum, before = np.array(report.momentum), self._momentum
        self._momentum = momentum
        if not self._setup.balanced or before is None:
            return
        contacts = self._sim.contacts
        a, b = self._free[contacts.bodies[:, 0]], self._free[contacts.bodies[:, 1]]
        forces = contacts.forces
        force = forces[a & ~b].sum(axis=0) - forces[~a & b].sum(axis=0)
        weight = self._mass * np.array(self._sim.settings["gravity"])
        residual = (momentum - before) / report.time_step - weight - force
        # Rounding: of positions in velocities, of large forces in their sum.
        size = np.abs(self._sim._core.surface()["positions"]).max()
        noise = 1e-13 * self._mass * size / report.time_step**2
        rounding = 1e-15 * size / max(report.min_distance, 1e-300)  # of gaps, and of the forces in them
        noise += (1e-9 + rounding) * float(np.abs(forces).sum())
        # Friction that has not settled, also of pairs that are out of contact by now.
        pairs = len(self._sim.state.arrays()["friction_pair"])
        noise += max(pairs, len(forces)) * report.friction_residual
        # Steps may end at rounding, where residuals of stiff contact are above the tolerance.
        tolerance = max(self._sim.settings["newton.acceleration_tolerance"], report.acceleration)
        allowed = max(self._mass * tolerance + noise, 1e-300)
        self._outcome.imbalance = max(self._outcome.imbalance, float(np.linalg.norm(residual)) / allowed)
        if np.linalg.norm(residual) > _BALANCE * allowed:
            self._note(f"step {report.step}: {np.linalg.norm(residual):.3g} N are unbalanced")

    def _count_energy(self, report: Any) -> None:
        parts = report.energy
        if not all(math.isfinite(value) for value in parts.values()):
            self._note(f"step {report.step}: an energy is not finite")
        if not self._setup.passive:
            return
        energy = parts["kinetic"] + parts["elastic"] + parts["gravity"]
        self._largest = max(self._largest, parts["kinetic"], abs(parts["gravity"]), parts["elastic"], 1e-300)
        if self._energy is not None:
            grown = (energy - self._energy) / self._largest
            self._outcome.growth = max(self._outcome.growth, grown)
        self._energy = energy if self._energy is None else min(energy, self._energy)

    def _note(self, problem: str) -> None:
        if len(self._outcome.problems) < 10:
            self._outcome.problems.append(problem)
