"""Loads and actuators on what does not move by forces: what is said of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

#: Formulas of stark.loads whose only effect is their force on the points that were given.
_LOADS = ("force", "torque", "traction", "face_pressure")


def idle_load_warnings(energies: Iterable[Any]) -> list[str]:
    """One for each load all of whose points are prescribed: of the world, of bodies that are fixed or
    scripted, pinned. It moves nothing, which nothing else shows."""
    found = []
    for energy in energies:
        binding = energy._binding
        function = getattr(binding.energy, "function", None)  # None of formulas that a document holds
        if binding.name not in _LOADS or not getattr(function, "__module__", "").startswith("stark.loads."):
            continue
        reasons = [_held(column) for column in binding.columns]
        if all(reasons):
            what = ", ".join(dict.fromkeys(reason for reason in reasons if reason))
            found.append(
                f"{binding.name.replace('_', ' ')} '{energy.name}' moves nothing: {what}: must act on what "
                f"moves freely; add the body with motion='dynamic', or choose points that are not pinned"
            )
    return found


def idle_actuator_warnings(core: Any, actuators: Iterable[Any]) -> list[str]:
    """One for each actuator, springs among them, all of whose joints are between prescribed bodies or one of
    them and the world."""
    found = []
    for actuator in actuators:
        sides = [joint._given[side] for joint, _ in actuator.coordinates for side in "ab"]
        if not all(_is_prescribed(core, side) for side in sides):
            continue
        bodies = dict.fromkeys(side["body"] for side in sides if side["carrier"] == "body")
        what = ", ".join(f"'{core.name(body)}' is {core.motion(body)}" for body in bodies)
        found.append(
            f"actuator '{actuator.name}' moves nothing: {what}: must act between bodies of which at least "
            f"one moves freely; add it with motion='dynamic'"
        )
    return found


def _is_prescribed(core: Any, side: Mapping[str, Any]) -> bool:
    if side["carrier"] == "body":
        return str(core.motion(side["body"])) != "dynamic"
    return str(side["carrier"]) == "world"


def _held(column: Any) -> str | None:
    """Why forces do not move any of some points; None where they may."""
    bodies = column.bodies
    if not bodies:
        return "it acts on the world"
    if all(body.motion != "dynamic" for body in bodies):
        return ", ".join(f"'{body.name}' is {body.motion}" for body in bodies)
    vertices = getattr(column, "_columns", {}).get("vertices")
    pins = getattr(bodies[0], "pins", None)
    if len(bodies) == 1 and vertices is not None and pins is not None and np.isin(vertices, pins).all():
        return f"all of its points of '{bodies[0].name}' are pinned"
    return None
