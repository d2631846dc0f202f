"""Rods whose ends are at the same place and not joined: what is said of those that come open."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from stark.bodies.rod import Rod

_CLOSED = 1e-6  # distance of the ends over the length of a segment


def ring_warnings(bodies: Iterable[Any], joints: Iterable[Any], attachments: Iterable[Any]) -> list[str]:
    """One for each rod that is closed by a repeated point, where one of its ends is held by nothing."""
    rings = [body for body in bodies if isinstance(body, Rod) and _is_closed(body)]
    if not rings:
        return []
    held = {place for joint in joints for side in "ab" for place in _places(joint._given[side])}
    for attachment in attachments:
        for side in (attachment._given["a"], *attachment._given["b"]):
            held.update(_places(side))
    return [
        f"rod '{rod.name}': its ends are at the same place, but nothing joins them: it is open there; leave "
        f"out the last point and weld the ends (docs/rods.md#rings), or "
        f"scene.attach(rod.vertices[-1], rod.vertices[0])"
        for rod in rings
        if any((rod._index, end) not in held and end not in rod.pins for end in _ends(rod))
    ]


def _ends(rod: Rod) -> tuple[int, int]:
    return 0, len(rod.mesh.vertices) - 1


def _is_closed(rod: Rod) -> bool:
    places = rod._scene._core.initial_positions(rod._index)
    segment = np.linalg.norm(places[1] - places[0])
    return len(places) > 3 and bool(np.linalg.norm(places[-1] - places[0]) < _CLOSED * segment)


def _places(side: Any) -> Iterable[tuple[int, int]]:
    """Bodies and nodes that one side of a joint or an attachment is carried by."""
    if "body" not in side:
        return
    numbers = side["node"] if "node" in side else side.get("vertices", ())
    for number in np.ravel(numbers).tolist():
        yield side["body"], int(number)
