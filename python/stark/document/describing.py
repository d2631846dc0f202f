"""A scene as the data of a document: plain values and arrays, numbered as format.py says."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from stark import _core
from stark.bodies.following import PinFollower, PoseFollower
from stark.bodies.layers import Fibres
from stark.motion import Motion
from stark.settings import Settings

from . import recorded
from .errors import DocumentError
from .format import FORMAT_NAME, FORMAT_VERSION

_BODIES = {"add_cloth": "cloth", "add_solid": "solid", "add_rod": "rod", "add_rigid": "rigid"}
_LAYERS = {"add_skin": "skin", "add_fibres": "fibres"}
_PAIRS: dict[str, tuple[str, tuple[str, ...]]] = {
    "set_friction": ("friction", ("a", "b", "sticking", "sliding")),
    "set_anisotropic_friction": ("anisotropic_friction", ("a", "b", "along", "across", "kinetic")),
    "set_restitution": ("restitution", ("a", "b", "coefficient")),
    "disable_contact": ("disable_contact", ("a", "b")),
    "enable_contact": ("enable_contact", ("a", "b")),
    "disable_contacts": ("disable_contacts", ("a", "b")),
    "enable_contacts": ("enable_contacts", ("a", "b")),
}
#: What is written elsewhere: by what it came to.
_ELSEWHERE = {
    *("pin", "clamp", "set_surface_directions", "set_actuator_value", "set_actuator_enabled"),
    *("add_energy", "add_joint", "add_actuator", "add_attachment"),
}
#: Settings of a machine, not of a scene.
_OF_MACHINE = ("execution.threads", "execution.oversubscribe", "execution.backend")


class Formulas:
    """Formulas of a document; each once, however many things use it."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []
        self._known: dict[tuple[Any, ...], int] = {}
        self._alive: list[Any] = []  # what the keys are the addresses of

    def number(self, key: tuple[Any, ...], describe: Callable[[], dict[str, Any]]) -> int:
        """Of a formula that is told from others by the objects ``key``."""
        ids = tuple(part if isinstance(part, (str, bool)) else id(part) for part in key)
        if ids not in self._known:
            self._known[ids] = len(self.rows)
            self._alive.append(key)
            self.rows.append(describe())
        return self._known[ids]


def described(scene: Any, settings: Any, until: float | None, description: str) -> dict[str, Any]:
    """The document; arrays are NumPy arrays in it. Raises DocumentError for what cannot be data."""
    formulas = Formulas()
    return {
        "format": FORMAT_NAME,
        "version": FORMAT_VERSION,
        "stark_version": _core.__version__,
        "units": "SI",
        "name": scene.name,
        "description": description,
        "until": until,
        "settings": _settings(settings),
        "default_friction": scene.default_friction,
        "formulas": formulas.rows,
        "bodies": _bodies(scene, formulas),
        "layers": _layers(scene, formulas),
        "energies": [_energy(energy, formulas) for energy in scene.energies],
        "joints": [_joint(scene, joint, formulas) for joint in scene.joints],
        "actuators": [_actuator(scene, actuator, formulas) for actuator in scene.actuators],
        "attachments": [{**attachment._given, "name": attachment.name} for attachment in scene.attachments],
        "pairs": _pairs(scene),
        "untouchable": [ghost._index for ghost in scene._ghosts],
        "motions": _followers(scene),
        "courses": _courses(scene),
    }


# --- bodies and layers ---


def _bodies(scene: Any, formulas: Formulas) -> list[dict[str, Any]]:
    calls = [(name, arguments[0]) for name, arguments in scene._core.calls if name in _BODIES]
    rows = []
    for body, (name, given) in zip(scene.bodies, calls, strict=True):
        kind = _BODIES[name]
        row = {"kind": kind, **{k: v for k, v in given.items() if k not in ("law", "fields", "name")}}
        row["name"] = body.name
        directions = scene._core.surface_directions(body._index)
        row["surface_direction"] = directions if len(directions) else None
        if kind == "rigid":
            row["inertia"] = _inertia(given["inertia"])
        else:
            row["material"] = _material(body._shared["material"], formulas)
            row["pins"] = scene._core.pins(body._index)
        if kind == "rod":
            row["clamps"] = scene._core.clamped(body._index)
        rows.append(row)
    return rows


def _inertia(given: Any) -> dict[str, Any] | None:
    if given is None:
        return None
    mass, center, tensor = given
    return {"mass": mass, "center_of_mass": np.asarray(center), "tensor": np.asarray(tensor)}


def _material(material: Any, formulas: Formulas) -> dict[str, Any]:
    law: Any = None if material.law is None else material.law.name
    if material._recorded is not None:
        function, isotropic = material._recorded
        law = {
            "formula": formulas.number(
                (function, isotropic), lambda: recorded.of_law(function, isotropic, material.law)
            )
        }
    elif law is not None and law not in material._laws:
        raise DocumentError(
            f"material '{material.name}': its law '{law}' was made by other means than @stark.material: must "
            f"be a built-in law, or recorded by @stark.material"
        )
    return {
        "kind": type(material).__name__,
        "name": material.name,
        "source": material.source,
        "law": law,
        "values": material.to_dict(),
    }


