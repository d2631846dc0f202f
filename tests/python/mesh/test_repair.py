"""Repairs of meshes: orientation, double vertices, vertices without elements."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark import mesh


def test_oriented_repairs_any_mixture() -> None:
    sphere = mesh.sphere(1.0, 2)
    generator = np.random.default_rng(5)
    triangles = sphere.triangles.copy()
    wrong = generator.random(len(triangles)) < 0.5
    triangles[wrong] = triangles[wrong][:, ::-1]
    two = mesh.TriangleMesh(
        np.vstack([sphere.vertices, sphere.vertices + 5]),
        np.vstack([triangles, triangles[:, ::-1] + len(sphere.vertices)]),
    )
    repaired = mesh.oriented(two)
    assert repaired.volume == pytest.approx(2 * sphere.volume, rel=1e-12)
    stark.Scene().add_rigid(repaired, density=1.0)
    tets = mesh.tet_box(1.0, 2)
    mixed = tets.tets.copy()
    mixed[::3] = mixed[::3][:, [1, 0, 2, 3]]
    assert (mesh.oriented(mesh.TetMesh(tets.vertices, mixed)).volumes > 0).all()


def test_merged_and_compact() -> None:
    box = mesh.box(1.0)
    soup = mesh.TriangleMesh(box.vertices[box.triangles].reshape(-1, 3), np.arange(36).reshape(-1, 3))
    joined = mesh.merged(soup)
    assert len(joined.vertices) == 8 and joined.is_closed and joined.volume == pytest.approx(1.0)
    noisy = mesh.TriangleMesh(soup.vertices + 1e-9 * np.sin(np.arange(108)).reshape(-1, 3), soup.triangles)
    assert len(mesh.merged(noisy, 1e-6).vertices) == 8
    spare = mesh.TriangleMesh(np.vstack([[[9, 9, 9]], box.vertices]), box.triangles + 1)
    assert len(mesh.compact(spare).vertices) == 8 and mesh.compact(spare).volume == pytest.approx(1.0)
