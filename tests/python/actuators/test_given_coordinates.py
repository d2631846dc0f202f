"""Coordinates and names are texts: arrays and lists were errors of NumPy, or left out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

WRONG: list[Any] = [np.zeros(3), [], ["angle"], 0, {}, b"angle"]


def hinges() -> tuple[stark.Scene, stark.Joint, stark.Joint]:
    scene = stark.Scene()
    bodies = [scene.add_box(0.1, mass=1.0, position=(x, 0, 0)) for x in (0.0, 1.0)]
    first, second = (scene.add_hinge(None, body, anchor=body.position, axis="z") for body in bodies)
    return scene, first, second


@pytest.mark.parametrize("wrong", WRONG, ids=repr)
def test_a_coordinate_is_a_name(wrong: Any) -> None:
    scene, first, second = hinges()
    with pytest.raises(
        stark.InvalidArgument, match=r"'hinge': add_gear: coordinate = .*: must be the name of"
    ):
        first.add_gear(second, ratio=2.0, coordinate=wrong)
    with pytest.raises(stark.InvalidArgument, match=r"'hinge': add_gear: other_coordinate = .*: must be the"):
        first.add_gear(second, ratio=2.0, other_coordinate=wrong)
    with pytest.raises(
        stark.InvalidArgument, match=r"'hinge': add_actuator: coordinate = .*: must be the name"
    ):
        first.add_effort(1.0, coordinate=wrong)
    assert not scene.actuators


def test_a_name_is_a_text() -> None:
    scene, first, _ = hinges()
    for name in (np.zeros(3), ["a"], 5):
        with pytest.raises(stark.InvalidArgument, match=r"name = .*: must be a non-empty text"):
            first.add_effort(1.0, name=name)  # type: ignore[arg-type]
        with pytest.raises(stark.InvalidArgument, match=r"name = .*: must be a non-empty text"):
            scene.add_ball(None, scene.bodies[0], anchor=(0, 0, 0), name=name)  # type: ignore[arg-type]
        with pytest.raises(stark.InvalidArgument, match=r"name = .*: must be a non-empty text"):
            stark.Scene(name)  # type: ignore[arg-type]


def test_coordinates_by_name_and_left_out() -> None:
    _, first, second = hinges()
    gear = first.add_gear(second, ratio=2.0, coordinate="angle")
    assert [name for _, name in gear.coordinates] == ["angle", "angle"]
    assert first.add_effort(1.0, coordinate="angle").coordinates == first.add_effort(1.0).coordinates


@pytest.mark.parametrize(
    "drive",
    [
        lambda joint, **options: joint.add_motor(1.0, cap=1.0, delta=1.0, **options),
        lambda joint, **options: joint.add_servo(1.0, stiffness=1.0, damping=1.0, cap=1.0, **options),
    ],
)
def test_drives_of_coordinates_that_a_joint_lacks_are_refused(drive: Any) -> None:
    """The search for a second drive on the same coordinate raised an AssertionError."""
    scene, first, _ = hinges()
    ball = scene.add_ball(None, scene.bodies[0], anchor=(0, 0, 0))
    with pytest.raises(stark.InvalidArgument, match="has no coordinate 'displacement'"):
        drive(first, coordinate="displacement")
    with pytest.raises(stark.InvalidArgument, match="has no coordinate to act on"):
        drive(ball)
    assert not scene.actuators
