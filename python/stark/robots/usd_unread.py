"""Values of physics in USD files that nothing reads: named once, with how many prims have them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from stark.robots.usd_stage import Stage

#: First parts of the names of attributes that say something of physics.
_PHYSICS = ("physics", "drive", "limit", "state", "mjc", "newton")
_PHYSX = "physx"
#: What is read, or reported where it is dropped, by the first and the last part of its name.
_READ = {
    "physics": {
        *("mass", "density", "centerOfMass", "diagonalInertia", "principalAxes"),
        *("rigidBodyEnabled", "kinematicEnabled", "collisionEnabled", "jointEnabled"),
        *("localPos0", "localPos1", "localRot0", "localRot1", "axis", "lowerLimit", "upperLimit"),
        *("breakForce", "breakTorque", "excludeFromArticulation"),
        *("gravityMagnitude", "gravityDirection", "approximation"),
        *("staticFriction", "dynamicFriction", "restitution"),
    },
    "drive": {"stiffness", "damping", "maxForce", "type"},
    "limit": {"low", "high"},
    "physxJoint": {"maxJointVelocity", "armature", "jointFriction"},
}


def report_unread(stage: Stage, prims: Iterable[Any]) -> None:
    """``prims``: those without deformable bodies. Values of 0, false or nothing count as not given."""
    found: dict[str, dict[str, int]] = {}
    for prim in prims:
        for attribute in prim.GetAuthoredAttributes():
            first, _, rest = str(attribute.GetName()).partition(":")
            last = rest.rpartition(":")[2]
            is_physics = first in _PHYSICS or first.startswith(_PHYSX)
            if rest and is_physics and last not in _READ.get(first, ()) and _says_something(attribute.Get()):
                names = found.setdefault(first, {})
                names[last] = names.get(last, 0) + 1
    for first, names in found.items():
        listed = ", ".join(f"{last} of {count} prims" for last, count in names.items())
        stage.report.add("dropped", "file", f"{first}: {listed.replace(' 1 prims', ' 1 prim')}: not read")


def report_gravity(stage: Stage, scene: Any) -> None:
    """Of a prim of scenes: a direction other than down. (0, 0, 0), what USD has if left out, is down."""
    value = scene.GetGravityDirectionAttr().Get()
    given = np.zeros(3) if value is None else stage.up @ np.array(value, dtype=np.float64)
    length = float(np.linalg.norm(given))
    if length > 0.0 and np.isfinite(length) and given[2] > -0.999 * length:
        direction = [round(float(part), 6) + 0.0 for part in given / length]
        stage.report.add("dropped", "file", f"gravity along {direction}: that of the simulation holds")


def _says_something(value: Any) -> bool:
    if value is None or isinstance(value, str):
        return bool(value)
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return True
    return bool(np.any(np.isfinite(numbers) & (numbers != 0.0) & (np.abs(numbers) < 1e30)))
