"""Coordinates, links and kinematics of a robot in a simulation."""

from __future__ import annotations

import numpy as np
import pytest
from robots._robots import ARM

import stark

pytest.importorskip("yourdfpy")
START = {"shoulder": 0.5, "elbow": 1.2, "roll": 4.0, "left_slide": 0.02}


def arm() -> tuple[stark.Scene, stark.robots.Robot]:
    scene = stark.Scene()
    return scene, scene.add_robot(ARM, q=START)


def test_q_is_read_and_placed_with_what_mimics() -> None:
    scene, robot = arm()
    np.testing.assert_allclose(robot.q, [0, 0.5, 1.2, 0, 4.0, 0.02], atol=0)
    with pytest.raises(stark.InvalidArgument, match="robot 'arm': qd needs a simulation"):
        print(robot.qd)
    sim = stark.Simulation(scene, time_step=0.01)
    wanted = np.array([0.3, -0.4, 1.0, 0.2, -5.0, 0.03])
    robot.q = wanted
    np.testing.assert_allclose(robot.q, wanted, atol=1e-9)
    assert abs(robot.joints["right_slide"].displacement - 0.03) < 1e-9
    robot.q = {"turn": -0.2}
    np.testing.assert_allclose(robot.q, [-0.2, *wanted[1:]], atol=1e-9)
    frames = robot.forward_kinematics(robot.q)
    for name, link in robot.links.items():
        np.testing.assert_allclose(link.position, frames[name].position, atol=1e-8)
        np.testing.assert_allclose(link.rotation, frames[name].rotation, atol=1e-8)
    before = sim.state
    with pytest.raises(stark.InvalidArgument):
        robot.q = {"left_slide": 0.2}  # beyond its stop
    assert sim.state == before
    with sim.placing():
        robot.q = wanted


def test_rates_and_jacobian_are_those_of_the_bodies() -> None:
    scene, robot = arm()
    stark.Simulation(scene, time_step=0.01).step()
    sim = stark.Simulation(scene, time_step=0.01)
    rates = np.array([0.5, -0.3, 0.2, 0.1, 0.4, 0.02])
    robot.qd = rates
    np.testing.assert_allclose(robot.qd, rates, atol=1e-7)
    for name, link in robot.links.items():
        body = link.body
        if body is None or body.motion == "fixed":
            continue
        center = link.offset.rotation.T @ (body.center_of_mass - link.offset.position)
        velocity = robot.jacobian(name, center) @ rates
        np.testing.assert_allclose(velocity, [*body.velocity, *body.angular_velocity], atol=1e-6)
    assert sim.time == 0.0


@pytest.mark.filterwarnings("ignore::stark.StarkWarning")
def test_each_simulation_has_its_robot() -> None:
    scene, robot = arm()
    first, second = (stark.Simulation(scene, time_step=0.01) for _ in range(2))
    second.robots[0].q = {"turn": 1.0}
    assert abs(robot.q[0] - 1.0) < 1e-9 and abs(first.robots[0].q[0]) < 1e-9
    assert (
        abs(second.robots[0].links["palm"].position[1]) > 0.1 > abs(first.robots[0].links["palm"].position[1])
    )
    later = scene.add_robot(ARM, position=(2, 0, 0))
    assert len(first.robots) == 1 and later.name == "arm_2"
    with pytest.raises(stark.InvalidArgument, match="was added after the simulation was created"):
        print(later.qd)


def test_what_a_simulation_that_is_gone_had_is_not_the_start() -> None:
    """Nor are efforts against gravity those of the start; servos for the next simulation can be added."""
    scene, robot = arm()
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.1)
    del sim
    for read in (lambda: robot.q, robot.mass_matrix, robot.gravity_efforts):
        with pytest.raises(
            stark.InvalidArgument, match=r"its simulation is gone; keep the stark\.Simulation"
        ):
            read()
    servos = robot.add_servos(stiffness=10.0, damping=1.0, cap=5.0)
    again = stark.Simulation(scene, time_step=0.01)
    np.testing.assert_allclose(servos.target, robot.q, atol=1e-12)
    assert again.time == 0.0


def test_wrong_names_say_what_there_is() -> None:
    _, robot = arm()
    with pytest.raises(stark.InvalidArgument, match="link 'hand': must be one of base, turret"):
        robot.jacobian("hand")
    with pytest.raises(stark.InvalidArgument, match=r"joints = 'wheel_\*': must be the name or pattern"):
        robot.add_efforts("wheel_*")
    lower, upper = robot.limits
    assert lower.tolist() == [-2.9, -1.9, -2.5, -2.0, -6.2, 0.0] and upper[-1] == 0.045


def test_links_are_names() -> None:
    """Errors were on hashing."""
    _, robot = arm()
    for link in (["grip"], np.zeros(3), None):
        with pytest.raises(stark.InvalidArgument, match=r"link '.*': must be one of base, turret"):
            robot.jacobian(link)  # type: ignore[arg-type]


def test_switches_are_true_or_false() -> None:
    _, robot = arm()
    with pytest.raises(stark.InvalidArgument, match="gravity_compensation = 'no': must be True or False"):
        robot.add_servos("turn", stiffness=1.0, damping=1.0, gravity_compensation="no")  # type: ignore[arg-type]
    assert not robot.drives
    with pytest.raises(stark.InvalidArgument, match=r"'grip': nearest = .*: must be True or False"):
        robot.inverse_kinematics("grip", (0.3, 0.0, 0.3), nearest=np.zeros(3))  # type: ignore[arg-type]
