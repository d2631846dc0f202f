"""Sections of closed surfaces with a plane, so that bodies whose inside has no elements look solid when they
are cut.

The triangles that cross the plane leave closed polygons in it, which run with the inside on their left. A
point of the plane is inside where it winds around it, as in the replay page (replay/caps.js). Lines through
all corners divide the polygons into trapezoids, which need no other care: neither for rooms in a body nor
for parts that overlap."""

from __future__ import annotations

import numpy as np

from .. import _core
from .clipping import Plane


def cap(plane: Plane, positions: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Section of what a surface bounds: points (k, 3) [m] and triangles (m, 3) that look along the normal of
    the plane, none where the plane misses it. None if the surface is open; vertices at the same place count
    as one."""
    places, index = np.unique(positions, axis=0, return_inverse=True)
    faces = index.reshape(-1)[triangles]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)].astype(np.int32)
    if not len(faces) or not _core.is_closed(faces):
        return None
    begin, end = _polygons(plane, places, faces)
    across, up = _axes(plane.normal)
    corners = _trapezoids(np.stack([begin @ across, begin @ up], -1), np.stack([end @ across, end @ up], -1))
    points = corners.reshape(-1, 2) @ np.stack([across, up]) + plane.offset * plane.normal
    first = 4 * np.arange(len(corners))[:, None]
    return points, np.concatenate([first + np.array(half) for half in ([0, 1, 2], [0, 2, 3])]).astype(
        np.int32
    )


def _polygons(plane: Plane, positions: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where each triangle that crosses the plane enters and leaves it, (s, 3) each. Neighbours share the
    very same points: an edge is cut from its vertex with the smaller index."""
    height = plane.heights(positions)
    above = (height > 0.0)[triangles]
    count = above.sum(axis=1)
    crossing = (count == 1) | (count == 2)
    rows, odd = triangles[crossing], above[crossing] == (count[crossing] == 1)[:, None]
    turned = rows[np.arange(len(rows))[:, None], (odd.argmax(axis=1)[:, None] + np.arange(3)) % 3]
    ends = []
    for other in (1, 2):
        low, high = np.minimum(turned[:, 0], turned[:, other]), np.maximum(turned[:, 0], turned[:, other])
        share = (height[low] / (height[low] - height[high]))[:, None]
        ends.append(positions[low] + share * (positions[high] - positions[low]))
    swap = (count[crossing] == 2)[:, None]
    return np.where(swap, ends[1], ends[0]), np.where(swap, ends[0], ends[1])


def _axes(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two directions in the plane that make a right-handed frame with its normal."""
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    across /= np.linalg.norm(across)
    return across, np.cross(normal, across)


def _trapezoids(begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Corners (k, 4, 2), counterclockwise, of the trapezoids that fill the polygons of oriented edges (s,
    2)."""
    upwards = end[:, 1] > begin[:, 1]
    low, high = np.where(upwards[:, None], begin, end), np.where(upwards[:, None], end, begin)
    levels = np.unique(np.concatenate([low[:, 1], high[:, 1]]))
    first, last = np.searchsorted(levels, low[:, 1]), np.searchsorted(levels, high[:, 1])
    # One entry for each edge in each strip between two levels that it crosses.
    edge = np.repeat(np.arange(len(low)), last - first)
    strip = np.arange(len(edge)) - np.repeat(np.cumsum(last - first) - last, last - first)
    bottom, top = (_at_level(low[edge], high[edge], levels[strip + i]) for i in (0, 1))
    order = np.lexsort((bottom + top, strip))
    edge, strip, bottom, top = edge[order], strip[order], bottom[order], top[order]
    winding = np.cumsum(np.where(upwards[edge], 1, -1))  # 0 again at the end of each strip
    left = np.flatnonzero(winding[:-1] != 0) if len(edge) else np.zeros(0, dtype=int)
    down, above = levels[strip[left]], levels[strip[left] + 1]
    corners = [(bottom[left], down), (bottom[left + 1], down), (top[left + 1], above), (top[left], above)]
    return np.stack([np.stack(corner, axis=-1) for corner in corners], axis=1)


def _at_level(low: np.ndarray, high: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Where edges are at a height: exactly at their ends there."""
    share = (level - low[:, 1]) / (high[:, 1] - low[:, 1])
    return np.where(level == high[:, 1], high[:, 0], low[:, 0] + share * (high[:, 0] - low[:, 0]))
