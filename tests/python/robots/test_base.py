"""The base of a floating robot: placed and pushed with all that hangs on it."""

from __future__ import annotations

import numpy as np
import pytest
from robots._robots import ARM

import stark

pytest.importorskip("yourdfpy")
START = {"shoulder": 0.5, "elbow": 1.2, "roll": 1.0, "left_slide": 0.02}
TURN = stark.rotation(axis=(1.0, 2.0, -1.0), angle=2.0)


def flying(**options: object) -> tuple[stark.Simulation, stark.robots.Robot]:
    scene = stark.Scene()
    robot = scene.add_robot(ARM, q=START, base="floating", position=(0.0, 0.0, 1.0))
    return stark.Simulation(scene, time_step=0.002, gravity=(0, 0, 0), **options), robot  # type: ignore[arg-type]


def seen_from_the_base(robot: stark.robots.Robot) -> np.ndarray:
    """Frames of all links in that of the base."""
    origin, axes = robot.pose
    return np.concatenate(
        [
            np.r_[axes.T @ (link.position - origin), (axes.T @ link.rotation).ravel()]
            for link in robot.links.values()
        ]
    )


def test_all_of_a_floating_robot_is_placed_and_pushed() -> None:
    _, robot = flying()
    rates = np.array([0.5, -0.3, 0.2, 0.1, 0.4, 0.02])
    robot.qd = rates
    before, q = seen_from_the_base(robot), robot.q
    robot.pose = (0.3, -0.2, 2.0), TURN
    np.testing.assert_allclose(robot.pose[0], [0.3, -0.2, 2.0], atol=1e-12)
    np.testing.assert_allclose(robot.pose[1], TURN, atol=1e-12)
    np.testing.assert_allclose(seen_from_the_base(robot), before, atol=1e-9)
    np.testing.assert_allclose(robot.q, q, atol=1e-9)
    np.testing.assert_allclose(robot.qd, rates, atol=1e-7)
    robot.velocity = (1.0, 2.0, 3.0)
    robot.angular_velocity = (0.5, -1.0, 2.0)
    np.testing.assert_allclose(robot.velocity, [1, 2, 3], atol=1e-12)
    np.testing.assert_allclose(robot.angular_velocity, [0.5, -1, 2], atol=1e-12)
    np.testing.assert_allclose(robot.qd, rates, atol=1e-7)
    # Each point of a link moves as the base and the rates say: the Jacobian is checked elsewhere.
    palm = robot.links["palm"]
    assert palm.body is not None
    point = palm.rotation.T @ (
        palm.body.position + palm.body.rotation @ palm.body.center_of_mass - palm.position
    )
    own = (robot.jacobian("palm", point) @ rates)[:3]
    arm = palm.position + palm.rotation @ point - robot.pose[0]
    turning = np.cross([0.5, -1.0, 2.0], arm)
    np.testing.assert_allclose(palm.body.velocity, np.array([1.0, 2.0, 3.0]) + turning + own, atol=1e-6)
    all_rates = np.concatenate([robot.velocity, robot.angular_velocity, robot.qd])
    moved = robot.jacobian("palm", point, with_base=True) @ all_rates
    np.testing.assert_allclose(moved, [*palm.body.velocity, *palm.body.angular_velocity], atol=1e-6)
    root = robot.description.root
    np.testing.assert_array_equal(robot.jacobian(root, with_base=True), np.eye(6, 12))
    with pytest.raises(stark.InvalidArgument, match="jacobian: with_base = 'yes': must be True or False"):
        robot.jacobian("palm", with_base="yes")  # type: ignore[arg-type]


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_robot_that_is_thrown_keeps_its_shape(integrator: str) -> None:
    sim, robot = flying(time={"integrator": integrator})
    before = seen_from_the_base(robot)
    robot.pose = (0.0, 0.0, 3.0), TURN
    robot.velocity = (2.0, 0.0, 0.0)
    sim.run_until(0.1)
    np.testing.assert_allclose(robot.pose[0], [0.2, 0.0, 3.0], atol=1e-9)
    np.testing.assert_allclose(seen_from_the_base(robot), before, atol=1e-9)


def test_bases_that_do_not_float_are_refused_and_a_failure_changes_nothing() -> None:
    for base, text in (
        ("fixed", "is fixed: must be floating; add"),
        ("scripted", "is scripted: must be floating"),
    ):
        scene = stark.Scene()
        robot = scene.add_robot(ARM, q=START, base=base)  # type: ignore[arg-type]
        sim = stark.Simulation(scene)
        with pytest.raises(stark.InvalidArgument, match=f"robot 'arm': pose: its base {text}"):
            robot.pose = (0, 0, 1), np.eye(3)
        with pytest.raises(stark.InvalidArgument, match=f"robot 'arm': velocity: its base {text}"):
            robot.velocity = (0, 0, 1)
    scene = stark.Scene()
    scene.add_floor(4.0)
    robot = scene.add_robot(ARM, q=START, base="floating", position=(0, 0, 1))
    sim = stark.Simulation(scene)
    before = sim.state
    with pytest.raises(stark.InitialIntersection, match="'floor'"):
        robot.pose = (0.0, 0.0, -0.2), np.eye(3)
    with pytest.raises(
        stark.InvalidArgument, match=r"robot 'arm': pose = 3: must be \(position \[m\], rotation\)"
    ):
        robot.pose = 3  # type: ignore[assignment]
    assert sim.state == before
