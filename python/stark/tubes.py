"""Surfaces of rods and fibres for pictures: outlines of sections, tubes, prisms around edges."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.mesh import Indices, Points

_SIDES = 8  # of round sections


def outline(material: Any) -> Points:
    """Corners of the section of a ``RodMaterial`` in the axes d1, d2 (k, 2) [m]."""
    if material.width > 0.0:
        corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
        rectangle: Points = 0.5 * np.array([material.width, material.height]) * corners
        return rectangle
    angle = np.arange(_SIDES) * (2.0 * np.pi / _SIDES)
    circle: Points = material.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return circle


def tube(rings: int, sides: int) -> Indices:
    """Triangles of a tube, outwards: rings of vertices one after the other, then the middles of both ends."""
    k = np.arange(sides)
    near, far = k, np.roll(k, -1)
    quads = np.concatenate(
        [np.column_stack([near, far, near + sides]), np.column_stack([far, far + sides, near + sides])]
    )
    walls = (quads[None] + sides * np.arange(rings - 1)[:, None, None]).reshape(-1, 3)
    middle, last = rings * sides, (rings - 1) * sides
    start = np.column_stack([far, near, np.full(sides, middle)])
    end = np.column_stack([near + last, far + last, np.full(sides, middle + 1)])
    return np.concatenate([walls, start, end]).astype(np.int32)


def rings(count: int, triangles: Indices) -> NDArray[np.int64] | None:
    """Vertices of each section (rings, sides), where ``tube`` or ``prisms`` made these triangles of ``count``
    vertices; else None."""
    sides = int(triangles[0, 2]) if len(triangles) else 0
    if sides < 3 or len(triangles) % (2 * sides):
        return None
    number = len(triangles) // (2 * sides)
    if count == number * sides + 2 and np.array_equal(triangles, tube(number, sides)):
        return np.arange(number * sides).reshape(number, sides)
    block = 2 * sides + 2
    starts = block * np.arange(number // 2)[:, None, None]
    if number % 2 or count != block * len(starts) or not np.array_equal(
        triangles.reshape(len(starts), -1, 3), tube(2, sides)[None] + starts
    ):  # fmt: skip
        return None
    return (starts + np.arange(2 * sides)[None, None]).reshape(number, sides)


def prisms(
    start: Points, end: Points, normals: NDArray[np.float64] | None, section: Points
) -> tuple[Points, Indices]:
    """A prism of this section around each edge: vertices (k, 3) and triangles. ``normals`` (m, 3) are the
    directions of d1, up to their parts along the edges; any if None."""
    d3 = end - start
    d3 = d3 / np.maximum(np.linalg.norm(d3, axis=1, keepdims=True), 1e-300)
    if normals is None:
        normals = np.eye(3)[np.abs(d3).argmin(axis=1)]
    d1 = normals - d3 * np.einsum("ij,ij->i", normals, d3)[:, None]
    d1 = d1 / np.maximum(np.linalg.norm(d1, axis=1, keepdims=True), 1e-300)
    around = section[:, 0, None] * d1[:, None] + section[:, 1, None] * np.cross(d3, d1)[:, None]
    rings = np.concatenate([start[:, None] + around, end[:, None] + around], axis=1)
    vertices = np.concatenate([rings, start[:, None], end[:, None]], axis=1)
    triangles = tube(2, len(section))[None] + vertices.shape[1] * np.arange(len(start))[:, None, None]
    return vertices.reshape(-1, 3), triangles.reshape(-1, 3).astype(np.int32)
