"""What handles of all bodies share: placement, pins, the simulation that they read."""

from __future__ import annotations

import gc
import math

import numpy as np
import pytest

import stark
from stark import mesh


def test_placement_before_any_simulation() -> None:
    scene = stark.Scene()
    grid = mesh.grid(1, 1, 2)
    turn = stark.rotation(axis="x", angle=0.3)
    cloth = scene.add_cloth(grid, position=(1, 2, 3), rotation=turn)
    np.testing.assert_allclose(cloth.positions, grid.vertices @ turn.T + [1, 2, 3], atol=1e-15)
    box = scene.add_box(1.0, mass=2.0, position=(0, 0, 9), rotation=stark.to_quaternion(turn))
    np.testing.assert_allclose(box.position, (0, 0, 9))
    np.testing.assert_allclose(box.rotation, turn, atol=1e-15)
    start = scene.add_cloth(grid, initial_positions=0.5 * grid.vertices)
    np.testing.assert_allclose(start.positions, 0.5 * grid.vertices)


def test_pins_by_index_and_by_mask() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(mesh.grid(1, 1, 2), pins=[8, 0])
    cloth.pin(cloth.mesh.vertices[:, 0] < -0.49)
    assert cloth.pins.tolist() == [8, 0, 3, 6]


def falling(**settings: object) -> tuple[stark.Simulation, stark.RigidBody]:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 10))
    return stark.Simulation(scene, **settings), box


def test_handles_follow_the_last_simulation_and_can_be_tied_to_one() -> None:
    first, box = falling(time_step=0.1)
    second = stark.Simulation(first.scene, time_step=0.1)
    second.step()
    assert box.position[2] < 10.0
    assert first[box].position[2] == first["box"].position[2] == first.bodies[0].position[2] == 10.0
    assert first[box] == box
    tied = second["box"]
    del second
    gc.collect()
    assert tied.position[2] < 10.0  # keeps its simulation alive
    del tied
    gc.collect()
    assert box.position[2] == 10.0  # of the first one, which lives
    del first
    gc.collect()
    with pytest.raises(
        stark.InvalidArgument, match="simulation is gone"
    ):  # never the description again, silently
        _ = box.position


def test_pinned_vertices_follow_their_targets() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(mesh.grid(0.2, 0.2, 2), pins=[0, 2], contact_distance=1e-3)
    sim = stark.Simulation(scene, time_step=0.01)
    np.testing.assert_allclose(cloth.pin_targets, cloth.mesh.vertices[[0, 2]])
    cloth.pin_targets += np.array([0, 0, 0.01])
    sim.step()
    np.testing.assert_allclose(
        cloth.positions[[0, 2]], cloth.mesh.vertices[[0, 2]] + [0, 0, 0.01], atol=1e-15
    )
    assert cloth.positions[8, 2] < 0.0
    with pytest.raises(stark.InvalidArgument, match=r"\(3, 3\): must be \(2, 3\)"):
        cloth.pin_targets = np.zeros((3, 3))
    with pytest.raises(stark.InvalidArgument, match=r"pin_targets\[1\].*nan"):
        cloth.pin_targets = [[0, 0, 0], [0, math.nan, 0]]


def test_what_bodies_turn_about_at_the_start() -> None:
    """docs/loop.md: dynamic rigid ones about their centre of mass, others about the origin of their mesh."""
    beside = stark.mesh.box(0.1).translated((0.5, 0, 0))
    scene = stark.Scene()
    free = scene.add_rigid(beside, mass=1.0, angular_velocity=(0, 0, 1))
    led = scene.add_rigid(beside, motion="scripted", position=(0, 0, 1), angular_velocity=(0, 0, 1))
    sheet = scene.add_cloth(
        stark.mesh.grid(0.1, 0.1, cells=2).translated((0.5, 0, 0)),
        position=(0, 0, 2),
        angular_velocity=(0, 0, 1),
    )
    sim = stark.Simulation(scene, time_step=1e-3, gravity=(0, 0, 0))
    before = [body.positions.mean(axis=0) for body in (free, led, sheet)]
    sim.step()
    moved = [body.positions.mean(axis=0) - x for body, x in zip((free, led, sheet), before, strict=True)]
    np.testing.assert_allclose(moved, [[0, 0, 0], [0, 5e-4, 0], [0, 5e-4, 0]], atol=1e-6)
