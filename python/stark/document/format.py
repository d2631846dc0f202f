"""What a scene document holds, version 1: the one description of the format. Reading checks against it, and
the published JSON Schema is made of it (docs/scene_documents.md).

Bodies, joints and what else is numbered are named by their number in the list of their kind, from 0 on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .format_robot import IDENTITY, INERTIA, ROBOT, ZERO, vector
from .kinds import (
    AnyArray,
    Array,
    Either,
    Field,
    Flag,
    Kind,
    Listing,
    Maybe,
    Named,
    Number,
    Record,
    Schema,
    Tagged,
    Text,
    Whole,
)

FORMAT_NAME = "stark-scene"
FORMAT_VERSION = 1
SCHEMA_ID = "stark-scene-1.schema.json"

_NUMBER_OR_WORD = Either({"number": Number(), "string": Text(), "boolean": Flag(), "list": AnyArray()})


def _points() -> Kind:
    return Array((None, 3), "m")


def _indices(columns: int) -> Kind:
    return Array((None, columns), integers=True)


_BODY = Field(Whole(), doc="number of the body")
_NAME = Field(Text(), doc="name, unique among its kind")
_LAW = Either({"string": Text(), "object": Record({"formula": Field(Whole())})})

MATERIAL = Record(
    {
        "kind": Field(Text(("ShellMaterial", "SolidMaterial", "RodMaterial"))),
        "name": Field(Text(), ""),
        "source": Field(Text(), "", "where the numbers come from"),
        "law": Field(Maybe(_LAW), None, "built-in law by name, or a formula; null: that of the kind"),
        "values": Field(
            Named(
                Either(
                    {
                        "number": Number(infinite=True),
                        "string": Text(),
                        "list": AnyArray(),
                        "object": AnyArray(),
                    }
                )
            ),
            {},
            "parameters by name, SI units: numbers, or arrays with a value for each element",
        ),
    }
)

_PLACE = {
    "name": _NAME,
    "position": Field(vector("m"), ZERO, "origin of the mesh in the world"),
    "rotation": Field(Array((3, 3)), IDENTITY, "axes of the mesh in the world as columns"),
    "velocity": Field(vector("m/s"), ZERO),
    "angular_velocity": Field(vector("rad/s"), ZERO),
    "contact_distance": Field(Maybe(Number("m")), None),
    "contact_stiffness": Field(Maybe(Number("Pa")), None),
    "contact_core": Field(Number("m"), 0.0, "part of contact_distance that no pressure takes"),
    "friction": Field(Maybe(Number()), None),
    "color": Field(Maybe(vector("1")), None, "red, green, blue in [0, 1]"),
    "surface_direction": Field(Maybe(_points()), None, "nap: one vector, or one for each triangle"),
}
_DEFORMABLE = {
    **_PLACE,
    "material": Field(MATERIAL),
    "initial_positions": Field(Maybe(_points()), None, "start in another shape than that of rest"),
    "self_contact": Field(Flag(), True),
    "pins": Field(Array((None,), integers=True), [], "vertices with prescribed positions"),
    "rest_state": Field(Named(AnyArray()), {}, "growth, temperature, ...: values of each element"),
}
EMBEDDING = Record(
    {
        "triangles": Field(_indices(3), doc="of the last vertices"),
        "cells": Field(Array((None,), integers=True), doc="element of each of those vertices"),
        "filling": Field(Array((None, None)), doc="moments (elements, 27); older: part, means, mean squares"),
    }
)
SURFACE_MOTION = Record(
    {
        "velocity": Field(vector("m/s"), ZERO, "of the material of the surface, in the frame of the mesh"),
        "spin": Field(vector("rad/s"), ZERO, "of the same, about an axis through the center"),
        "center": Field(vector("m"), ZERO),
    }
)
SHOWN = Record({"vertices": Field(_points()), "triangles": Field(_indices(3))})
BODY = Tagged(
    "kind",
    {
        "cloth": Record(
            {
                "vertices": Field(_points()),
                "triangles": Field(_indices(3)),
                **_DEFORMABLE,
                "rest_angles": Field(Text(("flat", "mesh")), "flat"),
            }
        ),
        "solid": Record(
            {
                "vertices": Field(_points()),
                "elements": Field(Array((None, None), integers=True), doc="nodes of 4, 8, 10, 20 or 27"),
                "embedding": Field(Maybe(EMBEDDING), None, "surface that the elements carry along"),
                **_DEFORMABLE,
                "formulation": Field(Text(("displacement", "mean_dilatation")), "displacement"),
            }
        ),
        "rod": Record(
            {
                "vertices": Field(_points()),
                **_DEFORMABLE,
                "rest_shape": Field(Text(("mesh", "straight")), "mesh"),
                "normal": Field(Maybe(vector("1")), None),
                "clamps": Field(Array((None,), integers=True), []),
            }
        ),
        "rigid": Record(
            {
                "vertices": Field(_points()),
                "triangles": Field(_indices(3)),
                **_PLACE,
                "motion": Field(Text(("dynamic", "fixed", "scripted")), "dynamic"),
                "mass": Field(Maybe(Number("kg")), None),
                "density": Field(Maybe(Number("kg/m^3")), None),
                "inertia": Field(Maybe(INERTIA), None),
                "hollow": Field(Flag(), False),
                "linear_damping": Field(Number("1/s"), 0.0),
                "angular_damping": Field(Number("1/s"), 0.0),
                "surface_motion": Field(Maybe(SURFACE_MOTION), None, "along itself, as of a belt"),
                "shown": Field(Maybe(SHOWN), None, "what pictures show instead; it touches nothing"),
            }
        ),
    },
)
_LAYER = {
    "name": _NAME,
    "body": _BODY,
    "material": Field(MATERIAL),
    "color": Field(Maybe(vector("1")), None),
}
LAYER = Tagged(
    "kind",
    {
        "skin": Record(
            {
                **_LAYER,
                "triangles": Field(Maybe(_indices(3)), None, "null: the whole surface"),
                "rest_angles": Field(Text(("flat", "mesh")), "mesh"),
            }
        ),
        "fibres": Record(
            {
                **_LAYER,
                "edges": Field(Maybe(_indices(2)), None, "either edges or paths"),
                "paths": Field(Maybe(Listing(Array((None,), integers=True))), None),
                "bending": Field(Flag(), True),
                "rest_shape": Field(Text(("mesh", "straight")), "mesh"),
                "normal": Field(Maybe(vector("1")), None),
            }
        ),
    },
)

_POINTS = {
    "world": Record({"local": Field(_points())}),
    "vertices": Record({"body": _BODY, "vertices": Field(Array((None,), integers=True))}),
    "embedded": Record({"body": _BODY, "supports": Field(_indices(4)), "weights": Field(Array((None, 4)))}),
    "point": Record({"body": _BODY, "local": Field(_points())}),
    "direction": Record({"body": _BODY, "local": Field(Array((None, 3)))}),
    "node_point": Record({"body": _BODY, "node": Field(Whole()), "local": Field(_points())}),
    "node_direction": Record({"body": _BODY, "node": Field(Whole()), "local": Field(Array((None, 3)))}),
}
#: Points of attachments.
POINTS = Tagged("kind", _POINTS)
#: Points of energies, which may be of several bodies.
ENERGY_POINTS = Tagged(
    "kind",
    {**_POINTS, "joined": Record({"parts": Field(Listing(POINTS), doc="one after another")})},
)
_AXES = {
    "position": Field(vector("m")),
    "rotation": Field(Array((9,)), doc="rows of the matrix, one after another"),
}
#: Sides of joints.
FRAME = Tagged(
    "carrier",
    {
        "world": Record(_AXES),
        "body": Record({**_AXES, "body": _BODY}),
        "node": Record({**_AXES, "body": _BODY, "node": Field(Whole())}),
        "patch": Record({**_AXES, "body": _BODY, "vertices": Field(Array((3,), integers=True))}),
    },
)

_FORMULA = {
    "name": Field(Text()),
    "doc": Field(Text(), ""),
    "points": Field(Whole(1, 32), doc="points of the formula"),
    "inputs": Field(
        Listing(
            Record(
                {
                    "name": Field(Text()),
                    "shape": Field(Listing(Whole(1, 100), 2), []),
                    "unit": Field(Text(), "1"),
                    "doc": Field(Text(), ""),
                    "range": Field(Listing(Number(infinite=True), 2), ["-inf", "inf"]),
                    "open": Field(Listing(Flag(), 2), [True, True], "whether the ends are excluded"),
                    "role": Field(Text(("parameter", "constant", "data")), "parameter"),
                    "default": Field(Maybe(Number(infinite=True)), None),
                }
            ),
            1000,
        ),
        [],
    ),
    "nodes": Field(
        Listing(Listing(Either({"string": Text(), "number": Number(infinite=True)}), 4), 50_000),
        doc='operations in order: ["constant", value], ["input", source, point, component], or an operation '
        "and the numbers of the nodes that it is applied to",
    ),
    "outputs": Field(Listing(Whole(), 1000), doc="numbers of nodes"),
    "stages": Field(Listing(Whole(), 50_000), [], "nodes that derivatives may go through, for speed"),
}
_LAW_FORMULA = {
    **_FORMULA,
    "internals": Field(
        Listing(
            Record(
                {
                    "name": Field(Text()),
                    "shape": Field(Listing(Whole(1, 100), 2), []),
                    "unit": Field(Text(), "1"),
                    "doc": Field(Text(), ""),
                    "initial": Field(Listing(Number(), 1000), doc="numbers at time 0, in a row"),
                }
            ),
            100,
        ),
        [],
        "internal variables; the outputs after the first are their updates, in order",
    ),
}
FORMULA = Tagged(
    "kind",
    {
        "energy": Record(
            {
                **_FORMULA,
                "totals": Field(Listing(Text(), 100), [], "names of the totals among the nodes, in order"),
                "translation_invariant": Field(Flag(), False),
            }
        ),
        "solid_law": Record({**_LAW_FORMULA, "isotropic": Field(Flag())}),
        "shell_law": Record({**_LAW_FORMULA, "isotropic": Field(Flag())}),
        "rod_law": Record(_LAW_FORMULA),
        "joint": Record(
            {
                **_FORMULA,
                "holds": Field(
                    Listing(Record({"unit": Field(Text(("m", "rad"))), "count": Field(Whole(1, 100))}), 100)
                ),
                "coordinates": Field(
                    Listing(Record({"name": Field(Text()), "unit": Field(Text(("m", "rad")))}), 100)
                ),
            }
        ),
        "actuator": Record(
            {
                **_FORMULA,
                "coordinates": Field(Whole(1, 3)),
                "one_sided": Field(Listing(Flag(), 100), []),
                "memories": Field(Listing(Text(), 100), []),
            }
        ),
    },
)
_KIND = Either({"string": Text(), "object": Record({"formula": Field(Whole())})})
_PAIR = {"a": _BODY, "b": _BODY}
_GROUPS = Record({"a": Field(Listing(Whole())), "b": Field(Listing(Whole()))})
PAIR = Tagged(
    "rule",
    {
        "friction": Record({**_PAIR, "sticking": Field(Number()), "sliding": Field(Number())}),
        "anisotropic_friction": Record(
            {**_PAIR, "along": Field(Number()), "across": Field(Number()), "kinetic": Field(Number())}
        ),
        "restitution": Record({**_PAIR, "coefficient": Field(Number())}),
        "disable_contact": Record(_PAIR),
        "enable_contact": Record(_PAIR),
        "disable_contacts": _GROUPS,
        "enable_contacts": _GROUPS,
    },
)
_KNOTS = {
    "times": Field(Array((None,), "s")),
    "values": Field(Array((None, None)), doc="a row for each time"),
    "shape": Field(Listing(Whole(1, 2**31 - 1), 2), [], "of a value"),
}
MOTION = Tagged(
    "kind",
    {
        "linear": Record(_KNOTS),
        "spline": Record({**_KNOTS, "rest": Field(Flag(), True)}),
        "rotations": Record({**_KNOTS, "smooth": Field(Flag(), True), "rest": Field(Flag(), True)}),
    },
)
FOLLOWER = Tagged(
    "kind",
    {
        "pose": Record(
            {"body": _BODY, "position": Field(Maybe(MOTION), None), "rotation": Field(Maybe(MOTION), None)}
        ),
        "pins": Record(
            {
                "body": _BODY,
                "rows": Field(Array((None,), integers=True), doc="among the pins of the body"),
                "targets": Field(Maybe(MOTION), None),
                "displacement": Field(Maybe(MOTION), None),
                "rotation": Field(Maybe(MOTION), None),
                "center": Field(vector("m")),
            }
        ),
    },
)
ENERGY = Record(
    {
        "name": _NAME,
        "formula": Field(Whole(), doc="number of the formula"),
        "points": Field(Listing(ENERGY_POINTS, 32), doc="for each point of the formula, equally many or one"),
        "values": Field(Named(Record({"value": Field(AnyArray()), "per_element": Field(Flag(), False)})), {}),
    }
)
JOINT = Record(
    {
        "name": _NAME,
        "kind": Field(_KIND, doc="built-in kind by name, or a formula"),
        "a": Field(FRAME),
        "b": Field(FRAME),
        "values": Field(Named(Array((None,))), {}),
        "contact": Field(Flag(), False),
        "enabled": Field(Flag(), True),
        "break_force": Field(Number("N", infinite=True), "inf"),
        "break_torque": Field(Number("N m", infinite=True), "inf"),
    }
)
ACTUATOR = Record(
    {
        "name": _NAME,
        "kind": Field(_KIND, doc="built-in kind by name, or a formula"),
        "on": Field(Listing(Record({"joint": Field(Whole()), "coordinate": Field(Text(), "")}), 3)),
        "values": Field(Named(Number(infinite=True)), {}),
        "enabled": Field(Flag(), True),
    }
)
ATTACHMENT = Record(
    {
        "name": _NAME,
        "a": Field(POINTS),
        "b": Field(Listing(POINTS), doc="one set of points, or one for each point of a"),
        "patch_body": Field(Maybe(Whole()), None, "body whose triangles carry the points, instead of b"),
        "patches": Field(Maybe(_indices(3)), None),
        "break_force": Field(Number("N", infinite=True), "inf"),
        "contact": Field(Flag(), True),
        "enabled": Field(Flag(), True),
        "sewn": Field(Flag(), False, "without contact from time 0 on, so that pairs can meet"),
    }
)
COURSE = Record(
    {
        "of": Field(Text(("energy", "actuator", "body"))),
        "number": Field(Whole()),
        "value": Field(Text(), doc="its name"),
        "motion": Field(MOTION),
    }
)
DOCUMENT = Record(
    {
        "format": Field(Text((FORMAT_NAME,))),
        "version": Field(Whole(FORMAT_VERSION, FORMAT_VERSION)),
        "stark_version": Field(Text(), "", "that wrote it"),
        "units": Field(Text(("SI",)), doc="metres, kilograms, seconds, radians and what follows from them"),
        "name": Field(Text()),
        "description": Field(Text(), ""),
        "until": Field(Maybe(Number("s")), None, "end of a run"),
        "settings": Field(Named(_NUMBER_OR_WORD), {}, "of the simulation, by dotted name"),
        "arrays": Field(
            Maybe(Record({"file": Field(Text()), "sha256": Field(Maybe(Text()), None)})),
            None,
            "NPZ file in the folder of the document or below",
        ),
        "default_friction": Field(Number(), 0.5),
        "formulas": Field(Listing(FORMULA, 10_000), []),
        "bodies": Field(Listing(BODY)),
        "layers": Field(Listing(LAYER), []),
        "energies": Field(Listing(ENERGY), []),
        "joints": Field(Listing(JOINT), []),
        "actuators": Field(Listing(ACTUATOR), []),
        "attachments": Field(Listing(ATTACHMENT), []),
        "robots": Field(Listing(ROBOT, 1000), [], "handles of what was added with add_robot"),
        "pairs": Field(Listing(PAIR), [], "in the order in which they were set: the last one counts"),
        "untouchable": Field(Listing(Whole()), [], "bodies that touch none, added later ones included"),
        "motions": Field(Listing(FOLLOWER), [], "of scripted bodies and pins"),
        "courses": Field(
            Listing(COURSE), [], "values of energies, actuators, rest states and belts over time"
        ),
    },
    doc="A scene of Stark: what is simulated, as data.",
)


def schema() -> dict[str, Any]:
    """The JSON Schema of a document, draft 2020-12. It says what a document looks like; ranges of values and
    what fits together are checked when it is loaded."""
    head: Schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": SCHEMA_ID}
    shared = {name: kind.schema() for name, kind in _SHARED.items()}
    body = _with_references(DOCUMENT.schema(), shared, "")
    definitions = {name: _with_references(rule, shared, name) for name, rule in shared.items()}
    return {**head, "title": "Scene document of Stark", **body, "$defs": definitions}


#: Kinds that occur in several places.
_SHARED: dict[str, Kind] = {
    "material": MATERIAL,
    "points": POINTS,
    "energy_points": ENERGY_POINTS,
    "frame": FRAME,
    "motion": MOTION,
    "formula": FORMULA,
    "body": BODY,
    "layer": LAYER,
    "vector": Array((3,), "m"),
    "rows": Array((None, 3), "m"),
    "indices": Array((None,), integers=True),
    "values": AnyArray(),
}


def _with_references(rule: Any, shared: Mapping[str, Schema], name: str) -> Any:
    """A schema in which those that are shared are named; ``name`` is its own."""
    for known, other in shared.items():
        if known != name and rule == other:
            return {"$ref": f"#/$defs/{known}"}
    if isinstance(rule, dict):
        return {key: _with_references(item, shared, "") for key, item in rule.items()}
    if isinstance(rule, list):
        return [_with_references(item, shared, "") for item in rule]
    return rule
