"""Proof that something passed through a closed surface: a vertex that is outside of it in one state and
inside in the next, whatever its path was."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .predicates import orientation_signs
from .surface import Surface

Floats = NDArray[np.float64]

_DIRECTIONS = 16  # rays tried until one meets no edge and no vertex


def changed_sides(
    surface: Surface, bodies: set[tuple[int, ...]], x0: Floats, x1: Floats
) -> list[tuple[int, int, int]]:
    """(body of the vertex, closed body, vertex of the body) for each of the pairs of bodies, in both roles:
    the first vertex whose side is certain in both states and not the same."""
    found = []
    for pair in sorted({(a, b) for p in bodies for a, b in (p, p[::-1]) if a != b}):
        vertex_body, closed = pair
        triangles = surface.triangles[surface.body_of[surface.triangles[:, 0]] == closed]
        if not is_closed(triangles):
            continue
        own = surface.points[surface.body_of[surface.points] == vertex_body]
        before, after = (_sides(x[own], x[triangles]) for x in (x0, x1))
        changed = np.flatnonzero((before >= 0) & (after >= 0) & (before != after))
        if len(changed):
            found.append((vertex_body, closed, int(own[changed[0]] - surface.starts[vertex_body])))
    return found


def is_closed(triangles: NDArray[np.int64]) -> bool:
    """Whether every edge belongs to exactly two triangles."""
    if not len(triangles):
        return False
    sides = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    return bool((np.unique(sides, axis=0, return_counts=True)[1] == 2).all())


def _sides(points: Floats, corners: Floats) -> NDArray[np.int8]:
    """1 inside, 0 outside, -1 not certain, of points (k, 3) and closed surfaces (m, 3, 3)."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    result = np.where(((points < low) | (points > high)).any(axis=1), 0, -1).astype(np.int8)
    random = np.random.default_rng(1)  # the same rays on every machine
    size = float(np.linalg.norm(high - low))
    for _ in range(_DIRECTIONS):
        rows = np.flatnonzero(result < 0)
        if not len(rows):
            break
        way = random.normal(size=3)
        far = points[rows] + way * (4.0 * size / np.linalg.norm(way))
        for row, end in zip(rows, far, strict=True):
            result[row] = _parity(points[row], end, corners)
    return result


def _parity(p: Floats, q: Floats, corners: Floats) -> int:
    """Whether the segment from p to a point outside crosses the surface an odd number of times; -1 where it
    is not certain."""
    p, q = np.broadcast_to(p, corners[:, 0].shape), np.broadcast_to(q, corners[:, 0].shape)
    a, b, c = corners.transpose(1, 0, 2)
    sides = orientation_signs(a, b, c, p), orientation_signs(a, b, c, q)
    around = np.stack([orientation_signs(p, q, s, t) for s, t in ((a, b), (b, c), (c, a))], axis=1)
    misses = (sides[0] * sides[1] == 1) | ((around == 1).any(axis=1) & (around == -1).any(axis=1))
    crosses = (sides[0] * sides[1] == -1) & (np.abs(around.sum(axis=1)) == 3)
    return -1 if (~misses & ~crosses).any() else int(crosses.sum() % 2)
