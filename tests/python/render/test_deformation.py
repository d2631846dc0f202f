"""Deformation gradients of all kinds of elements, means at vertices."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import stark
from stark.render.deformation import at_vertices, of_cloth, of_solid, shape_slopes

TETS = stark.mesh.tet_box((0.2, 0.1, 0.3), (2, 1, 3))
BRICKS = stark.mesh.box_hexahedra((0.2, 0.1, 0.3), (2, 1, 3))
MESHES = {4: TETS, 8: BRICKS, 10: stark.mesh.to_quadratic(TETS), 27: stark.mesh.to_quadratic(BRICKS)}


@pytest.mark.parametrize("nodes", MESHES)
def test_quadratic_motion_is_seen_by_quadratic_elements(nodes: int) -> None:
    """x = X + (0, 0, a X_0^2) has F_20 = 2 a X_0: exact at the nodes of quadratic elements, the mean over the
    element in linear ones; affine motion is exact in all."""
    mesh, A, a = MESHES[nodes], np.array([[1.2, 0.1, 0], [0, 0.9, 0.3], [-0.2, 0, 1.1]]), 3.0
    body = SimpleNamespace(mesh=mesh, positions=mesh.vertices @ A.T + (1, 2, 3))
    deformation = of_solid(body)
    assert deformation.gradients == pytest.approx(np.broadcast_to(A, deformation.gradients.shape))
    assert deformation.sizes.sum() == pytest.approx(0.2 * 0.1 * 0.3)
    body.positions = mesh.vertices + np.outer(a * mesh.vertices[:, 0] ** 2, (0, 0, 1))
    slopes = of_solid(body).gradients[..., 2, 0]
    if nodes in (10, 27):
        assert slopes == pytest.approx(2.0 * a * mesh.vertices[deformation.elements, 0], abs=1e-12)
    else:
        assert slopes.mean() == pytest.approx(2.0 * a * mesh.vertices[:, 0].mean(), abs=0.3)


@pytest.mark.parametrize("nodes", MESHES)
def test_shape_functions_add_up_to_one(nodes: int) -> None:
    assert np.abs(shape_slopes(nodes).sum(axis=1)).max() < 1e-12


@pytest.mark.parametrize("first", [None, (1.0, 0.5, 7.0)])
def test_cloth_that_is_folded_and_stretched(first) -> None:
    mesh = stark.mesh.grid(0.4, 0.4, cells=3)
    angle = 0.3
    R = stark.rotation(axis=(1, 2, 3), angle=angle)
    body = SimpleNamespace(
        mesh=mesh, triangles=mesh.triangles, positions=mesh.vertices @ np.diag([1.1, 0.95, 1]) @ R.T
    )
    deformation = of_cloth(body, None if first is None else np.array(first))
    F = deformation.gradients
    assert F.shape == (len(mesh.triangles), 1, 3, 2)
    stretches = np.linalg.svd(F, compute_uv=False)
    assert stretches == pytest.approx(np.broadcast_to([1.1, 0.95], stretches.shape))
    if first is not None:  # the first column is what became of the warp
        warp = np.array([1.0, 0.5, 0.0]) / np.hypot(1.0, 0.5) @ np.diag([1.1, 0.95, 1]) @ R.T
        assert F[:, 0, :, 0] == pytest.approx(np.broadcast_to(warp, (len(F), 3)))


def test_means_are_weighted_by_size() -> None:
    body = SimpleNamespace(mesh=TETS, positions=TETS.vertices)
    deformation = of_solid(body)
    values = np.arange(len(TETS.tets), dtype=float)[:, None]
    means = at_vertices(deformation, values, len(TETS.vertices) + 1)
    for vertex in (0, 5):
        mine = (TETS.tets == vertex).any(axis=1)
        expected = np.average(values[mine, 0], weights=TETS.volumes[mine])
        assert means[vertex] == pytest.approx(expected)
    assert means[-1] == 0.0  # of no element
    tensors = at_vertices(deformation, values[..., None, None] * np.eye(3), len(TETS.vertices))
    assert tensors[:, 1, 1] == pytest.approx(means[:-1]) and np.abs(tensors[:, 0, 1]).max() == 0.0


def test_what_a_sheet_is_at_rest_is_computed_once() -> None:
    """Its deformation is that of the state that is asked for, by all handles of the body."""
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.2, 0.1, cells=(4, 2)), stark.materials.cotton)
    sims = [stark.Simulation(scene) for _ in range(2)]
    first = of_cloth(sheet)
    with sims[1].placing():
        sims[1][sheet].positions = 1.5 * np.asarray(sheet.positions)
    stretched, again = of_cloth(sims[1][sheet]), of_cloth(sims[0][sheet])
    assert stretched.sizes is first.sizes
    assert stretched.gradients == pytest.approx(1.5 * np.asarray(first.gradients), abs=1e-12)
    assert (again.gradients == first.gradients).all()
    along = of_cloth(sims[1][sheet], np.array([1.0, 1.0, 0.0]))
    assert np.linalg.norm(along.gradients, axis=-2) == pytest.approx(1.5)
