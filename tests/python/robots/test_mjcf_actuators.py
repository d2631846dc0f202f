"""Actuators of MJCF files: gains of servos, against mujoco itself, and limits of effort."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._robots import written_mjcf

import stark
import stark.robots

mujoco = pytest.importorskip("mujoco")

ARM = """
<body name="a"><joint name="j" axis="0 1 0" damping="0.2"/>
  <inertial pos="0.2 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
  <body name="b" pos="0.4 0 0"><joint name="s" type="slide" axis="1 0 0"/>
    <inertial pos="0.1 0 0" mass="0.5" diaginertia="0.001 0.001 0.001"/></body></body>
"""
SERVOS = """
<actuator><position name="p" joint="j" kp="20" kv="2" gear="2" forcerange="-40 40"/>
  <general name="g" joint="s" biastype="affine" gainprm="300" biasprm="0 -300 -30" forcerange="-50 50"/>
</actuator>
"""


def test_servos_of_a_file_hold_as_in_mujoco(tmp_path: Path) -> None:
    file = written_mjcf(tmp_path, ARM, SERVOS)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.timestep = 1e-4
    data = mujoco.MjData(model)
    scene = stark.Scene()
    robot = scene.add_robot(file)
    gains = robot.description.joints["j"].servo
    assert gains is not None and (gains.stiffness, gains.damping) == (80.0, 8.0)
    drives = robot.add_servos(target=[0.5, 0.05])
    np.testing.assert_array_equal(drives.cap, [80.0, 50.0])
    sim = stark.Simulation(scene, time_step=1e-3)
    sim.run_until(0.2)
    data.ctrl[:] = 1.0, 0.05  # lengths are gear times the coordinate
    while data.time < 0.2 - 1e-9:
        mujoco.mj_step(model, data)
    # Both are of first order: some milliradians of half a radian.
    np.testing.assert_allclose(robot.q, data.qpos, atol=2e-3)


def test_what_the_file_does_not_say_has_to_be_given(tmp_path: Path) -> None:
    scene = stark.Scene()
    motor = '<actuator><motor name="m" joint="j" ctrlrange="-2 2" gear="3"/></actuator>'
    robot = scene.add_robot(written_mjcf(tmp_path, ARM, motor))
    assert robot.description.joints["j"].effort == 6.0 and robot.description.joints["j"].servo is None
    with pytest.raises(
        stark.InvalidArgument, match=r"joint 'j' has no servo in .*: must have a stiffness; give st"
    ):
        robot.add_servos("j")
    with pytest.raises(
        stark.InvalidArgument, match=r"joint 's' has no limit of effort in .*: must have a cap"
    ):
        robot.add_servos("s", stiffness=1.0, damping=0.1)
    assert "actuator 'm': is not built" in str(robot.report)


def test_actuators_of_a_rate_are_the_damping_of_servos(tmp_path: Path) -> None:
    """Beside one of a position, as many files have it, and alone."""
    both = (
        '<actuator><position name="p" joint="j" kp="40" forcerange="-50 50"/>'
        '<velocity name="v" joint="j" kv="4"/><velocity name="w" joint="s" kv="30" forcerange="-60 60"/>'
        "</actuator>"
    )
    file = written_mjcf(tmp_path, ARM, both)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.timestep = 1e-4
    data = mujoco.MjData(model)
    scene = stark.Scene()
    robot = scene.add_robot(file)
    assert "damping 30 of a servo that follows target_rate on 's'" in str(robot.report)
    drives = robot.add_servos()
    np.testing.assert_array_equal(np.r_[drives.stiffness, drives.damping], [40.0, 0.0, 4.0, 30.0])
    drives.target, drives.target_rate = {"j": 0.5}, [0.3, -0.2]
    sim = stark.Simulation(scene, time_step=1e-3)
    sim.run_until(0.3)
    data.ctrl[:] = 0.5, 0.3, -0.2
    while data.time < 0.3 - 1e-9:
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(robot.q, data.qpos, atol=2e-3)
    np.testing.assert_allclose(robot.qd, data.qvel, atol=2e-2)


def test_rotors_add_to_armature_and_damping_as_in_mujoco(tmp_path: Path) -> None:
    """Whether something drives the joint or not, times the square of the gear."""
    motor = '<actuator><motor name="m" joint="j" gear="3" armature="0.02" damping="0.05"/></actuator>'
    file = written_mjcf(tmp_path, ARM, motor)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    theirs = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, theirs)
    robot = stark.Scene().add_robot(file)
    joint = robot.description.joints["j"]
    assert abs(joint.armature - 0.18) < 1e-12 and abs(joint.damping - 0.65) < 1e-12
    np.testing.assert_allclose(robot.mass_matrix(), theirs, atol=1e-12)
    assert "actuator 'm': armature 0.18 of joint 'j'" in str(robot.report)


def test_what_servos_of_a_file_lose_is_named(tmp_path: Path) -> None:
    servos = (
        '<actuator><general name="g" joint="j" biastype="affine" gainprm="100" biasprm="7 -50 -1" '
        'ctrlrange="-.2 .3"/><position name="p" joint="s" kp="9" ctrlrange="-1 1"/></actuator>'
    )
    arm = ARM.replace('type="slide"', 'type="slide" range="-1 1"')
    report = str(stark.robots.read(written_mjcf(tmp_path, arm, servos)).report)
    assert "actuator 'g': constant effort 7: use feedforward" in report
    assert "actuator 'g': ctrlrange: targets are not cut to [-0.4, 0.6]" in report
    assert "actuator 'p': ctrlrange" not in report  # the joint ends there, too


def test_actuators_of_ball_joints_limit_nothing(tmp_path: Path) -> None:
    body = ARM.replace('name="j" axis="0 1 0" damping="0.2"', 'name="j" type="ball"')
    motor = '<actuator><motor name="m" joint="j" gear="1 0 0" forcerange="-3 3"/></actuator>'
    report = str(stark.robots.read(written_mjcf(tmp_path, body, motor)).report)
    assert "actuator 'm': acts on no single joint" in report and "limit of effort 3" not in report
