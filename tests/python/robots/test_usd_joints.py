"""Limits, drives and free axes of joints of USD files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._stages import body, joint, stage

import stark
from stark.robots import kinematics

pytest.importorskip("pxr")

HINGE = 'uniform token physics:axis = "Z"\n'


def test_limits_and_drives(tmp_path: Path) -> None:
    values = (
        HINGE + "float physics:lowerLimit = -90\nfloat physics:upperLimit = 180\n"
        "float drive:angular:physics:maxForce = 40000\nfloat drive:angular:physics:stiffness = 100\n"
        "float physxJoint:maxJointVelocity = 360\nfloat physxJoint:armature = 2000\n"
    )
    made = joint("j", "PhysicsRevoluteJoint", "a", "b", values, '"PhysicsDriveAPI:angular"')
    slider = joint("s", "PhysicsPrismaticJoint", "b", "c", HINGE + "float physics:lowerLimit = -25\n")
    file = stage(tmp_path, body("a") + body("b") + body("c") + made + slider, metre=0.01)
    robot = stark.robots.read(file)
    j, s = robot.joints["j"], robot.joints["s"]
    assert (j.kind, s.kind) == ("revolute", "prismatic")
    assert (j.lower, j.upper) == pytest.approx((-np.pi / 2, np.pi))
    assert (j.effort, j.velocity, j.armature) == pytest.approx((4.0, 2 * np.pi, 0.2))
    assert s.lower == pytest.approx(-0.25) and s.upper is None
    assert j.servo is not None and j.servo.stiffness == pytest.approx(0.572958)  # 100 kg cm^2/s^2 a degree
    assert "stiffness 0.572958 and damping 0 of drive 'angular' in SI units" in str(robot.report)


def test_a_joint_with_free_axes_is_a_row_of_joints(tmp_path: Path) -> None:
    locked = "".join(
        f"float limit:{axis}:physics:low = 1\nfloat limit:{axis}:physics:high = -1\n"
        for axis in ("transX", "transY", "transZ", "rotY")
    )
    schemas = ", ".join(f'"PhysicsLimitAPI:{axis}"' for axis in ("transX", "transY", "transZ", "rotY"))
    made = joint("j", "PhysicsJoint", "a", "b", locked, schemas)
    robot = stark.robots.read(stage(tmp_path, body("a") + body("b") + made))
    assert robot.coordinates == ("j_rotX", "j_rotZ")
    assert robot.links["b_after_j_rotX"].between == "b"
    frame = kinematics.placements(robot, np.array([0.3, 0.5]))["b"]
    x, z = stark.rotation(axis="x", angle=0.3), stark.rotation(axis="z", angle=0.5)
    np.testing.assert_allclose(frame.rotation, x @ z, atol=1e-9)
    fixed = joint("ground", "PhysicsFixedJoint", "", "b")
    back = stark.robots.read(stage(tmp_path, body("a") + body("b") + made + fixed))
    assert back.root == "b" and back.coordinates == ("j_rotZ", "j_rotX")
    frame = kinematics.placements(back, np.array([0.5, 0.3]))["a"]
    np.testing.assert_allclose(frame.rotation, (x @ z).T, atol=1e-9)


def test_parts_without_which_a_robot_moves_otherwise_are_warned_of(tmp_path: Path) -> None:
    """A mimicking finger hung loose, and a loop was open, of which only the report told."""
    pair = joint("j", "PhysicsRevoluteJoint", "a", "b", HINGE)
    finger = joint("k", "PhysicsRevoluteJoint", "a", "c", HINGE, '"PhysxMimicJointAPI:rotZ"')
    loop = joint(
        "l", "PhysicsRevoluteJoint", "b", "c", HINGE + "bool physics:excludeFromArticulation = true\n"
    )
    file = stage(tmp_path, body("a") + body("b") + body("c") + pair + finger + loop)
    with pytest.warns(stark.StarkWarning) as caught:
        stark.Scene().add_robot(file, contact=False)
    said = " ".join(str(warning.message) for warning in caught)
    assert "joint 'k': mimics another joint: use joint.add_gear" in said
    assert "joint 'l': closes a loop, excludeFromArticulation is set; close it with scene.add_joint" in said
