"""Meshes and measures that only these scenes need."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import stark

Floats = NDArray[np.float64]


def column_of_rings(rings: Floats, closed: bool) -> stark.TriangleMesh:
    """Surface through rings of points (k, n, 3); ``closed``: the last ring joins the first, as in a tube that
    bites its tail; otherwise lids close its ends."""
    count, n = rings.shape[:2]
    vertices = rings.reshape(-1, 3)
    triangles = []
    for k in range(count if closed else count - 1):
        for i in range(n):
            a, b = k * n + i, k * n + (i + 1) % n
            c, d = (k + 1) % count * n + i, (k + 1) % count * n + (i + 1) % n
            triangles += [(a, b, d), (a, d, c)]
    if not closed:
        centres = np.stack([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
        low, high = count * n, count * n + 1
        vertices = np.concatenate([vertices, centres])
        last = (count - 1) * n
        for i in range(n):
            j = (i + 1) % n
            triangles += [(low, j, i), (high, last + i, last + j)]
    return stark.mesh.oriented(stark.TriangleMesh(vertices, triangles))


def screw(radius: float, depth: float, pitch: float, height: float, segments: int) -> Floats:
    """Rings (k, n, 3) of a bolt about z: a circle of ``radius``, out of the axis by ``depth``, that turns
    once a ``pitch``."""
    levels = np.linspace(0.0, height, max(2, round(segments * height / pitch)) + 1)
    turn = np.linspace(0.0, 2.0 * np.pi, segments, endpoint=False)
    z, angle = np.meshgrid(levels, turn, indexing="ij")
    phase = 2.0 * np.pi * z / pitch
    # Points of the same angle around the axis of the circle, so that the thread is the same at any height.
    x = depth * np.cos(phase) + radius * np.cos(angle)
    y = depth * np.sin(phase) + radius * np.sin(angle)
    return np.stack([x, y, z], axis=-1)


def nut(inner: Floats, outer_radius: float) -> stark.TriangleMesh:
    """A cylinder of ``outer_radius`` around the hole that the rings ``inner`` bound."""
    angle = np.linspace(0.0, 2.0 * np.pi, inner.shape[1], endpoint=False)
    circle = outer_radius * np.column_stack([np.cos(angle), np.sin(angle)])
    outer = inner.copy()
    outer[..., :2] = circle
    return column_of_rings(np.concatenate([inner, outer[::-1]]), closed=True)


def slivers(length: float, width: float, count: int) -> stark.TriangleMesh:
    """A strip of triangles of a base ``width``/``count`` and a height ``length``."""
    x = np.linspace(-width / 2, width / 2, count + 1)
    low = np.column_stack([x, 0 * x - length / 2, 0 * x])
    high = np.column_stack([x, 0 * x + length / 2, 0 * x])
    triangles = []
    for k in range(count):
        triangles += [(k, k + 1, count + 1 + k), (k + 1, count + 2 + k, count + 1 + k)]
    return stark.TriangleMesh(np.concatenate([low, high]), triangles)


def overhand_knot(size: float, segments: int) -> Floats:
    """A loose one (n, 3) that runs from below to above [m]: the polynomial trefoil of Shastri (1992)."""
    t = np.linspace(-2.15, 2.15, 4000)
    curve = np.column_stack([t**3 - 3.0 * t, t**4 - 4.0 * t**2, (t**5 - 10.0 * t) / 3.0])
    return resampled(size * curve, segments)


def resampled(points: Floats, segments: int) -> Floats:
    """Points (segments + 1, 3) at equal distances along a chain."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], segments + 1)
    return np.column_stack([np.interp(at, along, points[:, k]) for k in range(3)])


def total_curvature(points: Floats) -> float:
    """Sum of the angles of a chain [rad]."""
    d = np.diff(points, axis=0)
    d /= np.linalg.norm(d, axis=1)[:, None]
    return float(np.arccos(np.clip((d[1:] * d[:-1]).sum(axis=1), -1.0, 1.0)).sum())


def linking_number(a: Floats, b: Floats) -> float:
    """Of two closed polygons (n, 3), (m, 3) [Gauss]: solid angles of pairs of edges, exact."""
    total = 0.0
    a1, b1 = np.roll(a, -1, axis=0), np.roll(b, -1, axis=0)
    for p, q in zip(a, a1, strict=True):
        corners = [b - p, b - q, b1 - q, b1 - p]
        normals = [np.cross(corners[k], corners[(k + 1) % 4]) for k in range(4)]
        normals = [n / np.maximum(np.linalg.norm(n, axis=1), 1e-300)[:, None] for n in normals]
        solid = sum(
            np.arcsin(np.clip((normals[k] * normals[(k + 1) % 4]).sum(axis=1), -1.0, 1.0)) for k in range(4)
        )
        sign = np.sign((np.cross(q - p, b1 - b) * (b - p)).sum(axis=1))
        total += float((solid * sign).sum())
    return total / (4.0 * np.pi)


def side_of(body: Any, sheet: Any) -> int:
    """Parity of the crossings of a ray straight up from the centre of a body with the upper faces of a sheet
    that was flat about z: 0 above it, 1 below."""
    centre, rest = body.position, sheet.mesh.vertices[:, 2]
    upper = (rest[sheet.triangles] > rest.max() - 1e-9).all(axis=1)
    x = sheet.positions[sheet.triangles[upper]]
    a, b, c = (x[:, i, :2] - centre[:2] for i in range(3))

    def cross(p: Floats, q: Floats) -> Floats:
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    weights = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=1)
    hit = (weights > 0).all(axis=1) | (weights < 0).all(axis=1)
    heights = (weights[hit] * x[hit][:, :, 2]).sum(axis=1) / weights[hit].sum(axis=1)
    return int((heights > centre[2]).sum()) % 2
