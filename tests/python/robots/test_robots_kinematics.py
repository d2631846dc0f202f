"""Frames, Jacobians and efforts against gravity: pinocchio (URDF) and mujoco (MJCF) have the same numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from robots._robots import ARM, GRAVITY, random_mjcf, random_urdf

import stark.robots
from stark.robots import kinematics
from stark.robots.kinematics import Placement
from stark.robots.weight import Weight

TOLERANCE = 1e-9  # of lengths below 3 m and torques below 200 N m: 1e5 times what doubles round


def trees(folder: Path) -> list[Path]:
    files = []
    for seed in range(4):
        file = folder / f"tree_{seed}.urdf"
        file.write_text(random_urdf(seed))
        files.append(file)
    return [ARM, *files]


def pinocchio_q(model: Any, values: dict[str, float]) -> np.ndarray:
    import pinocchio

    q = pinocchio.neutral(model)
    for name, value in values.items():
        k = model.getJointId(name)
        if model.joints[k].nq == 2:  # continuous
            q[model.joints[k].idx_q : model.joints[k].idx_q + 2] = np.cos(value), np.sin(value)
        else:
            q[model.joints[k].idx_q] = value
    return q


def test_frames_jacobians_and_gravity_of_urdf_files_are_those_of_pinocchio(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    pinocchio = pytest.importorskip("pinocchio")
    for file in trees(tmp_path):
        robot = stark.robots.read(file)
        model = pinocchio.buildModelFromUrdf(str(file))  # mimicking joints are free there
        model.gravity.linear = GRAVITY
        data = model.createData()
        random = np.random.default_rng(7)
        for _ in range(20):
            q = random.uniform(-2.0, 2.0, len(robot.coordinates))
            values = kinematics.joint_values(robot, q)
            other = pinocchio_q(model, values)
            pinocchio.framesForwardKinematics(model, data, other)
            frames = kinematics.placements(robot, q)
            drive = np.zeros((model.nv, len(q)))  # rates of all joints by those of q
            for name in values:
                driver, ratio, _ = robot.drive_of(robot.joints[name])
                column = robot.coordinates.index(driver)
                drive[model.joints[model.getJointId(name)].idx_v, column] = ratio
            for name, frame in frames.items():
                place = data.oMf[model.getFrameId(name)]
                np.testing.assert_allclose(frame.position, place.translation, atol=TOLERANCE)
                np.testing.assert_allclose(frame.rotation, place.rotation, atol=TOLERANCE)
                theirs = pinocchio.computeFrameJacobian(
                    model, data, other, model.getFrameId(name), pinocchio.LOCAL_WORLD_ALIGNED
                )
                ours = kinematics.jacobian(robot, frames, name, frame.position)
                np.testing.assert_allclose(ours, theirs @ drive, atol=TOLERANCE)
            efforts = Weight(robot).efforts_at(frames, GRAVITY)
            theirs = drive.T @ pinocchio.computeGeneralizedGravity(model, data, other)
            np.testing.assert_allclose(efforts, theirs, atol=TOLERANCE)


@pytest.mark.parametrize("seed", range(4))
def test_frames_and_gravity_of_mjcf_files_are_those_of_mujoco(seed: int, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    file = tmp_path / "tree.xml"
    file.write_text(random_mjcf(seed))
    robot = stark.robots.read(file)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    random = np.random.default_rng(seed)
    base = Placement(*robot.placement)
    for _ in range(20):
        q = random.uniform(-1.0, 1.0, len(robot.coordinates))
        values = kinematics.joint_values(robot, q)
        drive = np.zeros((model.nv, len(q)))
        for name, value in values.items():
            data.joint(name).qpos[0] = value
            driver, ratio, _ = robot.drive_of(robot.joints[name])
            drive[model.joint(name).dofadr[0], robot.coordinates.index(driver)] = ratio
        mujoco.mj_forward(model, data)
        frames = kinematics.placements(robot, q, base)
        for name, frame in frames.items():
            np.testing.assert_allclose(frame.position, data.body(name).xpos, atol=TOLERANCE)
            np.testing.assert_allclose(frame.rotation.ravel(), data.body(name).xmat, atol=TOLERANCE)
        efforts = Weight(robot).efforts_at(frames, GRAVITY)
        np.testing.assert_allclose(efforts, drive.T @ data.qfrc_bias, atol=TOLERANCE)


def test_the_equality_of_the_file_is_what_mimics(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    file = tmp_path / "tree.xml"
    file.write_text(random_mjcf(0))
    robot = stark.robots.read(file)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    q = np.random.default_rng(1).uniform(-1.0, 1.0, len(robot.coordinates))
    for name, value in kinematics.joint_values(robot, q).items():
        data.joint(name).qpos[0] = value
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.efc_pos[: data.ne], 0.0, atol=1e-12)
    assert data.ne == 1


def test_wrong_values_of_q_are_named() -> None:
    pytest.importorskip("yourdfpy")
    robot = stark.robots.read(ARM)
    for q, message in (
        ([0.0], r"has the shape \(1,\): must be \(6,\), for turn, shoulder"),
        ({"knee": 1.0}, r"q\['knee'\]: must be a joint with a coordinate of its own: turn"),
        ({"right_slide": 0.0}, r"q\['right_slide'\]: must be a joint with a coordinate of its own"),
        ({"turn": "a"}, r"q\['turn'\] = 'a': must be a number"),
        ([np.nan] * 6, "must be finite"),
    ):
        with pytest.raises(stark.InvalidArgument, match=message):
            kinematics.numbers_of(robot, q)
