"""Rods whose ends a joint holds together: what is said where they touch each other there."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from stark.settings import Settings


def joined_ends_warnings(core: Any, joints: Iterable[Any], settings: Settings) -> list[str]:
    """One for each joint between two nodes of a rod that are within its contact distances of each other, as
    the ends of a ring of short segments: friction between them is a couple, which brakes the whole rod."""
    values = settings.to_dict()
    if not all(values[f"contact.{name}"] for name in ("enabled", "self_contact", "friction")):
        return []
    found = []
    for joint in joints:
        a, b = joint._given["a"], joint._given["b"]
        if not (a["carrier"] == b["carrier"] == "node" and a["body"] == b["body"]):
            continue
        body = a["body"]
        if not core.contact_possible(body, body):
            continue
        points = core.initial_positions(body)
        first, last = sorted(int(np.ravel(side["node"])[0]) % len(points) for side in (a, b))
        along = np.linalg.norm(np.diff(points[first : last + 1], axis=0), axis=1).sum()
        apart = float(np.linalg.norm(points[last] - points[first]))
        distance = core.contact_distance_in(body, settings._core)
        if apart < 2.0 * distance and along > math.pi * distance:  # nearer along it there is no contact
            found.append(
                f"joint '{joint.name}': it holds the nodes {first} and {last} of rod '{core.name(body)}' "
                f"{apart:.3g} m apart, nearer than twice its contact distance, {2.0 * distance:.3g} m: they "
                f"rub on each other, which brakes the rod when it turns; take longer segments, a smaller "
                f"contact_distance, or self_contact=False"
            )
    return found
