"""Fixed tendons of MJCF files: what acts on them acts on the coordinate that all their joints follow."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._robots import written_mjcf

import stark
import stark.robots

mujoco = pytest.importorskip("mujoco")

HAND = """
<body name="palm"><inertial pos="0 0 0" mass="0.7" diaginertia="0.001 0.002 0.002"/>
  <body name="left"><joint name="l" type="slide" axis="0 1 0" range="0 0.04"/>
    <inertial pos="0 0.01 0.05" mass="0.1" diaginertia="1e-5 1e-5 1e-5"/></body>
  <body name="right"><joint name="r" type="slide" axis="0 -1 0" range="0 0.08"/>
    <inertial pos="0 -0.01 0.05" mass="0.2" diaginertia="1e-5 1e-5 1e-5"/>
    <body name="tip" pos="0 0 0.1"><joint name="t" axis="1 0 0"/>
      <site name="s"/><inertial pos="0 0 0.02" mass="0.01" diaginertia="1e-5 1e-5 1e-5"/></body></body>
  <site name="p"/></body>
"""
FOLLOWING = '<equality><joint joint1="r" joint2="l" polycoef="0 2 0 0 0" solref="0.001 1"/></equality>'
SERVO = """
<tendon><fixed name="split"><joint joint="l" coef="0.5"/><joint joint="r" coef="0.5"/></fixed></tendon>
<actuator><general name="close" tendon="split" gear="2" forcerange="-30 30" ctrlrange="0 255"
  gainprm="0.5" biastype="affine" biasprm="0 -100 -10"/></actuator>
"""


def test_a_servo_on_a_tendon_of_both_fingers_moves_as_in_mujoco(tmp_path: Path) -> None:
    file = written_mjcf(tmp_path, HAND, FOLLOWING + SERVO)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.timestep = 1e-4
    data = mujoco.MjData(model)
    data.ctrl[0] = 12.0
    scene = stark.Scene()
    robot = scene.add_robot(file)
    assert robot.coordinates == ("l", "t")
    # Two times half of both: an actuator length of 3 times the coordinate.
    joint = robot.description.joints["l"]
    assert joint.servo == stark.robots.description.Gains(900.0, 90.0) and joint.effort == 90.0
    target = 0.5 * 12.0 / (100.0 * 3.0)
    servo = robot.add_servos("l", target=target)
    sim = stark.Simulation(scene, time_step=1e-3)
    for end in (0.05, 0.1, 0.4):
        sim.run_until(end)
        while data.time < end - 1e-9:
            mujoco.mj_step(model, data)
        # First order in a step of 1 ms, and mujoco's equality gives a little: a hundredth of the way.
        np.testing.assert_allclose(robot.joints["l"].displacement, data.qpos[0], atol=0.01 * target)
        np.testing.assert_allclose(robot.joints["r"].displacement, data.qpos[1], atol=0.02 * target)
    np.testing.assert_allclose(servo.target, target)
    assert "tendon 'split': its length is 1.5 times the coordinate of 'l'" in str(robot.report)
    assert "actuator 'close': targets are coordinates; its control is 600 times them" in str(robot.report)


def test_targets_are_coordinates_where_lengths_are_not(tmp_path: Path) -> None:
    """One finger is drawn at 4 mm and follows 2 mm ahead: the tendon has 3 mm more than the coordinate."""
    hand = HAND.replace('range="0 0.08"', 'range="-.05 0.08" ref="0.004"').replace('range="0 0.04"', "")
    servo = SERVO.replace("general", "position").partition("gainprm")[0] + 'kp="500" kv="20"/></actuator>'
    servo = servo.replace('gear="2"', "").replace("0 255", "-.01 .05")
    file = written_mjcf(tmp_path, hand, FOLLOWING.replace("0 2 0 0 0", "0.002 1 0 0 0") + servo)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    data.ctrl[0] = 0.03
    while data.time < 2.0:
        mujoco.mj_step(model, data)
    scene = stark.Scene()
    robot = scene.add_robot(file)
    report = str(robot.report)
    assert "tendon 'split': its length is 1 times the coordinate of 'l' plus 0.003" in report
    assert "actuator 'close': targets are coordinates; its control is 1 times them plus 0.003" in report
    assert "actuator 'close': ctrlrange: targets are not cut to [-0.013, 0.047]" in report
    robot.add_servos("l", target=0.03 - 0.003)
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(2.0)
    np.testing.assert_allclose(robot.q[0], data.qpos[0], atol=5e-5)  # mujoco's equality gives a little


def test_an_actuator_on_a_joint_that_follows_acts_on_the_one_that_it_follows(tmp_path: Path) -> None:
    servo = '<actuator><position name="p" joint="r" kp="50" kv="3" forcerange="-5 5"/></actuator>'
    robot = stark.Scene().add_robot(written_mjcf(tmp_path, HAND, FOLLOWING + servo))
    joint = robot.description.joints["l"]
    assert joint.servo == stark.robots.description.Gains(200.0, 12.0) and joint.effort == 10.0


@pytest.mark.parametrize(
    ("tendon", "text"),
    [
        (
            '<fixed name="f"><joint joint="l" coef="1"/><joint joint="t" coef="1"/></fixed>',
            "tendon 'f': has several coordinates, of 'l', 't': see docs/coming_from.md",
        ),
        (
            '<fixed name="f"><joint joint="l" coef="2"/><joint joint="r" coef="-1"/></fixed>',
            "tendon 'f': its length is the same for all coordinates of 'l'",
        ),
        ('<spatial name="f"><site site="p"/><site site="s"/></spatial>', "tendon 'f': goes through sites"),
        (
            '<fixed name="f" stiffness="3" range="0 0.1"><joint joint="r" coef="1"/></fixed>',
            "tendon 'f': stiffness, range: give them to joint 'l'",
        ),
    ],
)
def test_the_report_says_what_is_left_out(tmp_path: Path, tendon: str, text: str) -> None:
    actuator = '<actuator><position name="p" tendon="f" kp="50"/></actuator>'
    file = written_mjcf(tmp_path, HAND, f"{FOLLOWING}<tendon>{tendon}</tendon>{actuator}")
    robot = stark.Scene().add_robot(file)
    assert text in str(robot.report)
    kept = "range" in tendon
    assert ("actuator 'p': acts on no single joint" in str(robot.report)) != kept


def test_joints_that_follow_each_other_in_a_circle_are_refused(tmp_path: Path) -> None:
    circle = """<equality><joint joint1="r" joint2="l"/><joint joint1="l" joint2="r"/></equality>
      <actuator><position name="p" joint="r" kp="50"/></actuator>"""
    with pytest.raises(stark.InvalidArgument, match=r"mimics itself, by way of"):
        stark.Scene().add_robot(written_mjcf(tmp_path, HAND, circle))
