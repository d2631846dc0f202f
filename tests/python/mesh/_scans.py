"""A scan as scanners make it, of any size: noise, holes, double vertices, turned triangles, loose pieces."""

from __future__ import annotations

import numpy as np

import stark
from stark.mesh import TriangleMesh


def animal(subdivisions: int) -> TriangleMesh:
    """A closed surface 0.3 m long with limbs, as a function on a sphere."""
    ball = stark.mesh.sphere(1.0, subdivisions)
    x, y, z = ball.vertices.T
    radius = 1.0 + 0.25 * np.sin(3.0 * x) * np.cos(2.0 * y) + 0.1 * np.sin(7.0 * z + x)
    return TriangleMesh(0.1 * ball.vertices * radius[:, None] * (1.3, 1.0, 0.8), ball.triangles)


def scan(subdivisions: int, seed: int = 0) -> TriangleMesh:
    """That surface, scanned."""
    random = np.random.default_rng(seed)
    surface = animal(subdivisions)
    spacing = 0.12 / 2.0**subdivisions  # of vertices [m]
    vertices = surface.vertices + random.normal(scale=0.1 * spacing, size=surface.vertices.shape)
    triangles = _with_holes(vertices, surface.triangles, spacing, random)
    turned = random.random(len(triangles)) < 0.05
    triangles[turned] = triangles[turned][:, ::-1]
    own = np.flatnonzero(random.random(len(triangles)) < 0.1)  # with vertices of their own
    doubles = vertices[triangles[own]].reshape(-1, 3)
    triangles[own] = len(vertices) + np.arange(len(doubles)).reshape(-1, 3)
    vertices = np.concatenate([vertices, doubles])
    triangles = np.concatenate([triangles, triangles[:50]])
    crumb = stark.mesh.sphere(0.004, 1)
    crumbs = [crumb.translated(random.normal(scale=0.15, size=3)) for _ in range(6)]
    return stark.mesh.joined([TriangleMesh(vertices, triangles), *crumbs])


def _with_holes(
    vertices: np.ndarray, triangles: np.ndarray, spacing: float, random: np.random.Generator
) -> np.ndarray:
    centers = vertices[triangles].mean(axis=1)
    keep = np.ones(len(triangles), dtype=bool)
    for k in range(20):
        reach = 0.03 if k == 0 else random.uniform(1.0, 4.0) * spacing
        keep &= np.linalg.norm(centers - centers[random.integers(len(centers))], axis=1) > reach
    return triangles[keep].copy()
