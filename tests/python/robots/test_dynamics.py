"""Mass matrices and efforts of motions are those of pinocchio and mujoco, and what a simulation takes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from robots._robots import ARM, random_mjcf, random_urdf

import stark

G = np.array([0.0, 0.0, -9.81])


def of_tree(model: Any, robot: stark.robots.Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q of pinocchio, and its rates for each rate of ours."""
    description, configuration = robot.description, np.zeros(model.nq)
    rates = np.zeros((model.nv, len(q)))
    for joint in description.joints.values():
        if joint.is_moving:
            driver, ratio, offset = description.drive_of(joint)
            row, theirs = robot.coordinates.index(driver), model.joints[model.getJointId(joint.name)]
            value = ratio * q[row] + offset
            values = [value] if theirs.nq == 1 else [np.cos(value), np.sin(value)]
            configuration[theirs.idx_q : theirs.idx_q + theirs.nq] = values
            rates[theirs.idx_v, row] = ratio
    return configuration, rates


@pytest.mark.parametrize("seed", range(4))
def test_urdf_files_have_the_dynamics_of_pinocchio(seed: int, tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    pinocchio = pytest.importorskip("pinocchio")
    file = tmp_path / "tree.urdf"
    file.write_text(random_urdf(seed))
    robot = stark.Scene().add_robot(file, contact=False)
    model = pinocchio.buildModelFromUrdf(str(file))
    data, random, n = model.createData(), np.random.default_rng(seed), len(robot.coordinates)
    for _ in range(5):
        q, qd, qdd = random.uniform(*np.clip(robot.limits, -2.0, 2.0)), *random.normal(size=(2, n))
        theirs, rates = of_tree(model, robot, q)
        mass = pinocchio.crba(model, data, theirs)
        mass = np.triu(mass) + np.triu(mass, 1).T
        np.testing.assert_allclose(robot.mass_matrix(q), rates.T @ mass @ rates, atol=1e-9)
        efforts = rates.T @ pinocchio.rnea(model, data, theirs, rates @ qd, rates @ qdd)
        np.testing.assert_allclose(robot.inverse_dynamics(qdd, q, qd, G), efforts, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_mjcf_files_have_the_dynamics_of_mujoco(seed: int, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    file = tmp_path / "tree.xml"
    file.write_text(random_mjcf(seed))
    robot = stark.Scene().add_robot(file, contact=False)
    model = mujoco.MjModel.from_xml_path(str(file))
    data, random = mujoco.MjData(model), np.random.default_rng(seed)
    q, qd, qdd = (
        random.uniform(-0.5, 0.5, len(robot.coordinates)),
        *random.normal(size=(2, len(robot.coordinates))),
    )
    rates = np.zeros((model.nv, len(q)))
    for joint in robot.description.joints.values():
        if joint.is_moving:
            driver, ratio, offset = robot.description.drive_of(joint)
            row = robot.coordinates.index(driver)
            data.qpos[model.joint(joint.name).qposadr[0]] = ratio * q[row] + offset
            rates[model.joint(joint.name).dofadr[0], row] = ratio
    data.qvel[:] = rates @ qd
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    np.testing.assert_allclose(robot.mass_matrix(q), rates.T @ mass @ rates, atol=1e-9)
    expected = rates.T @ (mass @ rates @ qdd + data.qfrc_bias)
    np.testing.assert_allclose(robot.inverse_dynamics(qdd, q, qd, model.opt.gravity), expected, atol=1e-9)


def test_computed_torques_follow_a_course() -> None:
    """Its efforts and the friction of the joints move an arm in a simulation."""
    pytest.importorskip("yourdfpy")
    scene = stark.Scene()
    joints = ["turn", "shoulder", "elbow", "pitch", "roll"]
    middle, swing = np.array([0.0, 0.6, 1.2, 0.3, 0.0, 0.02]), np.array([0.5, 0.3, 0.3, 0.3, 0.5, 0.0])
    robot = scene.add_robot(ARM, contact=False, q=middle)
    dry = np.array([robot.description.joints[name].friction for name in robot.coordinates])
    wet = np.array([robot.description.joints[name].damping for name in robot.coordinates])
    drives, grip = robot.add_efforts(joints), robot.add_servos("left_slide", stiffness=1e4, damping=1e2)
    sim = stark.Simulation(scene, time_step=1e-3, time={"integrator": "bdf2"})
    assert len(grip.joints) == 1
    w, worst = 4.0, 0.0

    def course(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        c, s = np.cos(w * t), np.sin(w * t)
        return middle + swing * (1.0 - c), w * swing * s, w * w * swing * c

    for _ in range(500):
        now, (q, qd, qdd) = course(sim.time), course(sim.time + 1e-3)
        back = 400.0 * (now[0] - robot.q) + 40.0 * (now[1] - robot.qd)
        drives.target = (robot.inverse_dynamics(qdd + back, q, qd) + dry * np.sign(qd) + wet * qd)[:5]
        assert not sim.step().failed
        worst = max(worst, float(abs(robot.q - q).max()))
    assert worst < 2e-4  # [rad], of swings of up to 1 rad


def test_links_have_the_velocities_of_the_jacobian() -> None:
    pytest.importorskip("yourdfpy")
    scene = stark.Scene()
    robot = scene.add_robot(ARM, contact=False, q={"shoulder": 0.5, "elbow": 1.2})
    sim = stark.Simulation(scene, time_step=0.01)
    robot.qd = [1.0, -0.5, 0.7, 0.3, -2.0, 0.01]
    for name, link in robot.links.items():
        expected = robot.jacobian(name) @ robot.qd
        np.testing.assert_allclose(np.r_[link.velocity, link.angular_velocity], expected, atol=1e-6)
    with pytest.raises(AttributeError, match="cannot assign"):
        robot.links["grip"].velocity = (0, 0, 0)  # type: ignore[misc]
    assert sim.time == 0.0


def test_names_of_other_simulators_are_answered() -> None:
    robot = stark.Scene().add_robot(ARM)
    for name, remedy in (("qpos", "robot.q"), ("dof", "len(robot.coordinates)")):
        with pytest.raises(AttributeError, match=f"write {remedy}".replace("(", r"\(").replace(")", r"\)")):
            getattr(robot, name)
