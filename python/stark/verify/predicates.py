"""Whether segments meet triangles, exactly: orientations in floating point where their sign is certain, else
in fractions, which hold doubles without rounding.

The bound of the rounding error is the one of Shewchuk's first filter (Adaptive precision floating-point
arithmetic and fast robust geometric predicates, 1997)."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from .distances import Kind, closest, gaps

Floats = NDArray[np.float64]
Point = tuple[Fraction, Fraction, Fraction]

_EPSILON = 2.0**-53
_ORIENT_ERROR = (7.0 + 56.0 * _EPSILON) * _EPSILON
_UNDERFLOW = 1e-290  # products of differences below this may have lost digits


def orientation_signs(a: Floats, b: Floats, c: Floats, d: Floats) -> NDArray[np.int8]:
    """Sign of the volume of the tetrahedra (a, b, c, d), each (k, 3): -1, 1, or 0 where it is not certain."""
    u, v, w = a - d, b - d, c - d
    first, second = v[:, [1, 2, 0]] * w[:, [2, 0, 1]], v[:, [2, 0, 1]] * w[:, [1, 2, 0]]
    volume = ((first - second) * u).sum(axis=1)
    size = ((np.abs(first) + np.abs(second)) * np.abs(u)).sum(axis=1)
    certain = np.abs(volume) > 2.0 * _ORIENT_ERROR * size + _UNDERFLOW
    return np.where(certain, np.sign(volume), 0.0).astype(np.int8)


def segments_meet_triangles(p: Floats, q: Floats, a: Floats, b: Floats, c: Floats) -> NDArray[np.bool_]:
    """Whether the closed segments p q meet the closed triangles a b c, each (k, 3)."""
    result = np.zeros(len(p), dtype=bool)
    side_p, side_q = orientation_signs(a, b, c, p), orientation_signs(a, b, c, q)
    rows = np.flatnonzero((side_p == 0) | (side_p != side_q))  # others are on one side of the plane
    if not len(rows):
        return result
    p, q, a, b, c = (points[rows] for points in (p, q, a, b, c))
    around = np.stack([orientation_signs(p, q, s, t) for s, t in ((a, b), (b, c), (c, a))], axis=1)
    misses = (around == 1).any(axis=1) & (around == -1).any(axis=1)
    crosses = (side_p[rows] * side_q[rows] == -1) & (np.abs(around.sum(axis=1)) == 3)
    result[rows] = crosses
    unsure = np.flatnonzero(~misses & ~crosses)
    unsure = unsure[~_certainly_apart(*(points[unsure] for points in (p, q, a, b, c)))]
    for k in unsure:
        result[rows[k]] = _meets_exactly(*(_exact(points[k]) for points in (p, q, a, b, c)))
    return result


def _certainly_apart(p: Floats, q: Floats, a: Floats, b: Floats, c: Floats) -> NDArray[np.bool_]:
    """Where a plane across the closest points separates them by more than rounding: most pairs of flat
    sheets."""
    ends = np.stack([p, q], axis=1)
    corners = np.stack([a, b, c], axis=1)
    found = [
        *(closest(Kind.POINT_TRIANGLE, np.concatenate([ends[:, [k]], corners], axis=1)) for k in (0, 1)),
        *(
            closest(Kind.EDGE_EDGE, np.concatenate([ends, corners[:, [k, (k + 1) % 3]]], axis=1))
            for k in range(3)
        ),
    ]
    distances, directions = (np.stack(column) for column in zip(*found, strict=True))
    n = directions[distances.argmin(axis=0), np.arange(len(p))]
    values, error = gaps(n, (ends[:, :, None] - corners[:, None]).reshape(len(p), 6, 3))
    apart: NDArray[np.bool_] = values.min(axis=1) > error
    return apart


def _exact(point: Floats) -> Point:
    x, y, z = (Fraction(float(value)) for value in point)
    return x, y, z


def _minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Point, b: Point) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _meets_exactly(p: Point, q: Point, a: Point, b: Point, c: Point) -> bool:
    normal = _cross(_minus(b, a), _minus(c, a))
    if not any(normal):  # a triangle without area is its longest side, at most
        return any(_segments_meet(p, q, s, t) for s, t in ((a, b), (b, c), (c, a)))
    height_p, height_q = _dot(normal, _minus(p, a)), _dot(normal, _minus(q, a))
    if height_p * height_q > 0:
        return False
    if height_p == 0 and height_q == 0:
        sides = ((a, b), (b, c), (c, a))
        return _in_triangle(p, a, b, c, normal) or any(_segments_meet(p, q, s, t) for s, t in sides)
    t = height_p / (height_p - height_q)
    d = _minus(q, p)
    return _in_triangle((p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]), a, b, c, normal)


def _in_triangle(p: Point, a: Point, b: Point, c: Point, normal: Point) -> bool:
    """Of a point in the plane of the triangle."""
    return all(_dot(normal, _cross(_minus(t, s), _minus(p, s))) >= 0 for s, t in ((a, b), (b, c), (c, a)))


def _segments_meet(p: Point, q: Point, s: Point, t: Point) -> bool:
    u, v, w = _minus(q, p), _minus(t, s), _minus(s, p)
    normal = _cross(u, v)
    area = _dot(normal, normal)
    if area != 0:
        if _dot(normal, w) != 0:
            return False
        along_u, along_v = _dot(normal, _cross(w, v)) / area, _dot(normal, _cross(w, u)) / area
        return 0 <= along_u <= 1 and 0 <= along_v <= 1
    if not any(u):
        return _on_segment(p, s, t)
    return any((_on_segment(p, s, t), _on_segment(s, p, q), _on_segment(t, p, q)))


def _on_segment(p: Point, s: Point, t: Point) -> bool:
    v, w = _minus(t, s), _minus(p, s)
    return not any(_cross(v, w)) and 0 <= _dot(v, w) <= _dot(v, v)
