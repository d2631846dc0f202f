"""Which value is seen in each pixel: a perspective z-buffer in NumPy over meshes with numbers at their
vertices. Visibility is that of the rasteriser of the core (io/raster.h), which shades the same picture."""

from __future__ import annotations

import math

import numpy as np

from .camera import Camera
from .clipping import Plane, cut_triangles

#: Pairs of triangles and samples that are looked at at once; bounds the memory.
_CHUNK = 2_000_000


def values_seen(
    data: np.ndarray,
    triangles: np.ndarray,
    camera: Camera,
    size: tuple[int, int],
    near: float,
    rows: tuple[int, int] | None = None,
) -> np.ndarray:
    """Values at the middles of the pixels of a picture of ``size`` (width, height), shape (height, width), or
    of its ``rows`` from the first to before the second; NaN where no triangle is seen. ``data`` (n, 4) are
    the vertices: x, y, z [m], value; ``near`` [m] is the least depth that is drawn. O(triangles + samples in
    their boxes)."""
    forward = camera.axes()[2]
    before = Plane(-forward, float(-(np.dot(forward, camera.eye) + near)))
    data, triangles = cut_triangles(before, data, triangles)
    pixels, depth = camera.project(data[:, :3], size)
    width, (top, end) = size[0], rows or (0, size[1])
    seen = np.full(width * (end - top), np.nan)
    nearest = np.zeros(len(seen))  # inverse depth
    corners, inverse = pixels[triangles], 1.0 / depth[triangles]  # (m, 3, 2), (m, 3)
    low = np.ceil(corners.min(axis=1) - 0.5)
    high = np.floor(corners.max(axis=1) - 0.5)
    low, high = np.maximum(low, [0.0, top]), np.minimum(high, [width - 1.0, end - 1.0])
    columns, lines = (np.maximum(high - low + 1.0, 0.0).astype(np.int64)).T
    drawn = np.flatnonzero((columns > 0) & (lines > 0) & (_areas(corners) != 0.0))
    for part, first, count in _parts(drawn, columns * lines):
        triangle = np.repeat(part, count)
        place = (
            np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
        )
        x = low[triangle, 0] + place % columns[triangle]
        y = low[triangle, 1] + place // columns[triangle]
        weights = _weights(corners[triangle], x + 0.5, y + 0.5)
        inside = (weights >= 0.0).all(axis=1)
        triangle, weights = triangle[inside], weights[inside]
        pixel = ((y[inside] - top) * width + x[inside]).astype(np.int64)
        shares = weights * inverse[triangle]
        closeness = shares.sum(axis=1)
        np.maximum.at(nearest, pixel, closeness)
        won = closeness >= nearest[pixel]
        values = (shares * data[triangles[triangle], 3]).sum(axis=1) / closeness
        seen[pixel[won]] = values[won]
    return seen.reshape(end - top, width)


def _areas(corners: np.ndarray) -> np.ndarray:
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    return np.asarray((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1]))


def _weights(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Barycentric weights (n, 3) on the picture."""
    area = _areas(corners)
    weights = np.empty((len(x), 3))
    for i in range(3):
        p, q = corners[:, (i + 1) % 3], corners[:, (i + 2) % 3]
        weights[:, i] = ((p[:, 0] - x) * (q[:, 1] - y) - (q[:, 0] - x) * (p[:, 1] - y)) / area
    return weights


def _parts(drawn: np.ndarray, counts: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Triangles in groups of about a chunk of samples: indices, the first sample of each, how many. One with
    more samples than a chunk is in several groups."""
    parts = []
    small = drawn[counts[drawn] <= _CHUNK]
    group = np.cumsum(counts[small]) // _CHUNK
    for g in np.unique(group):
        chosen = small[group == g]
        parts.append((chosen, np.zeros(len(chosen), dtype=np.int64), counts[chosen]))
    for triangle in drawn[counts[drawn] > _CHUNK]:
        for k in range(math.ceil(counts[triangle] / _CHUNK)):
            rest = min(_CHUNK, int(counts[triangle]) - k * _CHUNK)
            parts.append((np.array([triangle]), np.array([k * _CHUNK]), np.array([rest])))
    return parts
