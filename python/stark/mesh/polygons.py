"""Polygons of mesh files cut into triangles that cover what their outlines enclose, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.caller import warn

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Twice the area of a triangle over the square of its longest side, below which it is flat.
_FLAT = 1e-9


def triangulated(vertices: Any, counts: Any, corners: Any, title: Callable[[int], str]) -> Ints:
    """Triangles (m, 3) of polygons, n - 2 of each with n corners, in their order. ``counts`` (k,): how many
    corners each has; ``corners``: their vertices, one polygon after the other; ``title(i)`` names polygon i
    and its file.

    A fan about the first corner is kept wherever it covers the polygon: of all convex ones. Others become a
    fan about another corner, or are cut by ear clipping (manifold3d), both as seen along the mean normal of
    the polygon. Warns of polygons that cross themselves or have no area."""
    points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    counts, corners = np.asarray(counts, dtype=np.int64), np.asarray(corners, dtype=np.int64)
    starts = np.cumsum(counts) - counts
    triangles = _fans(counts, corners, starts)
    if not len(corners) or counts.max() < 4 or not 0 <= corners.min() <= corners.max() < len(points):
        return triangles
    rows = np.cumsum(np.maximum(counts - 2, 0)) - np.maximum(counts - 2, 0)
    bad: list[int] = []
    for size in np.unique(counts[counts > 3]).tolist():
        which = np.flatnonzero(counts == size)
        outlines = points[corners[starts[which, None] + np.arange(size)]]
        for k in which[~_fits(*_shares(outlines))].tolist():
            outline = corners[starts[k] : starts[k] + size]
            cut = _cut(points[outline], title, k)
            if cut is None:
                bad.append(k)
            else:
                triangles[rows[k] : rows[k] + size - 2] = outline[cut]
    if bad:
        others = f" ({len(bad)} polygons, this is the first)" if len(bad) > 1 else ""
        warn(
            f"{title(min(bad))}: the polygon crosses itself or has no area{others}: cut into a fan, which "
            f"may leave its outline; triangulate it in the program that wrote the file"
        )
    return triangles


def _fans(counts: Ints, corners: Ints, starts: Ints) -> Ints:
    """About the first corner of each polygon."""
    many = np.maximum(counts - 2, 0)
    first = np.repeat(starts, many)
    step = np.arange(len(first)) - np.repeat(np.cumsum(many) - many, many) + 1
    return np.stack([corners[first], corners[first + step], corners[first + step + 1]], axis=1)


def _shares(outlines: Floats) -> tuple[Floats, Floats]:
    """Of the triangles of fans about the first corners of outlines (k, n, 3): twice their areas as seen along
    the mean normal (Newell's), over the squares of their longest sides (k, n - 2); and the angle of each fan
    at its first corner (k,) [rad]."""
    with np.errstate(invalid="ignore", over="ignore", under="ignore"):
        arms = outlines[:, 1:] - outlines[:, :1]
        size = np.abs(arms).max(axis=(1, 2), keepdims=True)
        arms = arms / np.where(size > 0.0, size, 1.0)
        a, b = arms[:, :-1], arms[:, 1:]
        normals = np.cross(a, b)
        mean = normals.sum(axis=1)
        length = np.linalg.norm(mean, axis=1, keepdims=True)
        mean = mean / np.where(length > 0.0, length, 1.0)
        areas = np.einsum("kij,kj->ki", normals, mean)
        angles = np.arctan2(areas, (a * b).sum(axis=2)).sum(axis=1)
        longest = np.maximum((a * a).sum(axis=2), np.maximum((b * b).sum(axis=2), ((b - a) ** 2).sum(axis=2)))
        return areas / np.where(longest > 0.0, longest, 1.0), angles


def _fits(shares: Floats, angles: Floats) -> NDArray[np.bool_]:
    """Whether fans cover their polygons once: no triangle is flat or turned over, and they go round less than
    once. Corners that are no numbers are for others to refuse."""
    return ~(shares <= _FLAT).any(axis=1) & ~(angles >= 2.0 * np.pi)


def _cut(outline: Floats, title: Callable[[int], str], polygon: int) -> Ints | None:
    """Triangles (n - 2, 3) of one polygon (n, 3), numbered from 0 in it; None if no cut covers it once."""
    size = len(outline)
    fan = np.stack([np.zeros(size - 2, dtype=np.int64), np.arange(1, size - 1), np.arange(2, size)], axis=1)
    shares, angles = _shares(outline[None])
    if not (shares > _FLAT).any():
        return None
    is_repeated = (outline == np.roll(outline, 1, axis=0)).all(axis=1).any()
    if is_repeated and (shares > -_FLAT).all() and angles[0] < 2.0 * np.pi:
        return fan  # files write triangles as polygons with a corner twice; no cut avoids the flat ones
    for first in range(1, size):
        if _fits(*_shares(np.roll(outline, -first, axis=0)[None]))[0]:
            return (fan + first) % size
    flat = _along_normal(outline)
    triangles = _clipped(flat, title, polygon)
    shares, _ = _shares(np.pad(flat[triangles], ((0, 0), (0, 0), (0, 1))))
    a, b = flat[triangles[:, 1]] - flat[triangles[:, 0]], flat[triangles[:, 2]] - flat[triangles[:, 0]]
    turned = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] < 0.0
    return None if (turned & (shares[:, 0] > _FLAT)).any() else triangles


def _clipped(outline: Floats, title: Callable[[int], str], polygon: int) -> Ints:
    """Triangles of an outline (n, 2) by the ear clipping of manifold3d, which keeps all corners, those on
    straight edges, too."""
    try:
        import manifold3d
    except ImportError as error:
        raise ImportError(
            f"{title(polygon)}: a polygon that is not convex needs manifold3d: pip install 'stark-sim[mesh]'"
        ) from error
    return np.asarray(manifold3d.triangulate([outline]), dtype=np.int64).reshape(-1, 3)


def _along_normal(outline: Floats) -> Floats:
    """Corners (n, 2) as seen against the mean normal, which makes their order counter-clockwise."""
    arms = outline - outline[0]
    arms = arms / max(float(np.abs(arms).max()), np.finfo(np.float64).tiny)
    normal = np.cross(arms[:-1], arms[1:]).sum(axis=0)
    # The right-handed frame whose third axis is the normal.
    _, _, axes = np.linalg.svd(normal[None])
    u, v = axes[1], axes[2]
    v = v if np.dot(np.cross(u, v), normal) >= 0.0 else -v
    return np.ascontiguousarray(arms @ np.stack([u, v], axis=1))