def _layers(scene: Any, formulas: Formulas) -> list[dict[str, Any]]:
    calls = [(name, arguments[0]) for name, arguments in scene._core.calls if name in _LAYERS]
    rows = []
    for layer, (name, given) in zip(scene.layers, calls, strict=True):
        row = {"kind": _LAYERS[name], "body": given["body"], "name": layer.name, "color": given["color"]}
        row["material"] = _material(layer.material, formulas)
        if isinstance(layer, Fibres):
            lines = layer._paths
            row |= {"bending": given["bending"], "rest_shape": given["rest_shape"], "normal": given["normal"]}
            row |= {"edges": lines.edges} if lines.given_as_edges else {"paths": list(lines.paths)}
        else:
            row |= {"triangles": given["triangles"], "rest_angles": given["rest_angles"]}
        rows.append(row)
    return rows


# --- what acts ---


def _energy(energy: Any, formulas: Formulas) -> dict[str, Any]:
    binding = energy._binding
    key = (binding.trace, binding.translation_invariant)
    values: dict[str, Any] = {
        name: {"value": value.array, "per_element": value.per_element}
        for name, value in binding.values.items()
    }
    values |= {
        name: {"value": np.asarray(numbers), "per_element": False}
        for name, numbers in binding.constants.items()
        if name in binding.trace.parameters
    }
    return {
        "name": energy.name,
        "formula": formulas.number(key, lambda: recorded.of_energy(binding)),
        "points": [column._description() for column in binding.columns],
        "values": values,
    }


def _joint(scene: Any, joint: Any, formulas: Formulas) -> dict[str, Any]:
    formula, given = joint.formula, joint._given
    return {
        "name": joint.name,
        "kind": formula.name
        if formula.residuals is None
        else {"formula": formulas.number((formula,), lambda: recorded.of_joint(formula))},
        "a": given["a"],
        "b": given["b"],
        "values": {name: numbers for name, (numbers, _) in given["values"].items()},
        "contact": scene._core.joint_contact(joint._index),
        "enabled": joint._enabled_at_start,
    }


def _actuator(scene: Any, actuator: Any, formulas: Formulas) -> dict[str, Any]:
    formula, core = actuator.formula, scene._core
    return {
        "name": actuator.name,
        "kind": formula.name
        if formula.outputs is None
        else {"formula": formulas.number((formula,), lambda: recorded.of_actuator(formula))},
        "on": [{"joint": joint._index, "coordinate": name} for joint, name in actuator.coordinates],
        "values": {name: core.actuator_value(actuator._index, name) for name in actuator.units},
        "enabled": core.actuator_enabled(actuator._index),
    }


def _pairs(scene: Any) -> list[dict[str, Any]]:
    rows = []
    for name, arguments in scene._core.calls:
        if name in _PAIRS:
            rule, fields = _PAIRS[name]
            rows.append({"rule": rule, **dict(zip(fields, arguments, strict=True))})
        elif name not in _ELSEWHERE and name not in _BODIES and name not in _LAYERS:
            raise DocumentError(f"scene '{scene.name}': a document cannot hold what {name}() did")
    return rows


# --- over time ---


def _followers(scene: Any) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    for body, followers in scene._followers.items():
        owner = f"'{scene.bodies[body].name}'"
        for follower in followers:
            if isinstance(follower, PoseFollower):
                parts: tuple[str, ...] = ("position", "rotation")
                row: dict[str, Any] = {"kind": "pose", "body": body}
            elif isinstance(follower, PinFollower):
                parts = ("targets", "displacement", "rotation")
                row = {"kind": "pins", "body": body, "rows": follower.rows, "center": follower.center}
            else:
                raise DocumentError(
                    f"{owner}: {type(follower).__name__} is computed by code before each step, and cannot be "
                    f"saved: switch it off (drives.gravity_compensation = False) before the scene is saved, "
                    f"and on again where it is used; nothing was written"
                )
            for part in parts:
                motion = getattr(follower, part)
                row[part] = None if motion is None else _motion(motion, f"{owner}: {part}")
            rows.append(row)
    return rows


def _courses(scene: Any) -> list[dict[str, Any]]:
    rows = []
    for (kind, number, value), course in scene._courses.items():
        owner = f"{kind} '{course._handle.name}': {value}"
        rows.append({"of": kind, "number": number, "value": value, "motion": _motion(course._value, owner)})
    return rows


def _motion(motion: Motion, owner: str) -> dict[str, Any]:
    knots = motion._knots
    if knots is None:
        raise DocumentError(
            f"{owner} is {motion!r}, a Python function of the time, which a document cannot hold: must be "
            f"stark.motion.linear, spline or rotations through knots; nothing was written"
        )
    values = knots["values"]
    shape = values.shape[1:]
    row = {**knots, "values": values.reshape(len(values), math.prod(shape)), "shape": list(shape)}
    return row


def _settings(settings: Any) -> dict[str, Any]:
    """Those that differ from the defaults, by dotted name."""
    chosen = Settings()
    if isinstance(settings, Settings):
        chosen = settings
    elif settings is not None:
        if not isinstance(settings, Mapping):
            raise DocumentError(
                f"settings = {settings!r}: must be a stark.Settings, or values by dotted name"
            )
        chosen.update(dict(settings))
    chosen.validate()
    defaults = Settings().to_dict()
    return {
        name: value
        for name, value in chosen.to_dict().items()
        if value != defaults[name] and name not in _OF_MACHINE
    }
