"""``scene.add_actuator``: what it acts on, values, checks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stark._core import InvalidArgument
from stark.actuators.definition import ActuatorFormula, built_in
from stark.arguments import given_flag, given_name, real_number, refuse_unknown_values
from stark.caller import warn
from stark.courses import set_courses, starts
from stark.handle import SceneLink
from stark.joints.handle import Actuator, Joint

_DRIVES = {
    "position_servo": ("servo", "target, stiffness, damping and cap"),
    "velocity_motor": ("motor", "target, cap and delta"),
}
"""Kinds that drive a coordinate to a value, of which one is enough: word and what can be assigned."""


def add_actuator(
    scene: SceneLink,
    kind: str | ActuatorFormula,
    on: Any,
    *,
    name: str | None,
    enabled: bool,
    values: Mapping[str, Any],
) -> Actuator:
    """Adds an actuator to a scene; InvalidArgument says what is wrong with it."""
    formula = kind if isinstance(kind, ActuatorFormula) else built_in(_text(kind))
    formula.warn_of_changes()
    owner = f"actuator '{given_name(name) or formula.name}'"
    targets = [_target(scene, owner, entry) for entry in _entries(owner, on)]
    _check_names(owner, formula, values)
    index = scene._core.add_actuator(
        {
            "name": given_name(name),
            "definition": formula.core,
            "on": [(joint._index, coordinate) for joint, coordinate in targets],
            "values": {
                key: real_number(value, f"{owner}: {key}") for key, value in starts(values, owner).items()
            },
            "enabled": given_flag(enabled, f"{owner}: enabled"),
        }
    )
    actuator = Actuator(scene, index, formula, tuple(_located(*target) for target in targets))
    set_courses("actuator", actuator, values)
    if enabled is True and not isinstance(kind, ActuatorFormula):
        _warn_of_another(kind, actuator)
    return actuator


def _warn_of_another(kind: str, added: Actuator) -> None:
    """Of a second servo or motor on the same coordinate: whoever adds it wants other gains or another target
    more often than both at once."""
    if kind not in _DRIVES:
        return
    joint, coordinate = added.coordinates[0]
    for other in joint.actuators:
        is_another = other._index != added._index and other.kind == kind
        if is_another and other.coordinates[0][1] == coordinate and other.enabled:
            word, values = _DRIVES[kind]
            warn(
                f"joint '{joint.name}': '{other.name}' is a {word} on its {coordinate} already: both act, "
                f"and their efforts add up; assign {values} of that one instead, or add the other with "
                f"enabled=False and switch between them"
            )
            return


def _check_names(owner: str, formula: ActuatorFormula, values: Mapping[str, Any]) -> None:
    """Before the values: a misspelt option, which need not be a number, is called unknown."""
    units = [""] * formula.coordinate_count
    known = [parameter["name"] for parameter in formula.core.parameters(units)]
    kind = f"an actuator of the kind '{formula.name}'"
    refuse_unknown_values(owner, values, known, ("name", "enabled", "coordinate"), kind)


def _entries(owner: str, on: Any) -> list[Any]:
    """Joints, or (joint, coordinate) pairs, that were given."""
    if isinstance(on, Joint) or (isinstance(on, tuple) and len(on) == 2 and isinstance(on[1], str)):
        return [on]
    if isinstance(on, (list, tuple)):
        return list(on)
    raise InvalidArgument(
        f"{owner}: on = {on!r}: must be a joint, (joint, 'coordinate'), or a list of them for a gear"
    )


def _target(scene: SceneLink, owner: str, entry: Any) -> tuple[Joint, str]:
    joint, coordinate = entry if isinstance(entry, tuple) and len(entry) == 2 else (entry, "")
    if not isinstance(joint, Joint) or not isinstance(coordinate, str):
        raise InvalidArgument(f"{owner}: on = {entry!r}: must be a joint or (joint, 'coordinate')")
    if joint._scene is not scene:
        raise InvalidArgument(
            f"{owner}: '{joint.name}' belongs to another scene: must be a joint of this one"
        )
    return joint, coordinate


def _located(joint: Joint, coordinate: str) -> tuple[Joint, str, str]:
    """With the name, which may be left out of joints with one coordinate, and the unit."""
    for name, unit in joint.formula.coordinates:
        if coordinate in ("", name):
            return joint, name, unit
    raise AssertionError(f"the core took the coordinate '{coordinate}'")


def _text(kind: Any) -> str:
    if not isinstance(kind, str):
        raise InvalidArgument(
            f"scene.add_actuator: kind = {kind!r}: must be the name of a built-in actuator or a function "
            f"with @stark.actuator"
        )
    return kind
