"""Coordinates are those of side b against side a, along and about the axes as given."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import stark

PLACE, AXIS = np.array([0.1, 0.2, 0.3]), np.array([1.0, 2.0, 2.0]) / 3
ACROSS = np.array([2.0, 1.0, -2.0]) / 3
FORWARD, TURN = 0.3, 0.5  # [m/s, rad/s]

Add = Callable[[stark.Scene, stark.RigidBody | None, stark.RigidBody | None], stark.Joint]

# How the joint is added, direction of the motion, whether it turns, and the coordinate.
KINDS: dict[str, tuple[Add, np.ndarray, bool, str]] = {
    "hinge": (lambda s, a, b: s.add_hinge(a, b, PLACE, AXIS), AXIS, True, "angle"),
    "slider": (lambda s, a, b: s.add_slider(a, b, PLACE, AXIS), AXIS, False, "displacement"),
    "cylindrical": (lambda s, a, b: s.add_cylindrical(a, b, PLACE, AXIS), AXIS, True, "angle"),
    "screw": (lambda s, a, b: s.add_cylindrical(a, b, PLACE, AXIS), AXIS, False, "displacement"),
    "planar": (lambda s, a, b: s.add_planar(a, b, PLACE, AXIS), AXIS, True, "angle"),
    "point": (lambda s, a, b: s.add_point_on_axis(a, b, PLACE, AXIS), AXIS, False, "displacement"),
    "direction": (
        lambda s, a, b: s.add_joint("direction", a, b, anchor=PLACE, axis=AXIS),
        AXIS,
        True,
        "angle",
    ),
    "universal": (
        lambda s, a, b: s.add_universal(a, b, PLACE, axis_a=AXIS, axis_b=ACROSS),
        AXIS,
        True,
        "angle_a",
    ),
    "cross": (
        lambda s, a, b: s.add_universal(a, b, PLACE, axis_a=AXIS, axis_b=ACROSS),
        ACROSS,
        True,
        "angle_b",
    ),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("moves", ["b", "a"])
def test_what_moves_along_an_axis_raises_its_coordinate(kind: str, moves: str) -> None:
    add, axis, turns, coordinate = KINDS[kind]
    scene = stark.Scene()
    body = scene.add_box(0.1, mass=1.0, position=PLACE)
    joint = add(scene, None, body) if moves == "b" else add(scene, body, None)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    if turns:
        body.angular_velocity = TURN * axis
    else:
        body.velocity = FORWARD * axis
    sim.run_until(0.5)
    rate = (TURN if turns else FORWARD) * (1 if moves == "b" else -1)
    assert joint.coordinates[coordinate] == pytest.approx(0.5 * rate, rel=1e-4)
    assert joint.rates[coordinate] == pytest.approx(rate, rel=1e-4)


def test_a_motor_turns_side_b_of_a_universal_joint_about_its_own_axis() -> None:
    scene = stark.Scene()
    body = scene.add_box((0.1, 0.02, 0.02), mass=1.0)
    joint = scene.add_universal(None, body, (0, 0, 0), axis_a=(1, 0, 0), axis_b=(0, 1, 0))
    joint.add_motor(2.0, cap=5.0, delta=0.01, coordinate="angle_b")
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    sim.run_until(0.5)
    assert body.angular_velocity[1] == pytest.approx(2.0, rel=1e-2)


S = np.sqrt(0.5)


@pytest.mark.parametrize(
    ("normal", "x", "y"),
    [
        ("z", (1, 0, 0), (0, 1, 0)),
        ((0, 0, -2), (1, 0, 0), (0, -1, 0)),
        ("y", (1, 0, 0), (0, 0, -1)),
        ("x", (0, 1, 0), (0, 0, 1)),
        ((-1, 0, 0), (0, 1, 0), (0, 0, -1)),
        ((-1, 0, 1), (S, 0, S), (0, 1, 0)),
    ],
)
def test_displacements_in_a_plane_are_along_the_axes_of_the_world(
    normal: str | tuple[float, float, float], x: tuple[float, ...], y: tuple[float, ...]
) -> None:
    """As the docstring of add_planar says. In the plane z = 0, x went along -y."""
    for coordinate, axis in (("displacement_x", x), ("displacement_y", y)):
        scene = stark.Scene()
        body = scene.add_box(0.1, mass=1.0, position=PLACE)
        joint = scene.add_planar(None, body, PLACE, normal)
        joint.add_effort(2.0, coordinate=coordinate)
        sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
        sim.run_until(0.1)
        np.testing.assert_allclose(body.velocity, 0.2 * np.array(axis), atol=1e-6)
        assert joint.rates[coordinate] == pytest.approx(0.2)


def test_a_rotation_gives_all_axes_of_a_plane() -> None:
    scene = stark.Scene()
    body = scene.add_box(0.1, mass=1.0, position=PLACE)
    axes = stark.rotation(axis=(1, 2, 3), angle=0.8)
    scene.add_planar(None, body, PLACE, rotation=axes).add_effort(2.0, coordinate="displacement_x")
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    sim.run_until(0.1)
    np.testing.assert_allclose(body.velocity, 0.2 * axes[:, 0], atol=1e-6)
    with pytest.raises(stark.InvalidArgument, match="axis and rotation are both given"):
        scene.add_planar(None, body, PLACE, "z", rotation=axes)


def test_axes_of_another_kind_of_joint_are_refused_by_name() -> None:
    """add_planar(axis=...) and add_universal(rotation=...) were TypeErrors about add_joint."""
    scene = stark.Scene()
    body = scene.add_box(0.1, mass=1.0, position=PLACE)
    with pytest.raises(stark.InvalidArgument, match="'planar': axis is not known here: give the normal"):
        scene.add_planar(None, body, PLACE, axis="z")
    with pytest.raises(stark.InvalidArgument, match="'universal': axes and rotation are both given"):
        scene.add_universal(None, body, PLACE, "x", "y", rotation=np.eye(3))
    assert not scene.joints
    turned = scene.add_universal(None, body, PLACE, rotation=stark.rotation(axis="z", angle=0.3))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.05)
    assert set(turned.coordinates) == {"angle_a", "angle_b"}
