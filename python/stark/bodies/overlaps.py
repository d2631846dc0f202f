"""Bodies that overlap at the start: found together, by the tests that a simulation makes of single pairs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from stark import _core
from stark._core import InvalidArgument
from stark.bodies.body import Body
from stark.body_kinds import row_of


def overlapping(scene: Any, bodies: Sequence[Body]) -> list[tuple[Body, Body]]:
    """Pairs of bodies whose surfaces intersect at time 0, or one of which is inside of another that is
    filled, in the order of adding. Not those that have no contact anyway: disabled, held together by a joint
    without contact, or neither of them free to move. Rods have no surface and are not looked at."""
    parts = [body for body in bodies if row_of(body).has_triangles and len(body.surface_triangles)]
    if len(parts) < 2:
        return []
    if scene._latest_simulation() is not None:
        raise InvalidArgument(
            "disable_overlapping: the scene has a simulation: must be called before one is made, as it looks "
            "at where bodies start"
        )
    x = [np.asarray(body.surface_positions) for body in parts]
    first = np.cumsum([0, *(len(rows) for rows in x)])
    group = np.repeat(np.arange(len(parts), dtype=np.int32), np.diff(first))
    triangles = [body.surface_triangles + start for body, start in zip(parts, first[:-1], strict=True)]
    surface = np.concatenate(triangles).astype(np.int32)
    sides = np.sort(surface[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges = np.unique(sides, axis=0)
    apart = _without_contact(scene, parts, x)
    found = _core.CollisionScene(group, edges, surface, excluded_pairs=apart)
    where = np.concatenate(x)
    met = found.find_intersections(where)
    inside = [pair for pair in found.find_contained_groups(where)[:, :2] if _is_filled(scene, parts[pair[1]])]
    rows = np.column_stack([group[edges[met[:, 0], 0]], group[surface[met[:, 1], 0]]]).tolist()
    pairs = {(min(pair), max(pair)) for pair in (*rows, *(pair.tolist() for pair in inside))}
    return [(parts[a], parts[b]) for a, b in sorted(pairs)]


def _is_filled(scene: Any, body: Body) -> bool:
    return bool(scene._core.is_filled(body._index))


def _without_contact(scene: Any, parts: Sequence[Body], x: Sequence[np.ndarray]) -> np.ndarray:
    """Pairs of places in ``parts``, of which bodies are near each other, to be left out, bodies with
    themselves among them (n, 2)."""
    left_out = [(k, k) for k in range(len(parts))]
    resting = [getattr(body, "motion", "dynamic") != "dynamic" for body in parts]
    for a, b in _near(x):
        if (resting[a] and resting[b]) or not scene.contact_enabled(parts[a], parts[b]):
            left_out.append((a, b))
    return np.array(sorted(left_out), dtype=np.int32)


def _near(x: Sequence[np.ndarray]) -> Iterator[tuple[int, int]]:
    """Pairs of bodies whose bounding boxes overlap or touch, the first one before the other."""
    low = np.array([rows.min(axis=0) for rows in x])
    high = np.array([rows.max(axis=0) for rows in x])
    for a in range(len(x) - 1):
        meets = ((low[a] <= high[a + 1 :]) & (low[a + 1 :] <= high[a])).all(axis=1)
        for b in np.flatnonzero(meets).tolist():
            yield a, a + 1 + b
