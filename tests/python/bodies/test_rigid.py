"""Rigid bodies: mass properties against closed forms, frames, prescribed motion."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stark
from stark import mesh


def test_mass_properties_of_shapes() -> None:
    scene = stark.Scene()
    box = scene.add_box((0.1, 0.2, 0.3), mass=1.2)
    np.testing.assert_allclose(box.inertia, np.diag([0.13, 0.10, 0.05]) * 0.1, atol=1e-16)
    assert scene.add_box(0.1, density=1000.0).mass == pytest.approx(1.0, rel=1e-14)
    # A fine sphere: the polyhedron's moment is below the ball's by about the second power of its edge.
    ball = scene.add_sphere(0.5, subdivisions=5, mass=1.0)
    np.testing.assert_allclose(ball.inertia, np.eye(3) * 0.4 * 0.25, rtol=2e-3, atol=1e-6)
    shifted = scene.add_rigid(mesh.box(0.1).translated((1, 0, 0)), mass=1.0)
    np.testing.assert_allclose(shifted.center_of_mass, (1, 0, 0), atol=1e-14)
    kept = scene.add_rigid(mesh.box(0.1), inertia=(2.0, (0, 0, 0.1), np.diag([1.0, 2.0, 2.5])))
    assert kept.mass == 2.0 and kept.inertia[2, 2] == 2.5


def falling(**settings: object) -> tuple[stark.Simulation, stark.RigidBody]:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 10))
    return stark.Simulation(scene, **settings), box


def test_frames_of_rigid_bodies_take_their_rotation_as_the_guide_has_it() -> None:
    box = stark.Scene().add_box(0.1, mass=1.0)
    turned = stark.rotation(axis="z", angle=0.3)
    frames = [box.frame((0, 0, 0.1), turned), box.frame((0, 0, 0.1), rotation=turned)]
    assert all((a.positions == b.positions).all() for a, b in zip(*(f.columns for f in frames), strict=True))


def test_setting_the_velocity_of_a_dynamic_body_says_where_it_is_given() -> None:
    """With and without a simulation."""
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    for _ in range(2):
        with pytest.raises(stark.InvalidArgument, match=r"is dynamic: its velocity cannot be set.*velocity="):
            box.velocity = (1, 0, 0)
        sim = stark.Simulation(scene)
    assert sim.time == 0.0


def test_scripted_bodies_reach_their_targets_or_keep_their_velocity() -> None:
    scene = stark.Scene()
    plate = scene.add_box((1, 1, 0.1), motion="scripted")
    fan = scene.add_box(
        0.1, motion="scripted", position=(5, 0, 0), velocity=(0, 0, -0.1), angular_velocity=(0, 0, 2)
    )
    sim = stark.Simulation(scene, time_step=0.1)
    turn = stark.rotation(axis="z", angle=0.2)
    plate.position = (0, 0, 0.5)
    plate.rotation = turn
    sim.step()
    np.testing.assert_allclose(plate.position, (0, 0, 0.5), atol=1e-14)
    np.testing.assert_allclose(plate.rotation, turn, atol=1e-14)
    np.testing.assert_allclose(fan.position, (5, 0, -0.01), atol=1e-14)
    np.testing.assert_allclose(fan.rotation, turn, atol=1e-12)
    np.testing.assert_allclose(fan.velocity, (0, 0, -0.1), atol=1e-14)
    fan.velocity = (1, 0, 0)
    sim.step()
    np.testing.assert_allclose(fan.position, (5.1, 0, -0.01), atol=1e-14)
    np.testing.assert_allclose(fan.angular_velocity, (0, 0, 2), atol=1e-12)
    np.testing.assert_allclose(plate.position, (0, 0, 0.5), atol=1e-14)  # rests until told otherwise


def test_dynamic_bodies_are_not_moved_by_hand() -> None:
    _sim, box = falling()
    with pytest.raises(stark.InvalidArgument, match=r"'box' is dynamic.*scripted"):
        box.position = (0, 0, 0)
    with pytest.raises(stark.InvalidArgument, match="nan"):
        box.rotation = (math.nan, 0, 0, 1)
