"""Loads, actuators and joints on what does not move by forces: what is said of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

#: Formulas of stark.loads whose only effect is their force on the points that were given.
_LOADS = ("force", "torque", "traction", "face_pressure")
#: Joints that hold nothing wherever they are.
_MEASURES = ("span", "tilt")


def idle_load_warnings(energies: Iterable[Any]) -> list[str]:
    """One for each load all of whose points are prescribed: of the world, of bodies that are fixed or
    scripted, pinned. It moves nothing, which nothing else shows."""
    found = []
    for energy in energies:
        binding = energy._binding
        if binding.name not in _LOADS:
            continue
        reasons = [_held(column) for column in binding.columns]
        if all(reasons) and _is_load(binding):
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
        held = _prescribed(core, (joint for joint, _ in actuator.coordinates))
        if held is not None:
            found.append(
                f"actuator '{actuator.name}' moves nothing: {held}: must act between bodies of which at "
                f"least one moves freely; add it with motion='dynamic'"
            )
    return found


def idle_joint_warnings(core: Any, joints: Iterable[Any], actuators: Iterable[Any]) -> list[str]:
    """One for each joint that holds prescribed bodies together, or one of them and the world, which keep to
    what is prescribed whatever it says. Those of an actuator, of which more is said, are left out."""
    driven = {joint._index for actuator in actuators for joint, _ in actuator.coordinates}
    found = []
    for joint in joints:
        formula = joint._formula
        holds = bool(formula.groups) if formula.residuals is not None else joint.kind not in _MEASURES
        if not holds or not joint._enabled_at_start or joint._index in driven:
            continue
        held = _prescribed(core, [joint])
        if held is not None:
            found.append(
                f"joint '{joint.name}' holds nothing: {held}: at least one of its bodies must move freely; "
                f"add one with motion='dynamic', or leave the joint out; add_span and add_tilt measure "
                f"without holding"
            )
    return found


def _prescribed(core: Any, joints: Iterable[Any]) -> str | None:
    """What bodies the joints have, if all are prescribed or the world; None if one moves freely."""
    sides = [joint._given[side] for joint in joints for side in "ab"]
    if not all(_is_prescribed(core, side) for side in sides):
        return None
    bodies = dict.fromkeys(side["body"] for side in sides if side["carrier"] == "body")
    return ", ".join(f"'{core.name(body)}' is {core.motion(body)}" for body in bodies)


def _is_load(binding: Any) -> bool:
    """Whether an energy is one of stark.loads, not one of a user that has its name. Formulas that a document
    holds have no function and are compared by what they compute."""
    if not binding.energy.is_read:
        return str(binding.energy.function.__module__).startswith("stark.loads.")
    from stark.formulas.frames import KINDS
    from stark.formulas.listing import listed
    from stark.loads import formulas, surface_loads

    own = getattr(formulas, binding.name, None) or getattr(surface_loads, binding.name)
    read = listed(binding.trace.graph, binding.trace.sources)
    traces = [own.trace([kind]) for kind in KINDS] if binding.name == "torque" else [own.trace()]
    return any(listed(trace.graph, trace.sources) == read for trace in traces)


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
