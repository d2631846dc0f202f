"""Mechanisms of rigid bodies and joints that the validation runs: builders, energies, extrapolation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stark

G = 9.81  # [m/s^2]
Floats = NDArray[np.float64]

# What is left of the equations of a step must be below what the order of convergence is to show.
TIGHT = {
    "newton.residual_tolerance": 1e-9,
    "newton.acceleration_tolerance": 0.0,
    "newton.step_tolerance": 0.0,
    "joints.length_tolerance": 1e-8,
    "joints.angle_tolerance": 1e-7,
}


@dataclass
class Work:
    """What the solver did in a run, or in several."""

    steps: int = 0
    iterations: int = 0
    most_iterations: int = 0
    retried: int = 0
    worst_length: float = 0.0  # [m] largest residual of a joint, where asked for
    reports: list[Any] = field(default_factory=list, repr=False)

    def add(self, report: Any) -> None:
        self.steps += 1
        self.iterations += report.newton_iterations
        self.most_iterations = max(self.most_iterations, report.newton_iterations)
        self.retried += report.status == "retried"

    def __str__(self) -> str:
        mean = self.iterations / max(self.steps, 1)
        return f"{self.steps} steps, {mean:.1f} iterations (most {self.most_iterations}), {self.retried} retried"


def simulate(scene: stark.Scene, time_step: float, **settings: Any) -> stark.Simulation:
    """Without contact; mechanisms here pass through themselves."""
    return stark.Simulation(scene, time_step=time_step, **{"contact.enabled": False, **settings})


def record(
    sim: stark.Simulation,
    until: float,
    observe: Callable[[], ArrayLike],
    work: Work | None = None,
    every: int = 1,
) -> tuple[Floats, Floats]:
    """Times and what ``observe`` returned after each ``every``-th step, and before the first."""
    times, values = [sim.time], [np.array(observe(), dtype=float)]
    for k, report in enumerate(sim.run(until), 1):
        assert not report.failed, report.message
        if work is not None:
            work.add(report)
        if k % every == 0:
            times.append(sim.time)
            values.append(np.array(observe(), dtype=float))
    return np.array(times), np.array(values)


def at(history: tuple[Floats, Floats], times: ArrayLike) -> Floats:
    """Values at given times, which are multiples of the recorded step."""
    rows = [int(np.argmin(np.abs(history[0] - t))) for t in np.atleast_1d(times)]
    assert np.allclose(history[0][rows], times, atol=1e-9)
    return history[1][rows]


def crossings(history: tuple[Floats, Floats]) -> Floats:
    """Times at which a scalar passes zero, interpolated linearly between steps."""
    t, y = history[0], history[1].reshape(len(history[0]))
    k = np.flatnonzero(y[:-1] * y[1:] < 0.0)
    return t[k] + (t[k + 1] - t[k]) * y[k] / (y[k] - y[k + 1])


def extrapolate(*results: ArrayLike) -> Floats:
    """Richardson extrapolation to time step zero of results at h, h/2, h/4, ... whose error is a power series
    in h."""
    level = [np.asarray(r, dtype=float) for r in results]
    for k in range(1, len(results)):
        level = [fine + (fine - coarse) / (2.0**k - 1.0) for coarse, fine in zip(level, level[1:], strict=False)]
    return level[0]


def bar(
    scene: stark.Scene,
    start: ArrayLike,
    end: ArrayLike,
    *,
    mass: float = 1.0,
    **options: Any,
) -> stark.RigidBody:
    """Slender uniform bar; its frame is in the middle, with x along it and z across it where that is
    possible. Its radius of gyration about its own axis is 3 % of its length."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(end - start))
    x = (end - start) / length
    z = np.array([0.0, 0.0, 1.0]) if abs(x[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    z = z - (z @ x) * x
    z /= np.linalg.norm(z)
    tensor = mass * length**2 * np.diag([1e-3, 1.0 / 12.0, 1.0 / 12.0])
    return scene.add_box(
        (length, 0.02 * length, 0.02 * length),
        inertia=(mass, (0.0, 0.0, 0.0), tensor),
        position=(start + end) / 2.0,
        rotation=np.column_stack([x, np.cross(z, x), z]),
        **options,
    )


def tip(body: stark.RigidBody, local: ArrayLike) -> Floats:
    """Position in the world of a point given in the frame of the mesh."""
    return body.position + body.rotation @ np.asarray(local, dtype=float)


# --- V14 ---


def top(time_step: float, until: float, work: Work | None = None) -> tuple[Floats, Floats]:
    """Free block 0.10 x 0.06 x 0.02 m turning about its middle axis: angular velocity about that axis, in the
    body, and the angular momentum in the world over that at time 0."""
    scene = stark.Scene()
    body = scene.add_box((0.10, 0.06, 0.02), density=800.0, angular_velocity=(0.1, 10.0, 0.0))
    sim = simulate(scene, time_step, gravity=(0, 0, 0), **TIGHT)
    before = body.inertia @ (0.1, 10.0, 0.0)

    def observe() -> Floats:
        spin = body.rotation.T @ body.angular_velocity
        momentum = body.rotation @ body.inertia @ spin
        return np.concatenate([spin[1:2], momentum / np.linalg.norm(before)])

    return record(sim, until, observe, work)


# --- V15 ---


def pendulum(time_step: float, until: float, degrees: float, work: Work | None = None) -> tuple[Floats, Floats]:
    """Point mass at 1 m on a hinge, released from an angle: its angle from the vertical [rad]."""
    scene = stark.Scene()
    start = np.radians(degrees)
    # An inertia of 1e-6 kg m^2 about its own centre lengthens the period by 5e-7 of it.
    bob = scene.add_box(
        0.01,
        inertia=(1.0, (0.0, 0.0, 0.0), 1e-6 * np.eye(3)),
        position=(np.sin(start), -np.cos(start), 0.0),
    )
    hinge = scene.add_hinge(None, bob, anchor=(0, 0, 0), axis=(0, 0, 1))
    sim = simulate(scene, time_step, gravity=(0, -G, 0), **TIGHT)
    return record(sim, until, lambda: start + (hinge.angle if sim.time else 0.0), work)


def double_pendulum(time_step: float, until: float, work: Work | None = None) -> tuple[Floats, Floats]:
    """Two bars of 1 m and 1 kg released from the horizontal: position of the tip [m]."""
    scene = stark.Scene()
    first, second = bar(scene, (0, 0, 0), (1, 0, 0)), bar(scene, (1, 0, 0), (2, 0, 0))
    scene.add_hinge(None, first, anchor=(0, 0, 0), axis=(0, 0, 1))
    scene.add_hinge(first, second, anchor=(1, 0, 0), axis=(0, 0, 1))
    sim = simulate(scene, time_step, gravity=(0, -G, 0), **TIGHT)
    return record(sim, until, lambda: tip(second, (0.5, 0, 0))[:2], work)


# --- V16 ---


def four_bar(
    time_step: float, until: float, work: Work | None = None, *, redundant: bool = True, **settings: Any
) -> tuple[Floats, Floats]:
    """IFToMM's two-loop four-bar mechanism: three cranks and two couplers of 1 m and 1 kg, started at 1 m/s.
    With a hinge at each of the seven joints 7 of its 35 constraints are redundant in space and one more where
    all bars are aligned. Position of the first joint [m]."""
    scene = stark.Scene()
    cranks = [
        bar(scene, (x, 0, 0), (x, 1, 0), velocity=(0.5, 0, 0), angular_velocity=(0, 0, -1)) for x in range(3)
    ]
    couplers = [bar(scene, (x, 1, 0), (x + 1, 1, 0), velocity=(1, 0, 0)) for x in range(2)]
    z = (0, 0, 1)
    for x, crank in enumerate(cranks):
        scene.add_hinge(None, crank, anchor=(x, 0, 0), axis=z)
    for x, (coupler, a, b) in enumerate(zip(couplers, cranks[:2], cranks[1:], strict=True)):
        scene.add_hinge(a, coupler, anchor=(x, 1, 0), axis=z)
        if redundant:
            scene.add_hinge(coupler, b, anchor=(x + 1, 1, 0), axis=z)
        else:
            scene.add_point_on_axis(coupler, b, anchor=(x + 1, 1, 0), axis=z)
    sim = simulate(scene, time_step, gravity=(0, -G, 0), **{**TIGHT, **settings})

    def observe() -> Floats:
        if work is not None and sim.time:
            work.worst_length = max(work.worst_length, *(np.abs(j.residuals[:2]).max() for j in scene.joints))
        return tip(cranks[0], (0.5, 0, 0))[:2]

    return record(sim, until, observe, work)
