"""Stages of USD for tests: text with bodies, joints and shapes, and MJCF models rewritten as stages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HEAD = """#usda 1.0
(
    defaultPrim = "robot"
    metersPerUnit = {metre}
    kilogramsPerUnit = {kilogram}
    upAxis = "{up}"
)
"""


def numbers(values: Any) -> str:
    return "(" + ", ".join(repr(float(value)) for value in np.ravel(values)) + ")"


def body(
    name: str, inner: str = "", *, place: Any = (0, 0, 0), turn: Any = (1, 0, 0, 0), mass: float | None = 1.0
) -> str:
    """A body at a place, with a mass and unit moments unless `mass` is None."""
    schemas = '"PhysicsRigidBodyAPI", "PhysicsMassAPI"'
    inertia = (
        ""
        if mass is None
        else f"float physics:mass = {mass!r}\n float3 physics:diagonalInertia = (1, 1, 1)\n"
    )
    return (
        f'def Xform "{name}" (prepend apiSchemas = [{schemas}]) {{\n'
        f"double3 xformOp:translate = {numbers(place)}\nquatd xformOp:orient = {numbers(turn)}\n"
        'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]\n'
        f"{inertia}{inner}\n}}\n"
    )


def shape(
    kind: str, values: str = "", *, place: Any = (0, 0, 0), scale: Any = (1, 1, 1), collides: bool = True
) -> str:
    schemas = '(prepend apiSchemas = ["PhysicsCollisionAPI"])' if collides else ""
    return (
        f'def {kind} "{kind.lower()}" {schemas} {{\n{values}\n'
        f"double3 xformOp:translate = {numbers(place)}\nfloat3 xformOp:scale = {numbers(scale)}\n"
        'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]\n}\n'
    )


def joint(name: str, kind: str, first: str, second: str, inner: str = "", schemas: str = "") -> str:
    """Between bodies of the robot; "" is the world."""
    ends = "".join(f"rel physics:body{k} = </robot/{end}>\n" for k, end in enumerate((first, second)) if end)
    api = f"(prepend apiSchemas = [{schemas}])" if schemas else ""
    return f'def {kind} "{name}" {api} {{\n{ends}{inner}\n}}\n'


def stage(
    folder: Path, inner: str, *, metre: float = 1.0, kilogram: float = 1.0, up: str = "Z", schemas: str = ""
) -> Path:
    file = folder / "robot.usda"
    api = f"(prepend apiSchemas = [{schemas}])" if schemas else ""
    head = HEAD.format(metre=metre, kilogram=kilogram, up=up)
    file.write_text(f'{head}def Xform "robot" {api} {{\n{inner}}}\n')
    return file


def of_mujoco(
    folder: Path, model: Any, *, metre: float = 1.0, kilogram: float = 1.0, turned: bool = False
) -> Path:
    """A model of mujoco in other units, at its reference pose; with `turned`, every second joint names its
    bodies the other way round."""
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    text = ""
    for k in range(1, model.nbody):
        unit = kilogram * metre**2
        inner = (
            f"float physics:mass = {float(model.body_mass[k] / kilogram)!r}\n"
            f"float3 physics:diagonalInertia = {numbers(model.body_inertia[k] / unit)}\n"
            f"quatf physics:principalAxes = {numbers(model.body_iquat[k])}\n"
            f"point3f physics:centerOfMass = {numbers(model.body_ipos[k] / metre)}\n"
        )
        text += body(model.body(k).name, inner, place=data.xpos[k] / metre, turn=data.xquat[k], mass=None)
    for k in range(1, model.nbody):
        text += _joint_of(model, data, k, metre, turned and k % 2 == 0)
    return stage(folder, text, metre=metre, kilogram=kilogram)


def _joint_of(model: Any, data: Any, k: int, metre: float, is_turned: bool) -> str:
    parent, number = int(model.body_parentid[k]), int(model.body_jntadr[k])
    child_name, parent_name = model.body(k).name, "" if parent == 0 else model.body(parent).name
    # The frame of the joint: x along its axis, at its anchor.
    axis = np.array([1.0, 0.0, 0.0]) if number < 0 else np.array(model.jnt_axis[number])
    anchor = np.zeros(3) if number < 0 else np.array(model.jnt_pos[number])
    here = _with_x_along(axis)
    turn, origin = data.xmat[k].reshape(3, 3), data.xpos[k]
    other, base = data.xmat[parent].reshape(3, 3), data.xpos[parent]
    there, place = other.T @ turn @ here, other.T @ (origin + turn @ anchor - base)
    sides = [(parent_name, place, there), (child_name, anchor, here)]
    if is_turned:
        sides.reverse()
    frames = "".join(
        f"point3f physics:localPos{i} = {numbers(position / metre)}\n"
        f"quatf physics:localRot{i} = {numbers(_quaternion(rotation))}\n"
        for i, (_, position, rotation) in enumerate(sides)
    )
    kind = (
        "PhysicsFixedJoint"
        if number < 0
        else ("PhysicsPrismaticJoint" if model.jnt_type[number] == 2 else "PhysicsRevoluteJoint")
    )
    name = f"{child_name}_fixed" if number < 0 else model.joint(number).name
    return joint(name, kind, sides[0][0], sides[1][0], frames)


def _with_x_along(axis: Floats) -> Floats:
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    y = np.cross(axis, other)
    y /= np.linalg.norm(y)
    return np.stack([axis, y, np.cross(axis, y)], axis=1)


def _quaternion(rotation: Floats) -> Floats:
    import mujoco

    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(rotation).ravel())
    return quat
