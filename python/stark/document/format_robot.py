"""What a scene document holds of robots, and what bodies share with them; see format.py."""

from __future__ import annotations

from .kinds import Array, Field, Flag, Kind, Listing, Maybe, Number, Record, Text, Whole

ZERO = [0.0, 0.0, 0.0]
IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


def vector(unit: str) -> Kind:
    """Three numbers."""
    return Array((3,), unit)


INERTIA = Record(
    {
        "mass": Field(Number("kg")),
        "center_of_mass": Field(vector("m")),
        "tensor": Field(Array((3, 3), "kg m^2")),
    }
)

_NULLABLE = Field(Maybe(Number(infinite=True)), None)
ROBOT = Record(
    {
        "name": Field(Text(), doc="name, unique among its kind"),
        "source": Field(Text(), "", "the file that it came from, for messages"),
        "base": Field(Text(), "fixed"),
        "position": Field(vector("m"), ZERO, "of the base in the file"),
        "rotation": Field(Array((3, 3)), IDENTITY),
        "links": Field(
            Listing(
                Record(
                    {
                        "name": Field(Text()),
                        "inertia": Field(Maybe(INERTIA), None),
                        "body": Field(Maybe(Whole()), None, "null: the world"),
                        "position": Field(vector("m"), ZERO, "of its frame in that of the body"),
                        "rotation": Field(Array((3, 3)), IDENTITY),
                    }
                ),
                10_000,
            )
        ),
        "joints": Field(
            Listing(
                Record(
                    {
                        **{name: Field(Text()) for name in ("name", "kind", "parent", "child")},
                        "position": Field(vector("m"), ZERO),
                        "rotation": Field(Array((3, 3)), IDENTITY),
                        "axis": Field(vector("1"), [1.0, 0.0, 0.0]),
                        "anchor": Field(vector("m"), ZERO),
                        "reference": Field(Number(), 0.0),
                        **dict.fromkeys(("lower", "upper", "effort", "velocity"), _NULLABLE),
                        **dict.fromkeys(
                            ("damping", "friction", "armature", "stiffness", "rest", "shift"),
                            Field(Number(), 0.0),
                        ),
                        "mimic": Field(
                            Maybe(
                                Record(
                                    {
                                        "joint": Field(Text()),
                                        "ratio": Field(Number(), 1.0),
                                        "offset": Field(Number(), 0.0),
                                    }
                                )
                            ),
                            None,
                        ),
                        "servo": Field(
                            Maybe(
                                Record(
                                    {"stiffness": Field(Number()), "damping": Field(Number(), 0.0)},
                                )
                            ),
                            None,
                            "gains that the file has",
                        ),
                        "number": Field(Maybe(Whole()), None, "of the joint of the scene"),
                    }
                ),
                10_000,
            ),
            [],
        ),
        "closures": Field(
            Listing(
                Record(
                    {
                        "name": Field(Text()),
                        "kind": Field(Text(("ball", "fixed"))),
                        "links": Field(Listing(Text(), 2)),
                        "positions": Field(Array((2, 3), "m"), doc="of its frames in those of the links"),
                        "rotations": Field(Array((2, 3, 3))),
                        "number": Field(Whole(), doc="of the joint of the scene"),
                    }
                ),
                10_000,
            ),
            [],
            "joints that close loops of links",
        ),
        "excluded": Field(Listing(Listing(Text(), 2), 100_000), [], "pairs of links that do not touch"),
        "start": Field(Array((None,)), doc="coordinates at time 0 [rad, m]"),
        "report": Field(
            Listing(
                Record(
                    {
                        "kind": Field(Text(("kept", "assumed", "dropped", "suspicious"))),
                        "part": Field(Text()),
                        "text": Field(Text()),
                    }
                ),
                100_000,
            ),
            [],
        ),
        "flexes": Field(
            Listing(Record({"name": Field(Text()), "body": Field(Whole())}), 10_000),
            [],
            "deformable parts and the cloth, solid or rod of each",
        ),
        "drives": Field(
            Listing(
                Record(
                    {
                        "kind": Field(Text(("servos", "motors", "efforts"))),
                        "rows": Field(Array((None,), integers=True), doc="among the coordinates"),
                        "actuators": Field(Array((None,), integers=True)),
                        "shifts": Field(Array((None,))),
                        "gravity_compensation": Field(Flag(), False),
                    }
                ),
                1000,
            ),
            [],
        ),
    }
)
