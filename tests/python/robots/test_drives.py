"""Servos, motors and efforts of robots: they hold against gravity, and stay within their caps."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from robots._robots import ARM

import stark

pytest.importorskip("yourdfpy")
START = {"shoulder": 0.7, "elbow": 1.0, "pitch": 0.3, "left_slide": 0.02}
GAINS = {"stiffness": 20.0, "damping": 5.0}


def arm() -> tuple[stark.Scene, stark.robots.Robot]:
    scene = stark.Scene()
    return scene, scene.add_robot(ARM, q=START)


def run(sim: stark.Simulation, steps: int) -> None:
    for _ in range(steps):
        report = sim.step()
        assert not report.failed, report.message


def test_gravity_compensation_holds_where_soft_servos_sag() -> None:
    moved = {}
    for compensated in (False, True):
        scene, robot = arm()
        servos = robot.add_servos(**GAINS, gravity_compensation=compensated)
        sim = stark.Simulation(scene, time_step=0.01)
        start = robot.q
        run(sim, 50)
        moved[compensated] = np.abs(robot.q - start).max()
        assert servos.gravity_compensation is compensated
        if compensated:
            np.testing.assert_allclose(servos.feedforward, robot.gravity_efforts(), atol=1e-6)
            np.testing.assert_allclose(robot.tau, robot.gravity_efforts(), atol=1e-3)
            with pytest.raises(stark.InvalidArgument, match="set gravity_compensation = False first"):
                servos.feedforward = 1.0
            servos.gravity_compensation = False
            assert not servos.feedforward.any()
    assert moved[True] < 1e-4 and moved[False] > 0.05  # [rad]


def test_servos_reach_their_targets_within_their_caps() -> None:
    scene, robot = arm()
    servos = robot.add_servos(stiffness=[900, 900, 600, 400, 300, 3000], damping=[60, 60, 40, 20, 10, 80])
    sim = stark.Simulation(scene, time_step=0.01)
    goal = np.array([0.4, 0.5, 1.1, 0.2, 0.5, 0.03])
    servos.target = goal
    largest = np.zeros(6)
    for _ in range(150):
        run(sim, 1)
        largest = np.maximum(largest, np.abs(servos.effort))
    assert np.abs(robot.q - goal).max() < 0.03
    assert (largest <= np.array([20, 30, 20, 10, 6, 20]) * (1 + 1e-9)).all() and largest[0] > 19.0
    np.testing.assert_allclose(servos.target, goal, atol=1e-15)


def test_motors_and_efforts_act_on_groups() -> None:
    scene, robot = arm()
    holding = robot.add_servos(["shoulder", "elbow", "pitch"], stiffness=900.0, damping=60.0)
    spinning = robot.add_motors(["turn", "roll"], delta=0.01)
    closing = robot.add_efforts("left_*", target=50.0)
    sim = stark.Simulation(scene, time_step=0.01)
    spinning.target = [0.5, -1.0]
    run(sim, 30)
    np.testing.assert_allclose(robot.qd[[0, 4]], [0.5, -1.0], atol=0.02)
    assert closing.effort == 20.0 == robot.tau[5]  # cut at its limit
    assert holding.joints == ("shoulder", "elbow", "pitch") and len(robot.drives) == 3
    assert sim.robots[0].drives[1].joints == ("turn", "roll")
    closing.enabled = False
    run(sim, 1)
    assert closing.effort == 0.0 and not closing.enabled


def test_wrong_values_are_named() -> None:
    _, robot = arm()
    with pytest.raises(
        stark.InvalidArgument, match=r"servos: stiffness has the shape \(2,\): must be a number or \(6,"
    ):
        robot.add_servos(stiffness=[1.0, 2.0], damping=1.0)
    with pytest.raises(stark.InvalidArgument, match="motors: target = nan: must be finite"):
        robot.add_motors(target=np.nan)
    with pytest.raises(stark.InvalidArgument, match="joints = 'right_slide': must be the name"):
        robot.add_efforts("right_slide")
    assert not robot.drives
    efforts = robot.add_efforts()
    with pytest.raises(stark.InvalidArgument, match="only servos have it; add robot"):
        efforts.gravity_compensation = True


def test_a_joint_without_limit_of_effort_needs_a_cap() -> None:
    body = stark.robots.Inertia(1.0, np.zeros(3), 0.01 * np.eye(3))
    links = [stark.robots.Link("base", body), stark.robots.Link("arm", body)]
    joint = stark.robots.RobotJoint("hinge", "continuous", "base", "arm")
    robot = stark.Scene().add_robot(stark.robots.RobotDescription("free", links, [joint]))
    with pytest.raises(
        stark.InvalidArgument, match="joint 'hinge' has no limit of effort in description 'free'"
    ):
        robot.add_motors()
    assert robot.add_motors(cap=1.0).joints == ("hinge",)


def test_unknown_attributes_are_refused_and_known_ones_reach_the_actuators() -> None:
    scene, robot = arm()
    servos = robot.add_servos(["shoulder", "elbow"], **GAINS)
    motors = robot.add_motors("turn")
    table: Any = scene.friction
    for owner in (servos, robot, robot.report, table, scene.restitution):
        with pytest.raises(AttributeError, match="has no attribute 'tagret'"):
            owner.tagret = 1.0
    with pytest.raises(AttributeError, match=r"write scene\.default_friction"):
        table.default = 0.5
    with pytest.raises(AttributeError, match="report can be read, not assigned"):
        robot.report = None  # type: ignore[misc, assignment]
    sim = stark.Simulation(scene, time_step=0.01)
    servos.stiffness, servos.damping, servos.cap = 4000.0, [100.0, 50.0], {"elbow": 7.0}
    assert [a.stiffness for a in servos.actuators] == [4000.0] * 2
    assert servos.damping.tolist() == [a.damping for a in servos.actuators] == [100.0, 50.0]
    assert servos.cap[1] == 7.0 == sim.robots[0].drives[0].actuators[1].cap and servos.cap[0] == 30.0
    motors.delta = 0.1
    assert motors.delta.tolist() == [motors.actuators[0].delta] == [0.1]
    with pytest.raises(
        stark.InvalidArgument, match="motors: stiffness: only servos have it; motors have target"
    ):
        motors.stiffness = 1.0
    with pytest.raises(stark.InvalidArgument, match="stiffness"):
        servos.stiffness = [10.0, -1.0]
    assert servos.stiffness.tolist() == [4000.0] * 2  # all or none


def test_stiffer_servos_sag_less() -> None:
    scene, robot = arm()
    servos = robot.add_servos(**GAINS)
    sim = stark.Simulation(scene, time_step=0.01)
    start = robot.q
    run(sim, 50)
    soft = np.abs(robot.q - start).max()
    servos.stiffness, servos.damping = 4000.0, 100.0
    run(sim, 50)
    assert np.abs(robot.q - start).max() < 0.1 * soft


def test_a_robot_that_is_added_late_warns_once() -> None:
    scene, _ = arm()
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.warns(stark.StarkWarning) as found:
        late = scene.add_robot(ARM, name="late", q=START, position=(3.0, 0.0, 0.0))
    assert [str(w.message).partition(" was added")[0] for w in found] == ["robot 'late'"]
    assert found[0].filename == __file__
    with pytest.warns(stark.StarkWarning) as found:
        late.add_servos(**GAINS)
    assert [str(w.message).partition(" was added")[0] for w in found] == ["robot 'late': a group of servos"]
    assert found[0].filename == __file__ and sim.time == 0.0


def test_servos_that_know_the_rate_of_their_target_do_not_lag() -> None:
    """A lag of damping over stiffness times the rate, 0.075 * 0.8 = 0.06 rad, without it."""
    worst = {}
    for knows in (False, True):
        scene, robot = arm()
        servos = robot.add_servos("turn", stiffness=400.0, damping=30.0, cap=200.0)
        servos.target = lambda t: 0.4 * (1.0 - np.cos(2.0 * t))
        assert not servos.target_rate.any()
        if knows:
            servos.target_rate = {"turn": lambda t: 0.8 * np.sin(2.0 * t)}
        sim = stark.Simulation(scene, time_step=0.005)
        worst[knows] = 0.0
        for _ in range(200):
            run(sim, 1)
            goal = 0.4 * (1.0 - np.cos(2.0 * sim.time))
            worst[knows] = max(worst[knows], abs(robot.q[0] - goal))
    assert worst[True] < 0.004 and worst[False] > 0.05
    with pytest.raises(stark.InvalidArgument, match="target_rate: only servos have it"):
        arm()[1].add_efforts().target_rate = 1.0


def test_caps_that_friction_holds_fast_warn() -> None:
    """The file of a hand has 10 N m of dry friction in fingers that 0.7 N m drive."""
    description = stark.robots.read(ARM)
    description.joints["elbow"] = replace(description.joints["elbow"], friction=10.0)
    robot = stark.Scene().add_robot(description)
    with pytest.warns(
        stark.StarkWarning, match=r"does not move 'elbow' \(0\.7 of 10\); give a larger"
    ) as found:
        robot.add_servos(["turn", "elbow"], **GAINS, cap=[5.0, 0.7])
    assert found[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        other = stark.Scene().add_robot(description)
        other.add_servos("elbow", **GAINS, cap=10.1)
        other.add_motors("turn", cap=0.0)  # off on purpose
