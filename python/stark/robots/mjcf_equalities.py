"""Equalities of MJCF models: joints that follow others, and what closes loops."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.robots.description import Closure, Mimic
from stark.robots.kinematics import Placement
from stark.robots.report import Report
from stark.rotations import as_matrix

Floats = NDArray[np.float64]

# Numbers of mujoco's enumerations, which are part of its interface.
_CONNECT, _WELD, _EQUAL_JOINTS = 0, 1, 2
_SITE = 6

#: Joints of a scene that hold what equalities hold.
_KINDS = {_CONNECT: "ball", _WELD: "fixed"}


def title_of(model: Any, k: int) -> str:
    """Of an equality, as reports call it."""
    return f"equality '{_name_of(model, k)}'"


def read_mimics(model: Any, joint_names: list[str], report: Report) -> dict[int, Mimic]:
    """By joint: those that follow another one, as active linear equalities say."""
    found: dict[int, Mimic] = {}
    for k in range(model.neq):
        if int(model.eq_type[k]) in _KINDS:
            continue
        a, b = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
        shape = [float(value) for value in model.eq_data[k][:5]]
        linear = int(model.eq_type[k]) == _EQUAL_JOINTS and b >= 0 and not any(shape[2:])
        if not linear or not model.eq_active0[k] or a in found:
            report.add("dropped", title_of(model, k), "only active linear ones of two joints are kept")
            continue
        at_rest = [float(model.qpos0[int(model.jnt_qposadr[joint])]) for joint in (a, b)]
        offset = shape[0] + at_rest[0] - shape[1] * at_rest[1]
        found[a] = Mimic(joint_names[b], shape[1], offset)
    return found


def closes_to_world(model: Any) -> bool:
    """Whether an equality holds a body to the world: that has to be a link, then."""
    return any(0 in _bodies(model, k) for k in _closing(model))


def read_closures(model: Any, bodies: list[str], used: Iterable[int], report: Report) -> list[Closure]:
    """Those of the bodies ``used``, whose names are ``bodies``."""
    found, links = [], set(used)
    for k in _closing(model):
        a, b = _bodies(model, k)
        remedy = f"; what it holds together, scene.add_{_KINDS[int(model.eq_type[k])]} holds"
        if not model.eq_active0[k]:
            report.add("dropped", title_of(model, k), f"is not active at the start{remedy}")
        elif any(int(model.body_mocapid[body]) >= 0 for body in (a, b)):
            report.add("dropped", title_of(model, k), f"holds a mocap body: make it a scripted one{remedy}")
        elif not {a, b} <= links:
            report.add("dropped", title_of(model, k), f"holds a body outside of the robot{remedy}")
        else:
            kind = _KINDS[int(model.eq_type[k])]
            found.append(Closure(_name_of(model, k), kind, (bodies[a], bodies[b]), _frames(model, k)))
            report.add("kept", title_of(model, k), f"a {kind} joint of '{bodies[a]}' and '{bodies[b]}'")
    return found


def _name_of(model: Any, k: int) -> str:
    return str(model.equality(k).name) or f"equality_{k}"


def _closing(model: Any) -> list[int]:
    return [k for k in range(model.neq) if int(model.eq_type[k]) in _KINDS]


def _by_sites(model: Any, k: int) -> bool:
    return int(model.eq_objtype[k]) == _SITE


def _bodies(model: Any, k: int) -> tuple[int, int]:
    first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
    if _by_sites(model, k):
        return int(model.site_bodyid[first]), int(model.site_bodyid[second])
    return first, max(second, 0)


def _frames(model: Any, k: int) -> tuple[Placement, Placement]:
    """In both bodies; they agree while the equality holds."""
    data: Floats = np.array(model.eq_data[k], dtype=np.float64)
    if _by_sites(model, k):
        first, second = (
            Placement(np.array(model.site_pos[site]), as_matrix(model.site_quat[site], "site"))
            for site in (int(model.eq_obj1id[k]), int(model.eq_obj2id[k]))
        )
        return first, second
    if int(model.eq_type[k]) == _CONNECT:
        return Placement(data[:3], np.eye(3)), Placement(data[3:6], np.eye(3))
    return Placement(data[3:6], as_matrix(data[6:10], "weld")), Placement(data[:3], np.eye(3))
