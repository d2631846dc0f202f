"""Rigid bodies: mass properties against closed forms, frames, prescribed motion."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import mesh
from stark.recording import Recorder, Recording


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


def test_setting_a_velocity_without_a_simulation_says_where_it_is_given() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    with pytest.raises(stark.InvalidArgument, match=r"velocity = ... needs a simulation.*velocity="):
        box.velocity = (1, 0, 0)
    sim = stark.Simulation(scene)
    box.velocity = (1, 0, 0)
    assert sim.time == 0.0 and box.velocity.tolist() == [1, 0, 0]


def test_velocities_are_of_the_centre_of_mass_those_of_scripted_bodies_of_the_origin() -> None:
    scene, mesh = stark.Scene(), stark.mesh.box(0.1).translated((0.3, 0.0, 0.0))
    bodies = [
        scene.add_rigid(mesh, motion=motion, velocity=(0, 0, 1), angular_velocity=(0, 0, 2), **mass)
        for motion, mass in (("dynamic", {"mass": 1.0, "position": (0, 3, 0)}), ("scripted", {}))
    ]
    sim = stark.Simulation(scene, gravity=(0, 0, 0))
    for body in bodies:
        of_origin, turning = sim._core.twist(body._index)
        is_dynamic = body.motion == "dynamic"
        lever = body.rotation @ np.array([0.3, 0.0, 0.0]) * is_dynamic
        np.testing.assert_allclose(body.velocity, of_origin + np.cross(turning, lever), atol=1e-14)


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


def test_fixed_bodies_are_not_moved_and_nothing_to_nowhere() -> None:
    scene = stark.Scene()
    wall = scene.add_box(0.1, motion="fixed", position=(5, 0, 0), name="wall")
    box = scene.add_box(0.1, mass=1.0, name="box")
    _sim = stark.Simulation(scene)
    with pytest.raises(stark.InvalidArgument, match=r"'wall' is fixed: its position cannot be set.*scripted"):
        wall.position = (0, 0, 0)
    with pytest.raises(stark.InvalidArgument, match="nan"):
        box.rotation = (math.nan, 0, 0, 1)


def test_shapes_name_an_argument_that_they_do_not_have() -> None:
    with pytest.raises(TypeError, match=r"add_box\(\) got an unexpected .* 'masss'; did you mean 'mass'"):
        stark.Scene().add_box(0.1, masss=1.0)


def test_what_is_shown_touches_nothing_and_moves_along(tmp_path: Path) -> None:
    """A small box that shows a large ball: it comes to rest on the box; pictures have the ball, with the
    values of the box."""
    scene = stark.Scene()
    scene.add_floor()
    ball = stark.mesh.sphere(0.2, 2).translated((0.0, 0.0, 0.1))
    plain = scene.add_box(0.1, mass=0.5, position=(1.0, 0.0, 0.06), name="plain")
    box = scene.add_box(0.1, mass=0.5, position=(0.0, 0.0, 0.06), name="box", shown=ball)
    assert box.shown is not None and plain.shown is None
    sim = stark.Simulation(scene, time_step=0.01)
    assert sim["box"].shown is box.shown
    with Recorder(tmp_path / "run", sim, fields=("speed",)) as recorder:
        for report in sim.run(until=0.3):
            assert not report.failed
        recorder.record(sim)
    assert box.position[2] == pytest.approx(plain.position[2], abs=1e-6)
    recording = Recording(tmp_path / "run")
    drawn = recording.frame(0).bodies
    expected = ball.vertices @ box.rotation.T + box.position
    by_name = {body.name: body for body in drawn}
    np.testing.assert_allclose(by_name["box"].positions, expected, atol=1e-6)
    np.testing.assert_array_equal(by_name["box"].triangles, ball.triangles)
    assert len(by_name["plain"].positions) == 8
    values = recording.field("speed", 0)
    assert len(values["box"]) == len(ball.vertices)
    with pytest.raises(stark.InvalidArgument, match="rigid body 'odd': shown"):
        scene.add_box(0.1, mass=1.0, name="odd", shown=3)


def test_what_a_rigid_body_has_not_is_not_sought_in_its_material() -> None:
    """It has none: the hint was to write body.material."""
    box = stark.Scene().add_box(0.1, density=100.0)
    with pytest.raises(
        AttributeError, match=r"no attribute 'density': write body.mass \[kg\]; density= is given"
    ):
        print(box.density)
    with pytest.raises(AttributeError, match=r"no attribute 'thickness': write scene.add_solid or add_cloth"):
        print(box.thickness)


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        ({"mass": 1.0}, "floor: mass = 1.0 kg: must be left out, as a floor never moves; give motion="),
        ({"density": 0.0, "name": "lawn"}, "floor 'lawn': density = 0.0 kg/m\\^3: must be left out"),
        ({"inertia": (1.0, (0, 0, 0), np.eye(3))}, "(?s)floor: inertia = .*: must be left out"),
        ({"linear_damping": 0.1}, "floor: linear_damping = 0.1 1/s: must be left out"),
        ({"height": 1.0, "position": (0, 0, 2)}, "height = 1.0 m and position = .* are both given: give one"),
    ],
)
def test_what_makes_no_difference_to_a_floor_is_refused(options: dict[str, Any], rule: str) -> None:
    """It was taken in silence."""
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match=rule):
        scene.add_floor(2.0, **options)
    assert not scene.bodies
    scene.add_floor(2.0, position=(0, 0, 1), linear_damping=np.float32(0), height=np.int64(0))
    assert scene.add_floor(2.0, position=None, height=-1.0).position[2] == -1.0
    scene.add_floor(2.0, motion="dynamic", mass=1.0, linear_damping=0.1)
