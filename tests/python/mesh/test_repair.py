"""Repairs of meshes: orientation, double vertices, vertices without elements."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark import mesh
from stark.mesh.repair import equal_rows
from stark.mesh.types import edge_counts


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
    # Wherever the borders of a grid are: corners on one stayed apart, and the surface was open.
    for place in (5e-7, 1.0 / 3.0, 7.77, 1000.0000005):
        assert mesh.merged(noisy.translated((place, 2.0 * place, -place)), 1e-6).is_closed
    spare = mesh.TriangleMesh(np.vstack([[[9, 9, 9]], box.vertices]), box.triangles + 1)
    assert len(mesh.compact(spare).vertices) == 8 and mesh.compact(spare).volume == pytest.approx(1.0)


@pytest.mark.parametrize(
    "block",
    [mesh.tet_box(0.1, 2), mesh.box_hexahedra(0.1, 2), mesh.to_quadratic(mesh.tet_box(0.1, 1))],
    ids=["tet4", "hex8", "tet10"],
)
def test_merged_joins_the_parts_of_a_solid(block: mesh.TetMesh | mesh.SolidMesh) -> None:
    apart = type(block)(
        np.vstack([block.vertices, block.vertices + np.array([0.1 + 1e-9, 0.0, 0.0])]),
        np.vstack([block.elements, block.elements + len(block.vertices)]),
    )
    side = int((abs(block.vertices[:, 0] - 0.05) < 1e-9).sum())
    assert len(mesh.merged(apart).vertices) == len(apart.vertices)  # not at the same place to the last bit
    joined = mesh.merged(apart, 1e-7)
    assert len(joined.vertices) == len(apart.vertices) - side
    assert joined.volumes.sum() == pytest.approx(0.002, rel=1e-6)
    assert len(joined.elements) == len(apart.elements)


def test_noise_of_a_scan_leaves_no_cracks() -> None:
    """With noise of a tenth of the tolerance half as many vertices again were left, on borders of cells."""
    ball = mesh.sphere(1.0, 4)
    noise = np.random.default_rng(3).uniform(-1e-5, 1e-5, (3 * len(ball.triangles), 3))
    soup = mesh.TriangleMesh(
        ball.vertices[ball.triangles].reshape(-1, 3) + noise, np.arange(len(noise)).reshape(-1, 3)
    )
    found = mesh.merged(soup, 1e-4)
    assert found.is_closed and len(found.vertices) == len(ball.vertices)
    assert len(mesh.cleaned(soup, tolerance=1e-4).triangles) == len(ball.triangles)
    # What is farther apart stays so, and a coarse tolerance thins out.
    assert len(mesh.merged(ball, 1e-3).vertices) == len(ball.vertices)
    assert 100 < len(mesh.merged(ball, 0.2).vertices) < 1000


def test_equal_rows_are_those_of_numpy() -> None:
    generator = np.random.default_rng(3)
    rows = generator.integers(-2, 2, (200, 3)) * 1.0
    rows[generator.random(rows.shape) < 0.3] *= -1.0  # also -0.0, which is 0.0
    first, groups = equal_rows(rows)
    _, expected, which = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    assert np.array_equal(first, np.sort(expected)) and np.array_equal(
        first[groups], expected[which.reshape(-1)]
    )
    assert [len(part) for part in equal_rows(np.empty((0, 3)))] == [0, 0]
    assert len(equal_rows(np.array([[0.0, np.nan], [0.0, np.nan]]))[0]) == 2


def test_each_of_many_parts_faces_outwards_and_one_sided_strips_stay_whole() -> None:
    generator, box = np.random.default_rng(6), mesh.box(1.0)
    parts = mesh.joined([box.translated((2.0 * k, 0, 0)) for k in range(40)])
    triangles = parts.triangles.copy()
    wrong = generator.random(len(triangles)) < 0.4
    triangles[wrong] = triangles[wrong][:, ::-1]
    order = generator.permutation(len(triangles))
    repaired = mesh.oriented(mesh.TriangleMesh(parts.vertices, triangles[order]))
    for k in range(40):
        mine = (repaired.triangles // 8 == k).all(axis=1)
        assert mesh.TriangleMesh(parts.vertices, repaired.triangles[mine]).volume == pytest.approx(1.0)
    strip = np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 0], [4, 0, 1], [4, 1, 0]])
    twisted = mesh.oriented(mesh.TriangleMesh(np.eye(5)[:, :3], strip))
    assert np.array_equal(np.sort(twisted.triangles, axis=1), np.sort(strip, axis=1))


def test_closed_surfaces_by_numbers_of_edges() -> None:
    ball = mesh.sphere(1.0, 2)
    assert ball.is_closed and not mesh.TriangleMesh(ball.vertices, ball.triangles[1:]).is_closed
    assert sorted(edge_counts(np.array([[0, 1, 2], [2, 1, 3], [1, 2, 4]])).tolist()) == [1] * 6 + [3]
    far = np.array([[0, 2**31 - 1, 5], [2**31 - 1, 0, 7]], dtype=np.int32)
    assert sorted(edge_counts(far).tolist()) == [1, 1, 1, 1, 2]
