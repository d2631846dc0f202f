"""Inverse kinematics with a preferred posture: no q at the goal nearby is nearer to it."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark.robots import Inertia, Link, RobotDescription, RobotJoint

TIP = (1.0, 0.0, 0.0)


def planar(count: int, limit: float | None = None) -> stark.robots.Robot:
    """Links of 1 m that turn about y in the plane x, z."""
    body = Inertia(1.0, np.zeros(3), 0.01 * np.eye(3))
    links = [Link("stand"), *(Link(f"link_{k}", body) for k in range(count))]
    joints = [
        RobotJoint(
            f"joint_{k}", "continuous" if limit is None else "revolute", links[k].name, links[k + 1].name,
            np.array([float(k > 0), 0.0, 0.0]), axis=np.array([0.0, -1.0, 0.0]),
            lower=None if limit is None else -limit, upper=limit,
        )
        for k in range(count)
    ]  # fmt: skip
    return stark.Scene().add_robot(RobotDescription("planar", links, joints), contact=False)


def three_links(first: np.ndarray, goal: np.ndarray, side: float) -> np.ndarray:
    """All q (n, 3) of three links whose tip is at goal (2,), by the angle of the first link and the side that
    the elbow is on: the law of cosines."""
    rest = goal - np.column_stack([np.cos(first), np.sin(first)])
    distance = np.linalg.norm(rest, axis=1)
    bend = side * np.arccos(np.clip(0.5 * distance, -1.0, 1.0))
    second = np.arctan2(rest[:, 1], rest[:, 0]) + bend - first
    second = (second + np.pi) % (2 * np.pi) - np.pi
    return np.column_stack([first, second, -2.0 * bend])[distance < 2.0]


@pytest.mark.parametrize("wanted", [(0.9, -0.4, -0.3), (0.2, 0.6, 0.5), (1.5, -1.5, 0.4)])
def test_no_other_way_to_the_goal_is_nearer(wanted: tuple[float, float, float]) -> None:
    robot, goal = planar(3), np.array([1.4, 1.1])
    found = robot.inverse_kinematics("link_2", (goal[0], 0.0, goal[1]), point=TIP, prefer=wanted)
    assert found.position_error < 1e-6
    angles = np.linspace(-np.pi, np.pi, 200_001)
    every = np.concatenate([three_links(angles, goal, side) for side in (-1.0, 1.0)])
    least = np.linalg.norm(every - wanted, axis=1).min()
    assert np.linalg.norm(found.q - wanted) == pytest.approx(least, abs=1e-6)
    plain = robot.inverse_kinematics("link_2", (goal[0], 0.0, goal[1]), point=TIP, start=wanted)
    assert np.linalg.norm(plain.q - wanted) > least + 1e-4  # the start alone is no preference


def test_limits_hold_while_it_slides() -> None:
    """Four links whose wanted posture is beyond the limits: at the found one the gradient of the distance is
    in the rows of the Jacobian and in the limits that hold."""
    robot = planar(4, limit=0.8)
    goal = robot.forward_kinematics([0.6, 0.1, -0.5, 0.3])["link_3"].at(np.array(TIP), np.eye(3)).position
    wanted = np.array([2.5, -0.5, -0.6, 0.0])
    start = [0.6, 0.1, -0.5, 0.3]
    found = robot.inverse_kinematics("link_3", goal, point=TIP, prefer=wanted, start=start)
    assert found.position_error < 1e-6 and (np.abs(found.q) <= 0.8).all()
    assert found.at_limits == ("joint_0",)
    robot_q = robot.jacobian("link_3", TIP, q=found.q)[[0, 2]]
    free = np.arange(4) != 0
    pull = (wanted - found.q)[free]
    left = pull - robot_q[:, free].T @ np.linalg.lstsq(robot_q[:, free].T, pull, rcond=None)[0]
    assert np.abs(left).max() < 1e-6
    assert (wanted - found.q)[0] > 0.0  # the limit that holds stands in the way


def test_a_goal_that_needs_all_joints_leaves_no_choice() -> None:
    robot = planar(2)
    half = np.arccos(0.6)
    found = robot.inverse_kinematics("link_1", (1.2, 0, 0), point=TIP, start=[0.5, -1.0], prefer=[2.0, 2.0])
    np.testing.assert_allclose(found.q, [half, -2.0 * half], atol=1e-6)
    with pytest.raises(stark.InvalidArgument, match="prefer"):
        robot.inverse_kinematics("link_1", (1.2, 0, 0), prefer=[1.0, 2.0, 3.0])
