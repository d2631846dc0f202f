"""Distances of points to triangles and of edges to edges, many pairs at a time, with bounds that hold in
spite of rounding.

A pair is four points x (k, 4, 3): a point and the three of a triangle, or the two points of each edge. Along
any direction n the hulls are at least min_ij n.(a_i - b_j) / |n| apart: however n was found, this is a lower
bound of the distance, and at the direction of the closest points it is the distance itself."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Kind(IntEnum):
    """Pairs by the number of points of their first side."""

    POINT_TRIANGLE = 1
    EDGE_EDGE = 2


#: Rounding error of a product n.(a - b) over |n|_1 |a - b|_max: a subtraction, three products, two sums,
#: generously.
GAP_ERROR = 16.0 * 2.0**-53
#: Rounding error of a normal u x v over |x|_max (|u| + |v|), generously: what is shorter has no direction.
_NORMAL_ERROR = 256.0 * 2.0**-53


def differences(kind: Kind, x: Floats) -> Floats:
    """All a_i - b_j: (k, 3, 3) or (k, 4, 3)."""
    count = int(kind)
    return (x[:, :count, None] - x[:, None, count:]).reshape(len(x), count * (4 - count), 3)


def gaps(n: Floats, d: Floats) -> tuple[Floats, Floats]:
    """n.(a_i - b_j) for unit n (k, 3) and differences d (k, m, 3): values (k, m) and a bound (k,) of their
    rounding errors."""
    return np.einsum("kc,kmc->km", n, d), GAP_ERROR * np.abs(d).max(axis=(1, 2)) * 3.0


def closest(kind: Kind, x: Floats) -> tuple[Floats, Floats]:
    """Distance (k,) and unit direction (k, 3), from the second side to the first one, of the closest points;
    the direction is zero where they coincide."""
    separation = _point_triangle(x) if kind == Kind.POINT_TRIANGLE else _edge_edge(x)
    distance = np.linalg.norm(separation, axis=1)
    return distance, separation / np.where(distance > 0.0, distance, 1.0)[:, None]


def lower_bound(kind: Kind, x: Floats, n: Floats) -> Floats:
    """Lower bound (k,) of the distance by the direction n, at least zero."""
    values, error = gaps(n, differences(kind, x))
    bound: Floats = np.maximum(0.0, (values.min(axis=1) - error) * (1.0 - 1e-14))
    return bound


def _to_segment(p: Floats, a: Floats, b: Floats) -> Floats:
    """From the closest point of the segment a b to p."""
    u = b - a
    length = _dot(u, u)
    t = np.clip(_dot(p - a, u) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    # Measured from the nearer end, so that little is lost to cancellation.
    near_a = t < 0.5
    base, part = np.where(near_a[:, None], a, b), np.where(near_a, t, t - 1.0)
    return (p - base) - part[:, None] * u


def _point_triangle(x: Floats) -> Floats:
    p, a, b, c = x.transpose(1, 0, 2)
    best = _nearest([_to_segment(p, a, b), _to_segment(p, b, c), _to_segment(p, c, a)])
    u, v, w = b - a, c - a, p - a
    normal = np.cross(u, v)
    area, has_normal = _area(x, u, v, normal)
    safe = np.where(has_normal, area, 1.0)
    beta, gamma = _dot(np.cross(w, v), normal) / safe, _dot(np.cross(u, w), normal) / safe
    inside = has_normal & (beta >= 0.0) & (gamma >= 0.0) & (beta + gamma <= 1.0)
    across = normal * (_dot(w, normal) / safe)[:, None]
    return np.where(inside[:, None], across, best)


def _edge_edge(x: Floats) -> Floats:
    a, b, c, d = x.transpose(1, 0, 2)
    best = _nearest(
        [_to_segment(a, c, d), _to_segment(b, c, d), -_to_segment(c, a, b), -_to_segment(d, a, b)]
    )
    u, v, w = b - a, d - c, a - c
    normal = np.cross(u, v)
    area, has_normal = _area(x, u, v, normal)
    safe = np.where(has_normal, area, 1.0)
    s, t = _dot(np.cross(v, w), normal) / safe, _dot(np.cross(u, w), normal) / safe
    inside = has_normal & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    across = normal * (_dot(w, normal) / safe)[:, None]
    shorter = inside & (_dot(across, across) <= _dot(best, best))
    return np.where(shorter[:, None], across, best)


def _area(x: Floats, u: Floats, v: Floats, normal: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Square of u x v, and whether it is more than rounding: edges may be parallel, triangles needles. Then
    ends and edges come as near as anything between, but for parts in 10^13 of their lengths."""
    area = _dot(normal, normal)
    length = np.linalg.norm(u, axis=1) + np.linalg.norm(v, axis=1)
    noise = _NORMAL_ERROR * np.abs(x).max(axis=(1, 2)) * length
    return area, area > noise * noise


def _nearest(candidates: list[Floats]) -> Floats:
    best, length = candidates[0], _dot(candidates[0], candidates[0])
    for other in candidates[1:]:
        squared = _dot(other, other)
        closer = squared < length
        best, length = np.where(closer[:, None], other, best), np.where(closer, squared, length)
    return best


def _dot(a: Floats, b: Floats) -> Floats:
    products: Floats = np.einsum("ki,ki->k", a, b)
    return products
