"""Inverse kinematics: forward kinematics of what is found is the goal; what is out of reach is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._robots import random_urdf

import stark
from stark.robots.inverse import rotation_vector


def planar(count: int = 2, limit: float | None = None) -> stark.robots.Robot:
    """Links of 1 m that turn about y in the plane x, z; the tip is 1 m beyond the last joint along x."""
    body = stark.robots.Inertia(1.0, np.zeros(3), 0.01 * np.eye(3))
    links = [stark.robots.Link("stand"), *(stark.robots.Link(f"link_{k}", body) for k in range(count))]
    joints = [
        stark.robots.RobotJoint(
            f"joint_{k}", "continuous" if limit is None else "revolute", links[k].name, links[k + 1].name,
            np.array([float(k > 0), 0.0, 0.0]), axis=np.array([0.0, -1.0, 0.0]),
            lower=None if limit is None else -limit, upper=limit,
        )
        for k in range(count)
    ]  # fmt: skip
    return stark.Scene().add_robot(stark.robots.RobotDescription("planar", links, joints), contact=False)


TIP = {"point": (1.0, 0.0, 0.0)}


def test_two_links_have_the_angles_of_the_law_of_cosines() -> None:
    robot = planar()
    distance = 1.2
    found = robot.inverse_kinematics("link_1", (distance, 0, 0), start=[0.5, -1.0], **TIP)
    half = np.arccos(0.5 * distance)
    np.testing.assert_allclose(found.q, [half, -2.0 * half], atol=1e-6)
    other = robot.inverse_kinematics("link_1", (distance, 0, 0), start=[-0.5, 1.0], **TIP)
    np.testing.assert_allclose(other.q, [-half, 2.0 * half], atol=1e-6)
    assert found.position_error < 1e-6 and found.rotation_error == 0.0 and not found.at_limits


@pytest.mark.parametrize("seed", range(4))
def test_poses_of_random_trees_are_reached(seed: int, tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    file = tmp_path / "tree.urdf"
    file.write_text(random_urdf(seed))
    robot = stark.Scene().add_robot(file, contact=False)
    random = np.random.default_rng(seed)
    lower, upper = (np.clip(bound, -3.0, 3.0) for bound in robot.limits)
    for _ in range(5):
        goal = robot.forward_kinematics(random.uniform(lower, upper))["link_8"]
        found = robot.inverse_kinematics("link_8", goal.position, goal.rotation, attempts=50)
        reached = robot.forward_kinematics(found.q)["link_8"]
        np.testing.assert_allclose(reached.position, goal.position, atol=1e-6)
        np.testing.assert_allclose(reached.rotation, goal.rotation, atol=2e-6)
        assert (robot.limits[0] <= found.q).all() and (found.q <= robot.limits[1]).all()
        turned = robot.inverse_kinematics("link_8", rotation=goal.rotation)
        np.testing.assert_allclose(
            robot.forward_kinematics(turned.q)["link_8"].rotation, goal.rotation, atol=2e-6
        )


def test_what_is_out_of_reach_is_said_with_what_is_left() -> None:
    robot = planar()
    with pytest.raises(
        stark.InvalidArgument, match=r"'link_1': the nearest of 16 attempts is 0\.5 m and 0 rad"
    ):
        robot.inverse_kinematics("link_1", (2.5, 0, 0), **TIP)
    found = robot.inverse_kinematics("link_1", (0, 0, 2.5), nearest=True, **TIP)
    assert abs(found.position_error - 0.5) < 1e-9 and (np.abs(found.q) < 20.0).all()
    tip = robot.forward_kinematics(found.q)["link_1"].at(np.array([1.0, 0, 0]), np.eye(3))
    np.testing.assert_allclose(tip.position, [0, 0, 2.0], atol=1e-4)


def test_limits_hold_and_are_named() -> None:
    robot = planar(limit=0.5)
    with pytest.raises(
        stark.InvalidArgument, match="at their limits: joint_0, joint_1: must be within 1e-06 m"
    ):
        robot.inverse_kinematics("link_1", (0, 0, 2.0), **TIP)
    found = robot.inverse_kinematics("link_1", (0, 0, 2.0), nearest=True, **TIP)
    np.testing.assert_array_equal(found.q, [0.5, 0.5])
    assert found.at_limits == ("joint_0", "joint_1")


def test_only_the_joints_that_are_named_move() -> None:
    robot = planar(4)
    assert robot.add_group("wrist", ["joint_3", "joint_2"]) == ("joint_2", "joint_3")
    start = np.array([0.1, 0.2, 0.3, 0.4])
    goal = robot.forward_kinematics([0.1, 0.2, -0.5, 0.9])["link_3"].position
    found = robot.inverse_kinematics("link_3", goal, joints="wrist", start=start)
    np.testing.assert_array_equal(found.q[:2], start[:2])
    assert found.position_error < 1e-6
    again = robot.inverse_kinematics("link_3", goal, joints=["joint_2", "joint_3"], start=start)
    np.testing.assert_array_equal(found.q, again.q)
    assert dict(robot.groups) == {"wrist": ("joint_2", "joint_3")}
    for name in ("wrist", "joint_0", ""):
        with pytest.raises(
            stark.InvalidArgument, match="must be a text that no joint or other group is called"
        ):
            robot.add_group(name, "joint_1")


def test_wrong_arguments_are_named() -> None:
    robot = planar()
    for given, message in (
        ({"link": "hand", "position": (0, 0, 0)}, "link 'hand': must be one of stand, link_0"),
        ({}, "position and rotation are left out: must be given, one at least"),
        ({"position": (0, 0)}, "inverse_kinematics of 'link_1': position"),
        ({"position": (0, 0, 0), "attempts": 0}, "attempts = 0: must be a whole number"),
        ({"position": (0, 0, 0), "length": -1.0}, r"length = -1.0 m: must be a number > 0"),
        ({"position": (0, 0, 0), "joints": "arm"}, "joints = 'arm': must be the name or pattern"),
    ):
        with pytest.raises(stark.InvalidArgument, match=message):
            robot.inverse_kinematics(**({"link": "link_1"} | given))


def test_rotation_vectors_are_those_of_the_rotations() -> None:
    random = np.random.default_rng(0)
    for angle in (0.0, 1e-9, 1e-3, 1.0, 3.0, np.pi - 1e-5, np.pi - 1e-9, np.pi):
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
        found = rotation_vector(stark.rotation(axis=axis, angle=angle))
        wanted = angle * axis
        if angle == np.pi and found @ wanted < 0.0:
            wanted = -wanted
        np.testing.assert_allclose(found, wanted, atol=1e-7)
