"""What the checker knows of the kinds of bodies, a table of its own: nothing else of it tells them apart by
name. Kinds that are not in it have points, all of which are drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class BodyKind:
    #: What vertices follow: "points", own positions; "pose", that of the body; "frames", own frames.
    moved_by: Literal["points", "pose", "frames"] = "points"
    has_inside: bool = False  #: vertices that are not drawn


KINDS = {
    "solid": BodyKind(has_inside=True),
    "rigid": BodyKind(moved_by="pose"),
    "rod": BodyKind(moved_by="frames"),
}


def row_of(kind: str) -> BodyKind:
    return KINDS.get(kind, BodyKind())
