"""Joints and attachments that hold what they find: where side a is on the carrier of side b.

Numbers of a fixed joint are a position [m] and the rows of a rotation, of others positions alone, all as the
carrier sees them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .run import State, place_width

Floats = NDArray[np.float64]


def held_bodies(scene: dict[str, Any]) -> set[int]:
    """Bodies that joints or attachments hold, or are held by."""
    sides = [part[side] for part in scene["joints"] for side in ("a", "b")]
    for attachment in scene["attachments"]:
        sides += [attachment["a"], *attachment.get("b", ())]
    bodies = {side["body"] for side in sides if "body" in side}
    return bodies | {part["patch_body"] for part in scene["attachments"] if "patches" in part}


def places(state: State, part: dict[str, Any]) -> Floats | None:
    """Numbers of a joint or an attachment in a state; None for one that has none."""
    width = place_width(part)
    if width == 0 or state.held_places is None:
        return None
    return state.held_places[part["held_place"] : part["held_place"] + width]


def on_carrier(frame: tuple[Floats, Floats], numbers: Floats | None) -> tuple[Floats, Floats]:
    """A frame, origin and axes, moved to a place that it sees."""
    if numbers is None:
        return frame
    origin, axes = frame
    turned = axes @ numbers[3:].reshape(3, 3) if len(numbers) > 3 else axes
    return origin + axes @ numbers[:3], turned


def carried(attachment: dict[str, Any], numbers: Floats | None) -> list[dict[str, Any]]:
    """Descriptions of the points of side b, where these numbers put them."""
    if numbers is None:
        return list(attachment["b"])
    rows, found = numbers.reshape(-1, 3), []
    for points in attachment["b"]:
        count = len(np.array(points["local"]).reshape(-1, 3))
        found.append(points | {"local": rows[:count]})
        rows = rows[count:]
    return found


def taken_anew(before: State | None, state: State, part: dict[str, Any]) -> bool:
    """Whether something was held where it was found between two states."""
    if before is None or state.is_placed:
        return False
    old, new = places(before, part), places(state, part)
    return old is not None and new is not None and not np.array_equal(old, new)
