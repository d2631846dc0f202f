"""Applies to a failed step what its message advises, and other changes that it does not, from the state that
the step left: whether the run goes on then tells whether the cause that was named is the right one.

    PYTHONPATH=python python -m benchmarks.torture.remedies SEED:INDEX:KIND..."""

from __future__ import annotations

import re
import signal
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import stark

from .campaign import description_of
from .case import Setup, is_over, simulate
from .random_kinds import KINDS
from .room import room

#: CPU seconds for each change.
PATIENCE = 15.0
#: Accepted steps after a change within which a run has to get further than the step that failed was to go.
_MOST_STEPS = 200
_SLOWER, _WEAKER, _STIFFER, _SHORTER = 0.05, 1e-3, 1e3, 1e-3


@dataclass
class Failure:
    """A scene at the step that failed."""

    make: Callable[[], Setup]
    state: Any  # before the step
    time: float  # [s] of that
    report: Any
    steps: int

    def again(self, **settings: Any) -> tuple[stark.Simulation, Setup]:
        """Another simulation in that state."""
        setup = self.make()
        sim = simulate(setup, **settings)
        sim.state = self.state
        return sim, setup


def failure_of(seed: int, index: int, kind: str) -> Failure | None:
    """The first failed step of a random scene."""
    description = description_of(seed, index, kind)

    def make() -> Setup:
        return KINDS[kind][1](description)

    setup = make()
    sim, steps = simulate(setup), 0
    while not is_over(sim, setup, steps):
        if setup.drive is not None:
            setup.drive(sim)
        before = sim.state
        report = sim.step(max_time_step=setup.until - sim.time)
        if report.failed:
            return Failure(make, before, sim.time, report, steps)
        steps += 1
    return None


def go_on(sim: stark.Simulation, setup: Setup, failure: Failure) -> str:
    """What becomes of a run: ``on`` where it gets past the end that the failed step was to have; ``ahead``
    where it takes steps, but not so far within some; else the cause of the next failure."""
    step = failure.report.diagnosis.attempts[0]["time_step"]
    goal = min(setup.until, failure.time + step)
    for taken in range(_MOST_STEPS):
        if sim.time >= goal * (1.0 - 1e-9):
            return "on"
        if setup.drive is not None:
            setup.drive(sim)
        report = sim.step(max_time_step=setup.until - sim.time)
        if report.failed:
            part = (sim.time - failure.time) / (goal - failure.time)
            return f"{report.diagnosis.cause}" + (f" after {taken} ({part:.0%})" if taken else "")
    return "ahead"


# --- changes ---


def _stopped(failure: Failure) -> tuple[stark.Simulation, Setup]:
    """Everything prescribed stands still."""
    sim, setup = failure.again()
    bodies: list[Any] = list(sim.bodies)
    for body in bodies:
        if isinstance(body, stark.RigidBody):
            if body.motion == "scripted":
                body.follow()
                body.velocity = body.angular_velocity = np.zeros(3)
        elif len(getattr(body, "pins", ())) > 0:
            body.follow()
            body.pin_targets = body.positions[body.pins]
    return sim, setup


def _without_joints(failure: Failure) -> tuple[stark.Simulation, Setup]:
    sim, setup = failure.again()
    setup.drive = None
    held: list[Any] = [*sim.joints, *sim.attachments]
    for part in held:
        part.enabled = False
    return sim, setup


def _slower(failure: Failure) -> tuple[stark.Simulation, Setup]:
    """What is free, from the state on."""
    sim, setup = failure.again()
    bodies: list[Any] = list(sim.bodies)
    for body in bodies:
        if isinstance(body, stark.RigidBody):
            if body.motion == "dynamic":
                velocity, spin = np.array(body.velocity), np.array(body.angular_velocity)
                body.velocity, body.angular_velocity = _SLOWER * velocity, _SLOWER * spin
        else:
            body.velocities = _SLOWER * np.array(body.velocities)
    return sim, setup


def _weaken(sim: stark.Simulation, factor: float = _WEAKER) -> None:
    for actuator in sim.actuators:
        for name in ("cap", "stiffness", "damping") if actuator.kind != "effort" else ("target",):
            if name in actuator.units:
                setattr(actuator, name, factor * getattr(actuator, name))


def _weaker(failure: Failure) -> tuple[stark.Simulation, Setup]:
    sim, setup = failure.again()
    _weaken(sim)
    return sim, setup


def _much_weaker(failure: Failure) -> tuple[stark.Simulation, Setup]:
    sim, setup = failure.again()
    _weaken(sim, _WEAKER**2)
    return sim, setup


def _weaker_from_start(failure: Failure) -> tuple[stark.Simulation, Setup]:
    setup = failure.make()
    sim = simulate(setup)
    _weaken(sim)
    return sim, setup


def _stiffer(failure: Failure) -> tuple[stark.Simulation, Setup]:
    return failure.again(contact={"stiffness_factor": 100.0 * _STIFFER})


def _stiffer_from_start(failure: Failure) -> tuple[stark.Simulation, Setup]:
    setup = failure.make()
    return simulate(setup, contact={"stiffness_factor": 100.0 * _STIFFER}), setup


def _shorter(failure: Failure) -> tuple[stark.Simulation, Setup]:
    return failure.again(time={"min_step": 1e-6 * _SHORTER})


def _longer(failure: Failure) -> tuple[stark.Simulation, Setup]:
    return failure.again(newton={"max_iterations": 3000})


def _tolerant(failure: Failure) -> tuple[stark.Simulation, Setup]:
    """Twice what the message says was reached."""
    found = re.findall(r"newton\.(\w+_tolerance) = [^(]*\([^)]*reached: ([^ )]+)", failure.report.message)
    tolerances = {name: 2.0 * float(value) for name, value in found}
    return failure.again(newton=tolerances or {"acceleration_tolerance": 10.0})


def _without_friction(failure: Failure) -> tuple[stark.Simulation, Setup]:
    return failure.again(contact={"friction": False})


CHANGES: dict[str, Callable[[Failure], tuple[stark.Simulation, Setup]]] = {
    "same": lambda failure: failure.again(),
    "stop": _stopped,
    "slow": _slower,
    "weak": _weaker,
    "weaker": _much_weaker,
    "weak_start": _weaker_from_start,
    "unjoint": _without_joints,
    "stiff": _stiffer,
    "stiff_start": _stiffer_from_start,
    "min_step": _shorter,
    "iterations": _longer,
    "tolerance": _tolerant,
    "frictionless": _without_friction,
}


def try_changes(failure: Failure, names: Any = CHANGES) -> dict[str, str]:
    """What becomes of the run with each change."""

    def give_up(*_: Any) -> None:
        raise TimeoutError

    signal.signal(signal.SIGVTALRM, give_up)
    found = {}
    for name in names:
        signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE)
        try:
            found[name] = go_on(*CHANGES[name](failure), failure)
        except TimeoutError:
            found[name] = "no end"
        except stark.Error as error:
            found[name] = f"refused: {error}"
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    return found


def main() -> int:
    warnings.simplefilter("ignore", stark.StarkWarning)
    for word in sys.argv[1:]:
        seed, index, kind = word.split(":")
        failure = failure_of(int(seed), int(index), kind)
        if failure is None:
            print(f"{word}: complete")
            continue
        print(f"{word}: {failure.report.diagnosis.cause}: {failure.report.message}")
        sim, setup = failure.again()
        print(f"    room: {room(sim, setup.settings['time_step'])}")
        for name, end in try_changes(failure).items():
            print(f"    {name}: {end}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
