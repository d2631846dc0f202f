"""One robot file: stark's description and scene against pinocchio (URDF) or mujoco (MJCF)."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import stark
import stark.robots
from stark.robots import Inertia, RobotDescription, kinematics
from stark.robots.kinematics import WORLD, Placement
from stark.robots.weight import Weight

GRAVITY = np.array([0.3, -0.2, -9.81])  # [m/s^2], in no direction that hides anything
POSES = 20
#: What must agree, and to what: kg, m, kg m^2, m and 1, N m and N.
QUANTITIES = ("mass", "center", "inertia", "frames", "gravity", "scene")
TOLERANCE = 1e-9


@dataclass
class Row:
    """What became of a file: largest differences by quantity, or why it was refused."""

    package: str
    file: str
    links: int = 0
    coordinates: int = 0
    differences: dict[str, float] = field(default_factory=dict)
    outcome: str = "agrees"

    def put(self, quantity: str, ours: Any, theirs: Any) -> None:
        """Keeps the largest difference of two arrays."""
        value = float(np.abs(np.asarray(ours) - np.asarray(theirs)).max(initial=0.0))
        self.differences[quantity] = max(value, self.differences.get(quantity, 0.0))

    def judge(self) -> None:
        """Names what differs by more than rounding."""
        wrong = [name for name, value in self.differences.items() if not value <= TOLERANCE]
        if wrong:
            self.outcome = f"differs: {', '.join(wrong)}"


def compare(package: str, root: Path, file: Path) -> Row:
    """Reads and builds a file and compares it at random q."""
    row = Row(package, str(file.relative_to(root)))
    try:
        robot = stark.robots.read(file, packages={"example-robot-data": root.parent})
    except (stark.Error, ImportError) as error:
        row.outcome = f"refused: {str(error).partition(': ')[2]}"
        return row
    row.links, row.coordinates = len(robot.links), len(robot.coordinates)
    try:
        (_with_pinocchio if file.suffix == ".urdf" else _with_mujoco)(row, robot, file)
    except (ValueError, RuntimeError) as error:
        row.outcome = f"not compared, the other program: {error}"
        return row
    row.judge()
    try:
        _in_a_scene(row, robot)
    except stark.Error as error:
        row.outcome += f"; not built: {str(error).partition(': ')[2]}"
    row.judge()
    return row


def _in_a_scene(row: Row, robot: RobotDescription) -> None:
    """Bodies with their shapes: links stand where kinematics has them, at a q within the limits."""
    scene = stark.Scene()
    shown = scene.add_robot(robot)
    frames = shown.forward_kinematics(shown.q)
    for name, link in shown.links.items():
        row.put("scene", link.position, frames[name].position)
        row.put("scene", link.rotation, frames[name].rotation)


def _random_q(robot: RobotDescription) -> list[np.ndarray]:
    random = np.random.default_rng(7)
    return [random.uniform(-2.0, 2.0, len(robot.coordinates)) for _ in range(POSES)]


def _with_mujoco(row: Row, robot: RobotDescription, file: Path) -> None:
    import mujoco

    # Not MjModel.from_xml_path, which leaves its warnings in a file of the current folder.
    model = mujoco.MjSpec.from_file(str(file)).compile()
    model.opt.gravity[:] = GRAVITY
    model.body_gravcomp[:] = 0.0
    model.opt.disableflags = 0
    data = mujoco.MjData(model)
    names = [model.body(k).name or f"body_{k}" for k in range(model.nbody)]
    joints = {model.joint(k).name or f"joint_{k}": k for k in range(model.njnt)}
    _compare_inertias_with_mujoco(row, robot, model, names)
    base = Placement(*robot.placement) if robot.root != names[0] else WORLD
    for q in _random_q(robot):
        drive = np.zeros((model.nv, len(q)))
        for name, value in kinematics.joint_values(robot, q).items():
            k = joints[name]
            data.qpos[model.jnt_qposadr[k]] = value
            driver, ratio, _ = robot.drive_of(robot.joints[name])
            drive[model.jnt_dofadr[k], robot.coordinates.index(driver)] = ratio
        mujoco.mj_forward(model, data)
        frames = kinematics.placements(robot, q, base)
        for k, name in enumerate(names):
            if name in frames:
                row.put("frames", frames[name].position, data.xpos[k])
                row.put("frames", frames[name].rotation.ravel(), data.xmat[k])
        row.put("gravity", Weight(robot).efforts_at(frames, GRAVITY), drive.T @ data.qfrc_bias)


def _compare_inertias_with_mujoco(row: Row, robot: RobotDescription, model: Any, names: list[str]) -> None:
    import mujoco

    for k, name in enumerate(names):
        inertia = robot.links[name].inertia if name in robot.links else None
        if inertia is None:
            if k > 0:
                row.put("mass", 0.0, model.body_mass[k])
            continue
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, model.body_iquat[k])
        turn = axes.reshape(3, 3)
        row.put("mass", inertia.mass, model.body_mass[k])
        row.put("center", inertia.center, model.body_ipos[k])
        row.put("inertia", inertia.tensor, turn @ np.diag(model.body_inertia[k]) @ turn.T)


def _with_pinocchio(row: Row, robot: RobotDescription, file: Path) -> None:
    import pinocchio

    model = pinocchio.buildModelFromUrdf(str(file))  # joints that mimic are free there
    model.gravity.linear = GRAVITY
    data = model.createData()
    _compare_inertias_with_pinocchio(row, robot, model)
    for q in _random_q(robot):
        values = kinematics.joint_values(robot, q)
        theirs = pinocchio.neutral(model)
        drive = np.zeros((model.nv, len(q)))
        for name, value in values.items():
            joint = model.joints[model.getJointId(name)]
            # Continuous joints have cosine and sine.
            theirs[joint.idx_q : joint.idx_q + joint.nq] = (
                (np.cos(value), np.sin(value)) if joint.nq == 2 else value
            )
            driver, ratio, _ = robot.drive_of(robot.joints[name])
            drive[joint.idx_v, robot.coordinates.index(driver)] = ratio
        pinocchio.framesForwardKinematics(model, data, theirs)
        frames = kinematics.placements(robot, q)
        for name, frame in frames.items():
            place = data.oMf[model.getFrameId(name, pinocchio.FrameType.BODY)]
            row.put("frames", frame.position, place.translation)
            row.put("frames", frame.rotation, place.rotation)
        efforts = drive.T @ pinocchio.computeGeneralizedGravity(model, data, theirs)
        row.put("gravity", Weight(robot).efforts_at(frames, GRAVITY), efforts)


def _compare_inertias_with_pinocchio(row: Row, robot: RobotDescription, model: Any) -> None:
    """Of what moves as one: pinocchio adds what fixed joints connect, in the frame of the joint that moves
    it; what is fixed to the world it leaves out."""
    at = {robot.root: (robot.root, WORLD)}
    parts: dict[str, list[Inertia]] = {}
    for joint in robot.outwards:
        lead, frame = at[joint.parent]
        moved = joint.kind != "fixed"
        at[joint.child] = (joint.child, WORLD) if moved else (lead, frame.at(joint.position, joint.rotation))
    for name, (lead, frame) in at.items():
        inertia = robot.links[name].inertia
        if inertia is not None:
            parts.setdefault(lead, []).append(inertia.moved(*frame))
    for joint in robot.outwards:
        if joint.kind == "fixed":
            continue
        theirs = model.inertias[model.getJointId(joint.name)]
        if joint.child not in parts:
            row.put("mass", 0.0, theirs.mass)
            continue
        mass = sum(part.mass for part in parts[joint.child])
        row.put("mass", mass, theirs.mass)
        if mass == 0.0:
            continue
        ours = Inertia.sum(parts[joint.child])
        row.put("center", ours.center, theirs.lever)
        row.put("inertia", ours.tensor, theirs.inertia)
