"""A scene as the data of a document: plain values and arrays, numbered as format.py says."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stark import _core
from stark.bodies.following import PinFollower, PoseFollower
from stark.bodies.layers import Fibres
from stark.body_kinds import KINDS, has_frames, has_pose
from stark.motion import Motion
from stark.robots.drives import GravityFollower
from stark.settings import Settings

from . import recorded, robots
from .errors import DocumentError
from .format import FORMAT_NAME, FORMAT_VERSION, SURFACE_MOTION

_BODIES = {f"add_{kind}": kind for kind, row in KINDS.items() if not row.is_layer}
_LAYERS = {f"add_{kind}": kind for kind, row in KINDS.items() if row.is_layer}
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
    *(
        "pin",
        "clamp",
        "set_rest_state",
        "set_surface_directions",
        "set_surface_motion",
        "set_actuator_value",
        "set_actuator_enabled",
    ),
    *("add_energy", "add_joint", "add_actuator", "add_attachment"),
}
#: Of functions of the time.
_MOST_SAMPLES = 1_000_000
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


@dataclass(frozen=True)
class Motions:
    """Motions as data; ``times`` [s] are where Python functions are sampled, None for not at all."""

    times: np.ndarray | None

    def described(self, motion: Motion, owner: str) -> dict[str, Any]:
        knots = motion._knots if motion._knots is not None else self._sampled(motion, owner)
        values = knots["values"]
        shape = values.shape[1:]
        return {**knots, "values": values.reshape(len(values), math.prod(shape)), "shape": list(shape)}

    def _sampled(self, motion: Motion, owner: str) -> dict[str, Any]:
        if self.times is None:
            raise DocumentError(
                f"{owner} is {motion!r}, a Python function of the time, which a document cannot hold: use "
                f"stark.motion.linear, spline or rotations through knots; or give sample_functions=True and "
                f"until= to save its values at the ends of the steps; nothing was written"
            )
        values = np.array([motion(time) for time in self.times])
        if values.shape[1:] == (3, 3):
            return {"kind": "rotations", "times": self.times, "values": values, "smooth": False, "rest": True}
        return {"kind": "linear", "times": self.times, "values": values}


def _times(settings: Settings, until: float | None, wanted: bool) -> np.ndarray | None:
    """Ends of the steps up to the end of a run [s]."""
    if not wanted:
        return None
    step: float = settings["time.step"]
    if until is None or until / step > _MOST_SAMPLES:
        raise DocumentError(
            f"scene.save: sample_functions with until = {until} s and steps of {step:g} s: must have an end, "
            f"after at most {_MOST_SAMPLES} steps"
        )
    return np.arange(math.ceil(until / step) + 1) * step


def described(
    scene: Any, given: Any, until: float | None, description: str, sample_functions: bool
) -> dict[str, Any]:
    """The document; arrays are NumPy arrays in it. Raises DocumentError for what cannot be data."""
    settings = _chosen(given)
    formulas, motions = Formulas(), Motions(_times(settings, until, sample_functions))
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
        "robots": [robots.described(robot) for robot in scene.robots],
        "pairs": _pairs(scene),
        "untouchable": [ghost._index for ghost in scene._ghosts],
        "motions": _followers(scene, motions),
        "courses": _courses(scene, motions),
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
        if has_pose(body):
            shown = body.shown
            row["shown"] = (
                None if shown is None else {"vertices": shown.vertices, "triangles": shown.triangles}
            )
            row["inertia"] = _inertia(given["inertia"])
            motion = scene._core.surface_motion(body._index)
            row["surface_motion"] = motion and dict(zip(SURFACE_MOTION.fields, motion, strict=True))
        if "material" in body._shared:
            row["material"] = _material(body._shared["material"], formulas)
        if not has_pose(body):
            row["pins"] = scene._core.pins(body._index)
            row["rest_state"] = {name: value.array for name, value in body._rest_values.items()}
        if has_frames(body):
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
        "values": material._all_values(),
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
        "break_force": joint.break_force,
        "break_torque": joint.break_torque,
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


def _followers(scene: Any, motions: Motions) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    for body, followers in scene._followers.items():
        owner = f"'{scene._bodies[body].name}'"
        for follower in followers:
            if isinstance(follower, GravityFollower):  # of the drives of a robot
                continue
            if isinstance(follower, PoseFollower):
                parts: tuple[str, ...] = ("position", "rotation")
                row: dict[str, Any] = {"kind": "pose", "body": body}
            elif isinstance(follower, PinFollower):
                parts = ("targets", "displacement", "rotation")
                row = {"kind": "pins", "body": body, "rows": follower.rows, "center": follower.center}
            else:
                raise DocumentError(
                    f"{owner}: {type(follower).__name__} is computed by code before each step, and cannot be "
                    f"saved: must be a motion; nothing was written"
                )
            for part in parts:
                motion = getattr(follower, part)
                row[part] = None if motion is None else motions.described(motion, f"{owner}: {part}")
            rows.append(row)
    return rows


def _courses(scene: Any, motions: Motions) -> list[dict[str, Any]]:
    rows = []
    for (kind, number, value), course in scene._courses.items():
        owner = f"{kind} '{course._handle.name}': {value}"
        motion = motions.described(course._value, owner)
        rows.append({"of": kind, "number": number, "value": value, "motion": motion})
    return rows


def _chosen(given: Any) -> Settings:
    chosen = Settings()
    if isinstance(given, Settings):
        chosen = given
    elif given is not None:
        if not isinstance(given, Mapping):
            raise DocumentError(f"settings = {given!r}: must be a stark.Settings, or values by dotted name")
        chosen.update(dict(given))
    chosen.validate()
    return chosen


def _settings(chosen: Settings) -> dict[str, Any]:
    """Those that differ from the defaults, by dotted name."""
    defaults = Settings().to_dict()
    return {
        name: value
        for name, value in chosen.to_dict().items()
        if value != defaults[name] and name not in _OF_MACHINE
    }
