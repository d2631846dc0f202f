"""``scene.add_joint`` and its short forms: frames from bodies, anchors and axes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import given_flag, given_name, real_number, refuse_unknown_values
from stark.bodies import Body
from stark.body_kinds import has_frames, has_pose
from stark.formulas.parameters import Parameter, check_range, numbers_of
from stark.handle import SceneLink
from stark.joints.definition import JointFormula, built_in
from stark.joints.handle import Joint
from stark.rotations import as_matrix, direction, vector
from stark.selections import FrameHandle, rigid_frame, world_frame

Floats = NDArray[np.float64]
_OPTIONS = ("anchor", "axis", "rotation", "name", "contact", "enabled", "break_force", "break_torque")


def add_joint(
    scene: SceneLink,
    kind: str | JointFormula,
    a: Any,
    b: Any,
    *,
    anchor: ArrayLike | None,
    axis: str | ArrayLike | None,
    rotation: ArrayLike | None,
    name: str | None,
    contact: bool,
    enabled: bool,
    break_force: float | None,
    break_torque: float | None,
    values: Mapping[str, Any],
) -> Joint:
    """Adds a joint to a scene; InvalidArgument says what is wrong with it."""
    formula = kind if isinstance(kind, JointFormula) else built_in(_text(kind))
    formula.warn_of_changes()
    owner = f"joint '{given_name(name) or formula.name}'"
    contact, enabled = given_flag(contact, f"{owner}: contact"), given_flag(enabled, f"{owner}: enabled")
    numbers = _values(owner, formula, values)  # before the frames: an anchor may be misspelt
    place = None
    if anchor is not None or axis is not None or rotation is not None:
        _require_a_use(owner, (a, b), anchor=anchor, axis=axis, rotation=rotation)
        place = _placement(owner, anchor, axis, rotation)
    else:
        place = next((_placement_of(side) for side in (a, b) if _is_one_frame(side)), None)
    frames = [_frame(scene, owner, label, side, place) for label, side in (("a", a), ("b", b))]
    given = {
        "a": frames[0],
        "b": frames[1],
        "values": numbers,
        "break_force": _limit(owner, "break_force", break_force, "N"),
        "break_torque": _limit(owner, "break_torque", break_torque, "N m"),
    }
    _require_held(owner, formula, given)
    index = scene._core.add_joint(
        {
            "name": given_name(name),
            "definition": formula.core,
            "enabled": enabled,
            "contact": contact,
            **given,
        }
    )
    return Joint(scene, index, formula, enabled, given)


def _require_a_use(owner: str, sides: tuple[Any, Any], **given: Any) -> None:
    """What is given for both sides at a common place has to be of use to one of them."""
    if all(isinstance(side, FrameHandle) for side in sides):
        named = " and ".join(name for name, value in given.items() if value is not None)
        raise InvalidArgument(
            f"{owner}: {named} of no use, as both sides have frames of their own: must be left out; give "
            f"position= and rotation= to the frames, or a body in place of one of them"
        )


def _limit(owner: str, what: str, given: float | None, unit: str) -> float:
    if given is None:
        return math.inf
    number = real_number(given, f"{owner}: {what}")
    if not number > 0.0:
        raise InvalidArgument(
            f"{owner}: {what} = {given!r} {unit}: must be a number > 0; leave it out for joints that do "
            f"not break"
        )
    return number


#: Joints whose reaction has no force, or no torque about the origin of frame b, and what to give instead.
_NEVER_BREAK = {
    ("orientation", "break_force"): "it holds no point; give break_torque",
    ("ball", "break_torque"): "it holds a point alone; give break_force",
    ("point_on_axis", "break_torque"): "it holds a point alone; give break_force",
    ("distance", "break_torque"): "it pulls and pushes along a line alone; give break_force",
}


def _require_held(owner: str, formula: JointFormula, given: dict[str, Any]) -> None:
    """A joint that holds nothing has no reaction, and cannot break."""
    for (kind, limit), remedy in _NEVER_BREAK.items():
        if formula.residuals is None and formula.name == kind and math.isfinite(given[limit]):
            raise InvalidArgument(f"{owner}: {limit} = {given[limit]:g}: must be left out: {remedy}")
    holds = bool(formula.groups) if formula.residuals is not None else formula.name not in ("span", "tilt")
    what = next((name for name in ("break_force", "break_torque") if math.isfinite(given[name])), None)
    if what is not None and not holds:
        raise InvalidArgument(
            f"{owner}: {what} = {given[what]:g}: must be left out, as the joint holds nothing that could "
            f"break; add_distance holds two points"
        )


def place_side(scene: SceneLink, owner: str, label: str, side: Any, position: Floats) -> FrameHandle:
    """Frame of a side at a place of the world, with the axes of the world."""
    owner = f"{owner}: side {label}"
    if isinstance(side, str):
        side = scene[side] if side != "world" or "world" in scene else None
    if side is None:
        return world_frame(position)
    if isinstance(side, FrameHandle):
        return side
    if not (isinstance(side, Body) and has_pose(side)):
        raise InvalidArgument(
            f"{owner} = {side!r}: must be a rigid body, a frame such as cloth.frame((i, j, k)) or "
            f"rod.frame(node), or None for the world"
        )
    origin, axes = scene._core.pose(side._index)
    return rigid_frame(side, axes.T @ (position - origin), axes.T)


def frame_with_z(axis: str | ArrayLike, owner: str) -> Floats:
    """A rotation whose third column is the axis."""
    z = direction(axis, f"{owner}: axis")
    z = z / np.linalg.norm(z)
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _placement(
    owner: str, anchor: ArrayLike | None, axis: str | ArrayLike | None, rotation: ArrayLike | None
) -> tuple[Floats, Floats]:
    """Position and rotation in the world at time 0 that both frames get."""
    if anchor is None:
        raise InvalidArgument(
            f"{owner}: axis or rotation without anchor: give anchor=(x, y, z) [m] in the world"
        )
    if axis is not None and rotation is not None:
        raise InvalidArgument(f"{owner}: axis and rotation are both given: give one of them")
    position = vector(anchor, f"{owner}: anchor")
    if axis is not None:
        return position, frame_with_z(axis, owner)
    return position, as_matrix(rotation, f"{owner}: rotation")


def _frame(
    scene: SceneLink, owner: str, label: str, side: Any, place: tuple[Floats, Floats] | None
) -> dict[str, Any]:
    """A side as the core reads it."""
    owner = f"{owner}: side {label}"
    if isinstance(side, str):
        side = scene[side] if side != "world" or "world" in scene else None
    if isinstance(side, FrameHandle):
        return _explicit(scene, owner, side)
    if side is not None and not isinstance(side, Body):
        raise InvalidArgument(
            f"{owner} = {side!r}: must be a rigid body, a frame such as box.frame(...) or "
            f"cloth.frame(vertices), or "
            f"None for the world"
        )
    if place is None:
        raise InvalidArgument(
            f"{owner}: no anchor: give anchor=(x, y, z) [m] in the world, or frames on both sides"
        )
    position, rotation = place
    if side is None:
        return _described("world", position, rotation)
    if side._scene is not scene:
        raise InvalidArgument(f"{owner}: '{side.name}' belongs to another scene: must be a body of this one")
    if has_frames(side):
        raise InvalidArgument(
            f"{owner}: '{side.name}' is a rod: say which node, {side.name}.frame(0) at its start or "
            f"{side.name}.frame(-1) at its end"
        )
    if not has_pose(side):
        raise InvalidArgument(
            f"{owner}: '{side.name}' is a {side.kind} body: give a patch of it, {side.name}.frame((i, j, "
            f"k)), three "
            f"vertices that carry the joint"
        )
    origin, axes = scene._core.pose(side._index)
    return _described("body", axes.T @ (position - origin), axes.T @ rotation, side._index)


def _explicit(scene: SceneLink, owner: str, frame: FrameHandle) -> dict[str, Any]:
    if len(frame) != 1:
        raise InvalidArgument(f"{owner}: {frame!r} is {len(frame)} frames: a joint has one on each side")
    body = frame.columns[0].body
    if body is not None and body._scene is not scene:
        raise InvalidArgument(f"{owner}: '{body.name}' belongs to another scene: must be a body of this one")
    if frame.kind == "patch":
        assert body is not None
        corners = np.array([column._columns["vertices"][0] for column in frame.columns], dtype=np.int32)
        position, rotation = _patch_placement(frame)
        return _described("patch", position, rotation, body._index) | {"vertices": corners}
    if frame.columns[0]._kind == "node_point":
        assert body is not None
        node = {"node": frame.columns[0]._columns["node"]}
        return _described("node", *_placement_of(frame), body._index) | node
    local = [np.asarray(column._columns["local"][0], dtype=np.float64) for column in frame.columns]
    rotation = np.column_stack(local[1:])
    return _described("world" if body is None else "body", local[0], rotation, body and body._index)


def _patch_placement(frame: FrameHandle) -> tuple[Floats, Floats]:
    """Where a patch frame is at time 0."""
    p = np.array([column.positions[0] for column in frame.columns])
    normal = np.cross(p[1] - p[0], p[2] - p[0])
    normal /= np.linalg.norm(normal)
    tangent = (p[1] - p[0]) / np.linalg.norm(p[1] - p[0])
    axes = np.column_stack([tangent, np.cross(normal, tangent), normal])
    position = frame.constants["weights"] @ p + frame.constants["offset"] * normal
    return position, axes @ frame.constants["rotation"].reshape(3, 3)


def _is_one_frame(side: Any) -> bool:
    return isinstance(side, FrameHandle) and len(side) == 1


def _placement_of(frame: FrameHandle) -> tuple[Floats, Floats]:
    """Where a frame is at time 0: a body on the other side gets the same one."""
    if frame.kind == "patch":
        return _patch_placement(frame)
    places = np.array([column.positions[0] for column in frame.columns])
    return places[0], places[1:].T


def _described(carrier: str, position: Floats, rotation: Floats, body: Any = None) -> dict[str, Any]:
    frame = {
        "carrier": carrier,
        "position": np.ascontiguousarray(position, dtype=np.float64),
        "rotation": np.ascontiguousarray(rotation, dtype=np.float64).reshape(-1),
    }
    return frame if body is None else frame | {"body": body}


def _values(owner: str, formula: JointFormula, given: Mapping[str, Any]) -> dict[str, tuple[Floats, bool]]:
    known = [parameter.name for parameter in formula.parameters]
    refuse_unknown_values(owner, given, known, _OPTIONS, f"a joint of the kind '{formula.name}'")
    values = {}
    for parameter in formula.parameters:
        value = given.get(parameter.name, parameter.declaration.default)
        if value is None:
            raise InvalidArgument(f"{owner}: {parameter.describe()} has no value: must be given")
        values[parameter.name] = (_checked(owner, parameter, value), False)
    return values


def _checked(owner: str, parameter: Parameter, value: Any) -> Floats:
    array = numbers_of(owner, parameter, value)
    if array.shape != parameter.shape:
        raise InvalidArgument(
            f"{owner}: {parameter.describe()} has the shape {array.shape}: must be "
            f"{parameter.shape or 'a number'}"
        )
    check_range(owner, parameter, array, False)
    return np.ascontiguousarray(array).reshape(-1)


def _text(kind: Any) -> str:
    if not isinstance(kind, str):
        raise InvalidArgument(
            f"scene.add_joint: kind = {kind!r}: must be the name of a built-in joint or a function with "
            f"@stark.joint"
        )
    return kind
