"""Makes the scene of a document: every part is added as a user adds it, and checked as then."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from stark import motion
from stark.actuators.definition import built_in as built_in_actuator
from stark.arguments import given_name
from stark.attachments.handle import Attachment
from stark.bodies import HANDLES
from stark.bodies.following import PinFollower
from stark.body_kinds import has_frames, has_points, has_pose
from stark.errors import StarkWarning
from stark.formulas.adding import add_energy
from stark.formulas.binding import BoundEnergy
from stark.formulas.energy import Binding
from stark.formulas.parameters import Value, read_value
from stark.joined_points import JoinedPoints
from stark.joints.definition import built_in as built_in_joint
from stark.joints.handle import Joint
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial
from stark.mesh import TriangleMesh
from stark.rotations import check_places
from stark.selections import (
    Points,
    embedded_points,
    local_directions,
    local_points,
    node_points,
    vertex_points,
    world_points,
)
from stark.settings import Settings
from stark.surfaces import Surface

from . import recorded
from .errors import DocumentError
from .robots import add_robot

_MATERIALS: dict[str, Any] = {kind.__name__: kind for kind in (ShellMaterial, SolidMaterial, RodMaterial)}
_INFINITE = {"inf": math.inf, "-inf": -math.inf}
_COUNTS = (4, 8, 10, 20, 27)


def _surface(given: dict[str, Any], core: float, where: str) -> Surface:
    distance, stiffness = given["contact_distance"], given["contact_stiffness"]
    if distance is None or stiffness is None:
        raise DocumentError(f"{where}.contact_core = {core} m: needs contact_distance and contact_stiffness")
    return Surface("recorded", distance, stiffness, "", core=core)


class Rebuilding:
    """The scene of a document that was checked against its format."""

    def __init__(self, document: Mapping[str, Any], scene: Any) -> None:
        self.document: Mapping[str, Any] = document
        self.scene: Any = scene
        self.formulas: list[Any] = [
            recorded.made(row, f"formulas[{k}]") for k, row in enumerate(document["formulas"])
        ]

    def run(self) -> None:
        """Adds everything. Warnings were given when the scene was made."""
        self.scene.default_friction = self.document["default_friction"]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", StarkWarning)
            for part in ("bodies", "layers", "energies", "joints", "actuators", "attachments"):
                add = getattr(self, f"_add_{part}")
                for k, row in enumerate(self.document[part]):
                    add(row, f"{part}[{k}]")
            for k, row in enumerate(self.document["robots"]):
                add_robot(self.scene, row, f"robots[{k}]")
            for k, row in enumerate(self.document["pairs"]):
                self._set_pair(row, f"pairs[{k}]")
            self.scene._ghosts = [self._body(k, "untouchable") for k in self.document["untouchable"]]
            for k, row in enumerate(self.document["motions"]):
                self._follow(row, f"motions[{k}]")
            for k, row in enumerate(self.document["courses"]):
                self._course(row, f"courses[{k}]")

    # --- bodies and layers ---

    def _add_bodies(self, row: dict[str, Any], where: str) -> None:
        given = dict(row)
        kind, direction = given.pop("kind"), given.pop("surface_direction")
        check_places(given["vertices"], f"{where}.vertices")
        if core := given.pop("contact_core"):
            given["surface"] = _surface(given, core, where)
        rest_state, motion = given.pop("rest_state", {}), given.pop("surface_motion", None)
        if given.get("inertia") is not None:
            given["inertia"] = tuple(given["inertia"].values())
        if "material" in given:
            given["material"] = self._material(given["material"], where)
        for held in {"pins", "clamps"} & given.keys():
            given[held] = given[held] if len(given[held]) else None
        if given.get("shown") is not None:
            check_places(given["shown"]["vertices"], f"{where}.shown.vertices")
            given["shown"] = TriangleMesh(**given["shown"])
        mesh = _mesh(kind, given, where)
        body = getattr(self.scene, f"add_{kind}")(mesh, **given)
        for name, values in rest_state.items():
            body._set_rest_value(name, _plain(values))
        if motion is not None:
            self.scene._core.set_surface_motion(body._index, *motion.values())
        if direction is not None:
            body.surface_direction = direction[0] if len(direction) == 1 else direction

    def _material(self, row: Mapping[str, Any], where: str) -> Any:
        kind, law, read = _MATERIALS[row["kind"]], row["law"], None
        if isinstance(law, dict):
            read = self._formula(law["formula"], recorded.ReadLaw, where)
            law = read.core
            expected = {"ShellMaterial": "ShellLaw", "SolidMaterial": "SolidLaw", "RodMaterial": "RodLaw"}
            if type(law).__name__ != expected[row["kind"]]:
                raise DocumentError(f"{where}.material: the formula is none of a {row['kind']}")
        elif law is not None:
            if law not in kind._laws:
                raise DocumentError(
                    f"{where}.material: unknown law '{law[:80]}': must be of {list(kind._laws)}"
                )
            law = kind._laws[law]
        values = {name: _plain(value) for name, value in row["values"].items()}
        if reserved := {"name", "source", "law"} & values.keys():
            raise DocumentError(f"{where}.material.values: '{min(reserved)}' is no parameter")
        material = kind._with(law, row["name"], row["source"], values)
        return material if read is None else material._recorded_as((read, read.isotropic))

    def _add_layers(self, row: dict[str, Any], where: str) -> None:
        given = dict(row)
        kind, body = given.pop("kind"), self._body(given.pop("body"), where)
        given["material"] = self._material(given["material"], where)
        if not hasattr(body, f"add_{kind}"):
            raise DocumentError(f"{where}: '{body.name}' is a {body.kind} body: must be a cloth or a solid")
        getattr(body, f"add_{kind}")(**given)

    # --- what acts ---

    def _add_energies(self, row: dict[str, Any], where: str) -> None:
        formula = self._formula(row["formula"], recorded.ReadFormula, where)
        columns = [self._column(entry, f"{where}.points[{k}]") for k, entry in enumerate(row["points"])]
        trace = formula.trace()
        if len(columns) != trace.formula.point_count:
            raise DocumentError(
                f"{where}: has {len(columns)} points: must be {trace.formula.point_count}, as its formula"
            )
        binding = object.__new__(Binding)
        binding.__dict__.update(energy=formula, frames=(), columns=columns, trace=trace)
        count = BoundEnergy._count(binding, columns)
        values, constants = self._values(row, formula, count, where)
        binding.__dict__.update(element_count=count, values=values, constants=constants)
        self.scene._energies.append(add_energy(self.scene, binding, row["name"]))

    def _values(
        self, row: dict[str, Any], formula: Any, count: int, where: str
    ) -> tuple[dict[str, Value], dict[str, Any]]:
        """Those of parameters, and those that are constants of frames."""
        given, owner = row["values"], f"{where} '{row['name'][:80]}'"
        widths = {entry["name"]: entry["width"] for entry in formula.trace().formula.fields}
        parameters = {parameter.name: parameter for parameter in formula.parameters}
        for name in [*widths, *given]:
            if name not in given or name not in widths:
                what = "has no value" if name in widths else "is no input of its formula"
                raise DocumentError(f"{owner}: '{name[:80]}' {what}: must have a value for each input")
        values, constants = {}, {}
        for name, width in widths.items():
            array, per_element = given[name]["value"], given[name]["per_element"]
            if name in parameters:
                values[name] = read_value(owner, parameters[name], array, count)
                # Of one element, both shapes may be meant.
                if values[name].per_element != per_element:
                    raise DocumentError(
                        f"{owner}: {name}: has the shape {array.shape}: does not fit per_element"
                    )
            elif array.size != width or per_element:
                raise DocumentError(f"{owner}: {name}: must be {width} numbers")
            else:
                constants[name] = array.reshape(-1)
        return values, constants

    def _column(self, row: dict[str, Any], where: str) -> Points | JoinedPoints:
        if row["kind"] != "joined":
            return self._points(row, where)
        parts = [self._points(part, f"{where}.parts[{k}]") for k, part in enumerate(row["parts"])]
        return JoinedPoints(parts)

    def _points(self, row: dict[str, Any], where: str) -> Points:
        kind = row["kind"]
        if kind == "world":
            check_places(row["local"], where)
            return world_points(row["local"])
        body = self._body(row["body"], where)
        on_pose, on_frames = kind in ("point", "direction"), kind in ("node_point", "node_direction")
        if has_pose(body) != on_pose or (on_frames and not has_frames(body)):
            raise DocumentError(f"{where}: '{body.name}' is a {body.kind} body, which has no points '{kind}'")
        count = len(body.mesh.vertices)
        for name in ("vertices", "supports", "node"):
            numbers = np.asarray(row.get(name, 0))
            if numbers.size and not 0 <= numbers.min() <= numbers.max() < count:
                raise DocumentError(
                    f"{where}.{name}: has a vertex that '{body.name}' has not: must be in [0, {count})"
                )
        if kind == "vertices":
            return vertex_points(body, row["vertices"])
        if kind == "embedded":
            if len(row["supports"]) != len(row["weights"]):
                raise DocumentError(f"{where}: supports and weights must be equally many")
            return embedded_points(body, row["supports"], row["weights"])
        check_places(row["local"], where)
        if kind in ("point", "direction"):
            return (local_points if kind == "point" else local_directions)(body, row["local"])
        return node_points(body, row["node"], row["local"], directions=kind == "node_direction")

    def _add_joints(self, row: dict[str, Any], where: str) -> None:
        formula = self._kind(row["kind"], built_in_joint, where)
        widths = {entry["name"]: entry["width"] for entry in formula.core.parameters}
        if widths != {name: len(numbers) for name, numbers in row["values"].items()}:
            raise DocumentError(f"{where}.values: must be those of the kind '{formula.name}': {widths}")
        given = {
            "a": self._frame(row["a"], f"{where}.a"),
            "b": self._frame(row["b"], f"{where}.b"),
            "values": {name: (numbers, False) for name, numbers in row["values"].items()},
            "break_force": row["break_force"],
            "break_torque": row["break_torque"],
        }
        index = self.scene._core.add_joint(
            {
                "name": _named(row, where),
                "definition": formula.core,
                "enabled": row["enabled"],
                "contact": row["contact"],
                **given,
            }
        )
        self.scene._joints.append(Joint(self.scene, index, formula, row["enabled"], given))

    def _frame(self, row: dict[str, Any], where: str) -> dict[str, Any]:
        """As the core reads it."""
        if row["carrier"] != "world":
            body = self._body(row["body"], where)
            fits = {"body": has_pose(body), "node": has_frames(body)}
            if not fits.get(row["carrier"], has_points(body)):
                raise DocumentError(
                    f"{where}: '{body.name}' is a {body.kind} body: has no '{row['carrier']}'"
                )
            numbers = np.asarray(row.get("vertices", row.get("node", 0)))
            count = len(body.mesh.vertices)
            if not 0 <= numbers.min() <= numbers.max() < count:
                raise DocumentError(
                    f"{where}: has a vertex that '{body.name}' has not: must be in [0, {count})"
                )
        return row

    def _add_actuators(self, row: dict[str, Any], where: str) -> None:
        formula = self._kind(row["kind"], built_in_actuator, where)
        on = []
        for entry in row["on"]:
            if entry["joint"] >= len(self.scene._joints):
                raise DocumentError(
                    f"{where}.on: joint {entry['joint']}: must be below {len(self.scene._joints)}"
                )
            on.append((self.scene._joints[entry["joint"]], entry["coordinate"]))
        self.scene.add_actuator(
            formula, on, name=_named(row, where), enabled=row["enabled"], **_keywords(row, where)
        )

    def _add_attachments(self, row: dict[str, Any], where: str) -> None:
        a = self._points(row["a"], f"{where}.a")
        sides = [self._points(entry, f"{where}.b[{k}]") for k, entry in enumerate(row["b"])]
        given = {
            "name": _named(row, where),
            "a": a._description(),
            "b": [side._description() for side in sides],
            **{name: row[name] for name in ("break_force", "enabled", "contact", "sewn")},
        }
        if a.is_direction or any(side.is_direction for side in sides):
            raise DocumentError(f"{where}: directions cannot be attached: must be points")
        if (row["patch_body"] is None) != (row["patches"] is None):
            raise DocumentError(f"{where}: must have both patch_body and patches, or neither")
        if row["patches"] is not None:
            body = self._body(row["patch_body"], where)
            given |= {"patch_body": body._index, "patches": row["patches"]}
            self._points(
                {"kind": "vertices", "body": body._index, "vertices": row["patches"].reshape(-1)}, where
            )
        index = self.scene._core.add_attachment(given)
        self.scene._attachments.append(Attachment(self.scene, index, a, given))

    def _set_pair(self, row: dict[str, Any], where: str) -> None:
        rule, core = row["rule"], self.scene._core
        sides = [row["a"], row["b"]]
        for side in sides:
            for k in side if isinstance(side, list) else [side]:
                self._body(k, where)
        values = [value for name, value in row.items() if name not in ("rule", "a", "b")]
        name = rule if "contact" in rule else f"set_{rule}"
        getattr(core, name)(*sides, *values)

    # --- over time ---

    def _follow(self, row: dict[str, Any], where: str) -> None:
        body = self._body(row["body"], where)
        parts = ("position", "rotation") if row["kind"] == "pose" else ("targets", "displacement", "rotation")
        motions = {
            part: None if row[part] is None else _motion(row[part], f"{where}.{part}") for part in parts
        }
        if row["kind"] == "pose":
            if not has_pose(body) or all(value is None for value in motions.values()):
                raise DocumentError(f"{where}: '{body.name}' must be a scripted rigid body, with a motion")
            body.follow(**motions)
            return
        count = 0 if has_pose(body) else len(body.pins)
        rows = row["rows"].astype(np.intp)
        both = motions["targets"] is not None and (motions["displacement"] or motions["rotation"])
        if not len(rows) or rows.min() < 0 or rows.max() >= count or both:
            raise DocumentError(f"{where}: rows must be of the {count} pins of '{body.name}', on one motion")
        follower = PinFollower(body, rows, **motions, center=row["center"])
        follower.positions(0.0)
        self.scene._followers.setdefault(body._index, []).append(follower)

    def _course(self, row: dict[str, Any], where: str) -> None:
        handles: Any = {
            "energy": self.scene._energies, "actuator": self.scene._actuators, "body": self.scene.bodies
        }[row["of"]]  # fmt: skip
        if row["number"] >= len(handles):
            raise DocumentError(f"{where}.number: must be below {len(handles)}")
        handle, value = handles[row["number"]], row["value"]
        values: dict[str, Callable[[], Any]] = {
            "energy": lambda: handle._binding.values,
            "actuator": lambda: handle.units,
            "body": lambda: _body_values(handle),
        }
        if value not in values[row["of"]]():
            raise DocumentError(f"{where}: {row['of']} '{handle.name}' has no value '{value[:80]}'")
        setattr(handle, value, _motion(row["motion"], f"{where}.motion"))

    # --- by number ---

    def _body(self, number: int, where: str) -> Any:
        if number >= len(self.scene.bodies):
            raise DocumentError(f"{where}: body {number}: must be below {len(self.scene.bodies)}")
        return self.scene.bodies[number]

    def _formula(self, number: int, kind: type, where: str) -> Any:
        if number >= len(self.formulas) or not isinstance(self.formulas[number], kind):
            raise DocumentError(f"{where}: formula {number} is not one of the kind that is needed here")
        return self.formulas[number]

    def _kind(self, given: Any, built_in: Any, where: str) -> Any:
        """A joint or actuator, built in or of the document."""
        if not isinstance(given, dict):
            return built_in(given)
        return self._formula(given["formula"], type(built_in(_ANY[built_in])), where)


_ANY = {built_in_joint: "hinge", built_in_actuator: "effort"}


def _mesh(kind: str, given: dict[str, Any], where: str) -> Any:
    """Takes the mesh of a body out of what is given."""
    arrays = {name: given.pop(name) for name in HANDLES[kind]._mesh_arrays}
    elements = arrays.get("elements")
    if elements is not None and elements.shape[1] not in _COUNTS:
        raise DocumentError(f"{where}.elements have {elements.shape[1]} nodes: must be one of {_COUNTS}")
    return HANDLES[kind]._mesh_of(arrays)


def _body_values(body: Any) -> list[str]:
    """Those that may follow functions of the time."""
    if not has_pose(body):
        return list(body._shared.get("rest_state", {}))
    return [] if body.surface_velocity is None else ["surface_velocity", "surface_spin"]


def _named(row: Mapping[str, Any], where: str) -> str:
    return given_name(row["name"])


def _keywords(row: Mapping[str, Any], where: str) -> dict[str, float]:
    """Values of an actuator, none of which is another argument of add_actuator."""
    if reserved := {"kind", "on", "name", "enabled", "self"} & row["values"].keys():
        raise DocumentError(f"{where}.values: '{min(reserved)}' is no value of an actuator")
    return dict(row["values"])


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value if value.ndim else float(value)
    return _INFINITE.get(value, value) if isinstance(value, str) else value


def _motion(row: Mapping[str, Any], where: str) -> motion.Motion:
    shape, values = tuple(row["shape"]), row["values"]
    if values.shape[1] != math.prod(shape):
        raise DocumentError(f"{where}: values have {values.shape[1]} columns: must be {math.prod(shape)}")
    values = values.reshape(len(values), *shape)
    if row["kind"] == "linear":
        return motion.linear(row["times"], values)
    if row["kind"] == "spline":
        return motion.spline(row["times"], values, rest=row["rest"])
    return motion.rotations(row["times"], values, smooth=row["smooth"], rest=row["rest"])


def settings_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Values by dotted name, checked."""
    known = Settings().to_dict()
    given: dict[str, Any] = {}
    for name, value in document["settings"].items():
        if isinstance(value, np.ndarray):
            given[name] = tuple(value.tolist()) if value.ndim == 1 else value.tolist()
        elif isinstance(value, float) and isinstance(known.get(name), int) and value.is_integer():
            given[name] = int(value)
        elif isinstance(value, str) and isinstance(known.get(name), float):
            given[name] = _INFINITE.get(value, value)
        else:
            given[name] = value
    checked = Settings()
    checked.update(given)
    checked.validate()
    return given
