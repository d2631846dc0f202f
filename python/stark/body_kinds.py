"""The kinds of bodies, a row each: what pictures, recordings and documents ask of a kind, so that nothing
else tells kinds apart by name. The core has a table of its own (src/stark/sim/scene/body_kind.h)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

__all__ = ["KINDS", "BodyKind", "has_frames", "has_points", "has_pose", "names_of", "row_of", "title_of"]

Color = tuple[float, float, float]


@dataclass(frozen=True)
class BodyKind:
    """What is the same for all bodies, or layers, of a kind."""

    #: What their vertices follow: "points", own positions; "pose", that of the body; "frames", own frames.
    moved_by: Literal["points", "pose", "frames"] = "points"
    title: str = ""  #: in messages, where it is not the name of the kind
    is_layer: bool = False  #: of a body: without vertices of its own
    is_sheet: bool = False  #: of triangles: drawn smooth, with two sides
    has_triangles: bool = True  #: which touch others, and take pressure; else it has edges
    strains: bool = True
    #: Of bodies without a colour of their own, in turn, sRGB in [0, 1]; none: those of rigid bodies.
    colors: tuple[Color, ...] = ()


KINDS: dict[str, BodyKind] = {
    "cloth": BodyKind(
        is_sheet=True,
        colors=((0.87, 0.44, 0.34), (0.36, 0.56, 0.86), (0.94, 0.68, 0.26), (0.62, 0.45, 0.80)),
    ),
    "solid": BodyKind(
        colors=((0.20, 0.64, 0.60), (0.93, 0.60, 0.28), (0.84, 0.40, 0.52), (0.46, 0.66, 0.32)),
    ),
    "rigid": BodyKind(
        moved_by="pose",
        title="rigid body",
        strains=False,
        colors=(
            (0.33, 0.45, 0.66), (0.91, 0.66, 0.33), (0.47, 0.63, 0.50), (0.80, 0.45, 0.38),
            (0.55, 0.49, 0.70), (0.36, 0.62, 0.70),
        ),
    ),
    "rod": BodyKind(moved_by="frames", has_triangles=False),
    "skin": BodyKind(is_layer=True),
    "fibres": BodyKind(
        is_layer=True,
        has_triangles=False,
        colors=((0.22, 0.23, 0.26), (0.72, 0.28, 0.24), (0.30, 0.42, 0.62)),
    ),
}  # fmt: skip
_OTHER = BodyKind()


def row_of(body: Any) -> BodyKind:
    """Row of a handle, of a body of a recording, or of anything with a ``kind``; others have points."""
    return KINDS.get(str(getattr(body.kind, "name", body.kind)).lower(), _OTHER)


def has_points(body: Any) -> bool:
    """Whether each vertex has a position of its own, and no frame."""
    return row_of(body).moved_by == "points"


def has_pose(body: Any) -> bool:
    """Whether all vertices follow one position and rotation."""
    return row_of(body).moved_by == "pose"


def has_frames(body: Any) -> bool:
    """Whether each vertex has a position and a rotation."""
    return row_of(body).moved_by == "frames"


def title_of(body: Any) -> str:
    """Name in messages, as the core has it: "rigid body 'box'"."""
    return f"{row_of(body).title or body.kind} '{body.name}'"


def names_of(**properties: bool) -> tuple[str, ...]:
    """Names of the kinds of bodies, not of layers, with these properties, in the order of the table:
    ``names_of(strains=True)``."""
    wanted = properties.items()
    return tuple(
        name
        for name, kind in KINDS.items()
        if not kind.is_layer and all(getattr(kind, key) == value for key, value in wanted)
    )
