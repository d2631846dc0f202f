"""Velocities at the start that joints do not allow: what is said of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_HOLD_A_POINT = ("ball", "fixed", "hinge", "universal")
_SMALL = 0.05  # share of the speeds: what is rounded by hand is no cause for a word
_SLOW = 1e-3  # [m/s]


def unfit_start_warnings(core: Any, simulation: Any, joints: Iterable[Any]) -> list[str]:
    """One for each joint whose sides start with different velocities where it holds them together. The first
    step takes that away, and most of the rotation of a bar with it that was given an ``angular_velocity``
    about its end, but no velocity of its centre of mass."""
    found = []
    for joint in joints:
        sides = joint._given["a"], joint._given["b"]
        if joint._formula.residuals is not None or joint.kind not in _HOLD_A_POINT:
            continue
        bodies = [side["body"] for side in sides if side["carrier"] == "body"]
        if not bodies or any(side["carrier"] not in ("body", "world") for side in sides):
            continue
        if not simulation.joint_enabled(joint._index):
            continue
        if any(core.motion(body) == "scripted" for body in bodies):
            continue  # they have their own way to start
        velocities = [_velocity(simulation, side) for side in sides]
        centers = [simulation.center_velocity(k) for k in bodies if core.motion(k) == "dynamic"]
        speed = max(float(np.linalg.norm(v)) for v in (*velocities, *centers))
        apart = float(np.linalg.norm(velocities[1] - velocities[0]))
        if apart > max(_SMALL * speed, _SLOW):
            found.append(_text(core, joint, sides, apart))
    return found


def _velocity(simulation: Any, side: Mapping[str, Any]) -> Floats:
    """Of the point that a joint holds, on one of its sides [m/s]."""
    if side["carrier"] == "world":
        return np.zeros(3)
    linear, angular = simulation.twist(side["body"])
    _, rotation = simulation.pose(side["body"])
    moving: Floats = linear + np.cross(angular, rotation @ side["position"])
    return moving


def _text(core: Any, joint: Any, sides: tuple[Mapping[str, Any], ...], apart: float) -> str:
    names = [f"'{core.name(s['body'])}'" if s["carrier"] == "body" else "the world" for s in sides]
    rates = f"assign {joint.name}.rates after the simulation is made, or " if joint._coordinates else ""
    return (
        f"joint '{joint.name}': at 0 s {names[1]} moves at {apart:.3g} m/s relative to {names[0]} where the "
        f"joint holds it, and the first step takes that away, as an impact would: {rates}give velocities "
        f"that fit; velocity= is that of the centre of mass, and angular_velocity= leaves it as it is"
    )
