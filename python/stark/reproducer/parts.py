"""Objects of the core that calls on a scene hold, as data and back: materials by their numbers, laws, joints
and actuators by their names where they are built in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stark import _core
from stark.actuators import definition as actuators
from stark.joints import definition as joints
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial

_MATERIALS: dict[str, type[Any]] = {
    kind.__name__: kind for kind in (_core.ShellMaterial, _core.SolidMaterial, _core.RodMaterial)
}
_LAWS: dict[str, tuple[type[Any], dict[str, Any]]] = {
    "ShellLaw": (_core.ShellLaw, ShellMaterial._laws),
    "SolidLaw": (_core.SolidLaw, SolidMaterial._laws),
    "RodLaw": (_core.RodLaw, RodMaterial._laws),
}
_DEFINITIONS: dict[str, tuple[type[Any], Callable[[str], Any]]] = {
    "JointDefinition": (_core.JointDefinition, joints.built_in),
    "ActuatorDefinition": (_core.ActuatorDefinition, actuators.built_in),
}


class NotDataError(Exception):
    """A formula of the user's own; the text names it."""


def as_data(value: Any) -> Any:
    """Plain data in place of objects of the core. Raises NotDataError for formulas."""
    if isinstance(value, dict):
        return {key: as_data(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(as_data(item) for item in value)
    for name, kind in _MATERIALS.items():
        if isinstance(value, kind):
            return {"core": name, "fields": value.to_dict()}
    for name, (kind, known) in _LAWS.items():
        if isinstance(value, kind):
            title = str(getattr(value, "name", ""))
            if known.get(title) is not value:
                raise NotDataError(f"law '{title}'")
            return {"core": name, "name": title}
    for name, (kind, find) in _DEFINITIONS.items():
        if isinstance(value, kind):
            if not _is_built_in(value, find):
                raise NotDataError(f"{name.removesuffix('Definition').lower()} '{value.name}'")
            return {"core": name, "name": value.name}
    if isinstance(value, _core.Formula):
        raise NotDataError("formula")
    return value


def _is_built_in(value: Any, find: Callable[[str], Any]) -> bool:
    try:
        return find(value.name).core is value
    except _core.InvalidArgument:
        return False


def from_data(value: Any) -> Any:
    """What as_data() was given. Raises KeyError or InvalidArgument for names that are not known here."""
    if isinstance(value, (list, tuple)):
        return type(value)(from_data(item) for item in value)
    if not isinstance(value, dict):
        return value
    if "core" not in value:
        return {key: from_data(item) for key, item in value.items()}
    name = value["core"]
    if name in _MATERIALS:
        material = _MATERIALS[name]()
        material.update(value["fields"])
        return material
    if name in _LAWS:
        return _LAWS[name][1][value["name"]]
    return _DEFINITIONS[name][1](value["name"]).core
