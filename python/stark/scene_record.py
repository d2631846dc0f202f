"""Remembers what a scene was given, so that a step that fails can be written to a file with all that it
depends on."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np

from stark import _core
from stark.body_kinds import KINDS

#: A call on the scene of the core: name and arguments.
Call = tuple[str, tuple[Any, ...]]


class RecordedScene(_core.Scene):
    """A scene of the core that keeps the calls which made it what it is, in order, with copies of their
    arrays. Calls that were refused are not among them."""

    def __init__(self) -> None:
        super().__init__()
        self.calls: list[Call] = []

    def snapshot(self) -> tuple[float, int]:
        """What restore() goes back to. It costs nothing: a copy of the scene for each spring would make
        adding n springs a matter of n^2."""
        return self.default_friction, len(self.calls)

    def restore(self, snapshot: tuple[float, int]) -> None:
        """Makes the scene again by the calls up to there."""
        default_friction, count = snapshot
        scene = _core.Scene()
        scene.default_friction = default_friction
        for name, arguments in self.calls[:count]:
            getattr(scene, name)(*arguments)
        self.assign(scene)
        del self.calls[count:]

    def _do(self, name: str, *arguments: Any) -> Any:
        kept = tuple(_copied(argument) for argument in arguments)
        result = getattr(super(), name)(*arguments)
        self.calls.append((name, kept))
        return result

    def _add(self, name: str, description: dict[str, Any]) -> int:
        number: int = self._do(name, description)
        return number

    def add_energy(self, description: dict[str, Any]) -> int:
        return self._add("add_energy", description)

    def add_joint(self, description: dict[str, Any]) -> int:
        return self._add("add_joint", description)

    def add_actuator(self, description: dict[str, Any]) -> int:
        return self._add("add_actuator", description)

    def add_attachment(self, description: dict[str, Any]) -> int:
        return self._add("add_attachment", description)

    def set_actuator_value(self, actuator: int, name: str, value: float) -> None:
        self._do("set_actuator_value", actuator, name, value)

    def set_actuator_enabled(self, actuator: int, enabled: bool) -> None:
        self._do("set_actuator_enabled", actuator, enabled)

    def pin(self, body: int, vertices: Any) -> None:
        self._do("pin", body, vertices)

    def clamp(self, body: int, nodes: Any) -> None:
        self._do("clamp", body, nodes)

    def set_friction(self, a: int, b: int, sticking: float, sliding: float) -> None:
        self._do("set_friction", a, b, sticking, sliding)

    def set_anisotropic_friction(self, a: int, b: int, along: float, across: float, kinetic: float) -> None:
        self._do("set_anisotropic_friction", a, b, along, across, kinetic)

    def set_restitution(self, a: int, b: int, coefficient: float) -> None:
        self._do("set_restitution", a, b, coefficient)

    def set_rest_state(self, body: int, values: Any) -> None:
        self._do("set_rest_state", body, values)

    def set_surface_directions(self, body: int, directions: Any) -> None:
        self._do("set_surface_directions", body, directions)

    def set_surface_motion(self, body: int, velocity: Any, spin: Any, center: Any) -> None:
        self._do("set_surface_motion", body, velocity, spin, center)

    def disable_contact(self, a: int, b: int) -> None:
        self._do("disable_contact", a, b)

    def enable_contact(self, a: int, b: int) -> None:
        self._do("enable_contact", a, b)

    def disable_contacts(self, a: Sequence[int], b: Sequence[int]) -> None:
        self._do("disable_contacts", a, b)

    def enable_contacts(self, a: Sequence[int], b: Sequence[int]) -> None:
        self._do("enable_contacts", a, b)


def _recorded(name: str) -> Any:
    """A method that does what the core's does, and keeps the call."""

    def method(self: RecordedScene, *arguments: Any) -> Any:
        return self._do(name, *arguments)

    return method


for _kind in KINDS:
    setattr(RecordedScene, f"add_{_kind}", _recorded(f"add_{_kind}"))


def _copied(value: Any) -> Any:
    """With arrays and containers of its own; objects of the core do not change once they are handed over,
    but for materials."""
    if value is None or isinstance(value, (str, float, int)):
        return value
    if isinstance(value, dict):
        return {key: _copied(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(_copied(item) for item in value)
    if type(value) is np.ndarray and value.dtype != object:
        return value.copy(order="K")  # in a fifth of the time of copy.deepcopy()
    if hasattr(value, "__array__"):
        return copy.deepcopy(value)
    if isinstance(value, (_core.ShellMaterial, _core.SolidMaterial, _core.RodMaterial)):
        return value.copy()
    return value
