"""Mechanisms of rigid bodies and joints that the validation runs: builders, energies, extrapolation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stark

Floats = NDArray[np.float64]

# What is left of the equations of a step must be below what the order of convergence is to show.
TIGHT = {
    "newton.residual_tolerance": 1e-9,
    "newton.acceleration_tolerance": 0.0,
    "newton.step_tolerance": 0.0,
}
BDF2 = {"time.integrator": "bdf2"}


@dataclass
class Work:
    """What the solver did in a run, or in several."""

    steps: int = 0
    iterations: int = 0
    most_iterations: int = 0
    retried: int = 0
    worst_residual: float = 0.0  # [m, rad] of a joint, where asked for
    reaction: Floats | None = None  # [N] of the first joint in the last step, where asked for

    def add(self, report: Any) -> None:
        self.steps += 1
        self.iterations += report.newton_iterations
        self.most_iterations = max(self.most_iterations, report.newton_iterations)
        self.retried += report.status == "retried"

    @property
    def mean_iterations(self) -> float:
        return self.iterations / self.steps

    def look_at(self, joints: Iterable[stark.Joint]) -> None:
        joints = list(joints)
        self.reaction = joints[0].reaction.force
        self.worst_residual = max(
            self.worst_residual, *(np.abs(j.residuals).max(initial=0.0) for j in joints)
        )

    def __str__(self) -> str:
        iterations = f"{self.mean_iterations:.1f} iterations (most {self.most_iterations})"
        return f"{self.steps} steps, {iterations}, {self.retried} retried"


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


def extrapolate(*results: ArrayLike, order: int = 1) -> Floats:
    """Richardson extrapolation to step zero of results at h, h/2, h/4, ... whose error is a power series in h
    that starts with h^order."""
    level = [np.asarray(r, dtype=float) for r in results]
    for power in range(order, order + len(results) - 1):
        level = [fine + (fine - coarse) / (2.0**power - 1.0) for coarse, fine in pairwise(level)]
    return level[0]


def observed_order(*results: ArrayLike) -> float:
    """Order of convergence from three results with h, h/2, h/4."""
    coarse, middle, fine = (np.asarray(r, dtype=float) for r in results)
    return float(np.log2(np.linalg.norm(middle - coarse) / np.linalg.norm(fine - middle)))


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
