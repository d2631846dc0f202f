"""Speeds, sizes and masses of different orders in contact, and a stack: V25."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import G, Judge
from _mechanisms import Work
from _validation import validate

import stark

STEP = 0.01  # [s]
APART = 1.9e-3  # about the gap at rest, of the default contact distance [m]


def run(scene: stark.Scene, until: float, **settings: Any) -> tuple[stark.Simulation, Work]:
    """Default settings. An independent judge looks for intersections after every tenth step."""
    scene.default_friction = 0.5
    sim = stark.Simulation(scene, time_step=STEP, **settings)
    judge = Judge(sim)
    work = Work()
    for k, report in enumerate(sim.run(until)):
        assert not report.failed, report.message
        work.add(report)
        if k % 10 == 0:
            assert not judge.intersects()
    assert not judge.intersects()
    return sim, work


def pile(sizes_and_masses: list[tuple[float, float]]) -> tuple[stark.Scene, list[stark.RigidBody]]:
    """Cubes on each other, beside the diagonal of the floor."""
    scene = stark.Scene()
    scene.add_floor(40.0 if sizes_and_masses[-1][0] > 1.0 else 4.0)
    height, cubes = 0.0, []
    for size, mass in sizes_and_masses:
        cubes.append(scene.add_box(size, mass=mass, position=(0.1, 0.5, height + APART + size / 2)))
        height += APART + size
    return scene, cubes


def speed(cubes: list[stark.RigidBody]) -> float:
    return max(float(np.linalg.norm(cube.velocity)) for cube in cubes)


def report(name: str, cubes: list[stark.RigidBody], work: Work) -> None:
    """Weights arrive below, nothing moves, and the solver does not mind."""
    weight = G * sum(cube.mass for cube in cubes)
    from_floor = sum(cube.contacts("floor").forces.sum(axis=0)[2] for cube in cubes[:1])
    validate(f"V25.{name}_force", from_floor / weight)
    validate(f"V25.{name}_speed", speed(cubes))
    validate(f"V25.{name}_iterations", [work.mean_iterations, work.most_iterations])
    assert work.retried == 0


def test_cube_at_1000_metres_per_second() -> None:
    scene = stark.Scene()
    scene.add_floor(4.0)
    cube = scene.add_box(0.1, mass=1.0, position=(0.1, 0.5, 5.0), velocity=(0, 0, -1000.0))
    _, work = run(scene, 1.0)
    assert 0.0 < cube.positions[:, 2].min() < 2e-3
    report("fast", [cube], work)


@pytest.mark.parametrize(
    ("name", "cubes"),
    [
        ("big", [(1.0, 1e3), (10.0, 1e6)]),
        ("heavy", [(0.1, 1.0), (0.1, 1e4)]),
        ("stack", [(0.1, 1.0)] * 5),
    ],
)
def test_piles_come_to_rest(name: str, cubes: list[tuple[float, float]]) -> None:
    scene, bodies = pile(cubes)
    _, work = run(scene, 10.0 if name == "stack" else 5.0)
    report(name, bodies, work)


def test_cube_in_a_tunnel_with_1_mm_of_play() -> None:
    """Thrown in at 2 m/s, and turning; it rattles, loses its speed and stays."""
    scene = stark.Scene()
    inside, wall = 0.101, 0.01
    for axis in (1, 2):
        for side in (-1, 1):
            # Two walls between the other two, 0.2 mm from them: nothing intersects, walls included.
            size, position = np.array([1.0, 0.13, inside - 4e-4]), np.zeros(3)
            size[axis], position[axis] = wall, side * (inside + wall) / 2
            scene.add_box(size, motion="fixed", position=position, name=f"wall {axis} {side}")
    walls = [f"wall {axis} {side}" for axis in (1, 2) for side in (-1, 1)]
    cube = scene.add_box(
        0.1, mass=1.0, position=(-0.4, 0, 0), velocity=(2, 0, 0), angular_velocity=(0.5, 1, 1)
    )
    for k, first in enumerate(walls):
        for second in walls[:k]:
            scene.disable_contact(first, second)
    _, work = run(scene, 1.0, contact_distance=2e-4)
    assert -0.4 < cube.position[0] < 0.5
    assert np.abs(cube.positions[:, 1:]).max() < inside / 2
    validate("V25.tunnel_speed", speed([cube]))
    validate("V25.tunnel_iterations", [work.mean_iterations, work.most_iterations])
