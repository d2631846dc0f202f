"""Meshes of the vacuum robot and of the gripper: lathed bodies, wheels, fingers, solid cylinders."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import stark


def lathed(profile: ArrayLike, segments: int) -> stark.mesh.TriangleMesh:
    """The closed surface that a profile of (radius, z) [m], from the lower to the upper pole, sweeps about
    the z axis."""
    points = np.asarray(profile, dtype=np.float64)
    angle = 2.0 * np.pi * np.arange(segments) / segments
    rings = [np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full(segments, z)]) for r, z in points]
    poles = [[0.0, 0.0, points[0, 1]], [0.0, 0.0, points[-1, 1]]]
    i, j = np.arange(segments), np.roll(np.arange(segments), -1)
    faces = []
    for ring in range(len(points) - 1):
        a, b = ring * segments, (ring + 1) * segments
        faces += [np.column_stack([a + i, a + j, b + j]), np.column_stack([a + i, b + j, b + i])]
    low, top = len(points) * segments, (len(points) - 1) * segments
    faces += [np.column_stack([j, i, low + 0 * i]), np.column_stack([top + i, top + j, low + 1 + 0 * i])]
    return stark.mesh.TriangleMesh(np.concatenate([*rings, poles]), np.concatenate(faces))


def wheel(radius: float, width: float, segments: int) -> stark.mesh.TriangleMesh:
    """A cylinder about the x axis [m] with the middle of a facet at the bottom."""
    upright = stark.mesh.cylinder(radius, width, segments)
    facet = stark.rotation(axis="z", angle=np.pi / segments)
    return upright.rotated(facet).rotated(stark.rotation(axis="y", angle=90 * stark.deg))


def prism(outline: ArrayLike, middle: ArrayLike, height: float) -> stark.mesh.TriangleMesh:
    """An outline (n, 2) [m] in the xy plane, counter-clockwise and seen as a whole from ``middle``, extruded
    to ``height`` about z = 0."""
    corners = np.asarray(outline, dtype=np.float64)
    n, top = len(corners), 0.5 * height
    flat = np.concatenate([corners, np.asarray(middle, dtype=np.float64)[None, :]])
    vertices = np.concatenate([np.column_stack([flat, np.full(n + 1, z)]) for z in (-top, top)])
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    sides = [np.column_stack([i, j, n + 1 + j]), np.column_stack([i, n + 1 + j, n + 1 + i])]
    caps = [np.column_stack([j, i, n + 0 * i]), np.column_stack([n + 1 + i, n + 1 + j, 2 * n + 1 + 0 * i])]
    return stark.mesh.TriangleMesh(vertices, np.concatenate([*sides, *caps]))


def solid_cylinder(radius: float, height: float, cells: int, layers: int) -> stark.mesh.TetMesh:
    """Tetrahedra in a cylinder about z: a box of ``cells`` x ``cells`` x ``layers`` whose squares about the
    axis become circles."""
    box = stark.mesh.tet_box((2.0, 2.0, height), (cells, cells, layers))
    x, y, z = box.vertices.T
    # The elliptical map of the square to the disc keeps cells at the corners open.
    round_ = radius * np.column_stack([x * np.sqrt(1.0 - 0.5 * y**2), y * np.sqrt(1.0 - 0.5 * x**2)])
    return stark.mesh.TetMesh(np.column_stack([round_, z]), box.tets)
