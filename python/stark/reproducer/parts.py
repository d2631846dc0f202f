"""Objects of the core that calls on a scene hold, as data and back: materials by their numbers, laws, joints
and actuators by their names where they are built in, formulas of the user by their numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stark import _core
from stark.actuators import definition as actuators
from stark.joints import definition as joints
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial

from .formulas import ReadFormulas, WrittenFormulas

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


def as_data(value: Any, formulas: WrittenFormulas) -> Any:
    """Plain data in place of objects of the core. Raises NotDataError for formulas that there are not."""
    if isinstance(value, dict):
        return {key: as_data(item, formulas) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(as_data(item, formulas) for item in value)
    for name, kind in _MATERIALS.items():
        if isinstance(value, kind):
            return {"core": name, "fields": value.to_dict()}
    for name, (kind, known) in _LAWS.items():
        if isinstance(value, kind):
            title = str(getattr(value, "name", ""))
            return _named(name, title, known.get(title) is value, f"law '{title}'", value, formulas)
    for name, (kind, find) in _DEFINITIONS.items():
        if isinstance(value, kind):
            what = f"{name.removesuffix('Definition').lower()} '{value.name}'"
            return _named(name, value.name, _is_built_in(value, find), what, value, formulas)
    if isinstance(value, _core.Formula):
        return _named("Formula", "", False, "formula", value, formulas)
    return value


def _named(
    core: str, name: str, is_built_in: bool, what: str, value: Any, formulas: WrittenFormulas
) -> dict[str, Any]:
    """A formula by its name where it is built in, else by its number."""
    if is_built_in:
        return {"core": core, "name": name}
    number = formulas.number(value)
    if number is None:
        raise NotDataError(what)
    return {"core": core, "formula": number}


def _is_built_in(value: Any, find: Callable[[str], Any]) -> bool:
    try:
        return find(value.name).core is value
    except _core.InvalidArgument:
        return False


def from_data(value: Any, formulas: ReadFormulas) -> Any:
    """What as_data() was given. Raises KeyError, TypeError, IndexError or InvalidArgument for names and
    numbers that are not known here."""
    if isinstance(value, (list, tuple)):
        return type(value)(from_data(item, formulas) for item in value)
    if not isinstance(value, dict):
        return value
    if "core" not in value:
        return {key: from_data(item, formulas) for key, item in value.items()}
    name = value["core"]
    if "formula" in value:
        return formulas.core(value["formula"])
    if name in _MATERIALS:
        material = _MATERIALS[name]()
        material.update(value["fields"])
        return material
    if name in _LAWS:
        return _LAWS[name][1][value["name"]]
    return _DEFINITIONS[name][1](value["name"]).core
