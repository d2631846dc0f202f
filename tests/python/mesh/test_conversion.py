"""Meshes in the forms that other libraries have."""

from __future__ import annotations

import types

import numpy as np
import pytest

import stark
from stark import mesh


def test_meshes_of_trimesh_are_read_by_the_indices_of_their_faces() -> None:
    """Their `triangles` are corners (n, 3, 3)."""
    box = mesh.box(1.0)
    theirs = types.SimpleNamespace(
        vertices=box.vertices, faces=box.triangles, triangles=box.vertices[box.triangles]
    )
    body = stark.Scene().add_rigid(theirs, mass=1.0)
    assert (body.triangles == box.triangles).all()


def test_meshes_come_in_many_forms() -> None:
    class Trimesh:
        vertices = mesh.box(1.0).vertices
        faces = mesh.box(1.0).triangles.astype(np.int64)

    scene = stark.Scene()
    assert scene.add_rigid(Trimesh(), mass=1.0).mesh.triangles.dtype == np.int32
    scene.add_cloth(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    grid = mesh.grid(1, 1, 3)
    single_precision_by_columns = np.asfortranarray(grid.vertices.astype(np.float32))
    every_other_row = np.repeat(grid.triangles.astype(np.uint64), 2, axis=0)[::2]
    cloth = scene.add_cloth((single_precision_by_columns, every_other_row))
    np.testing.assert_allclose(cloth.positions, grid.vertices, atol=1e-7)
    assert np.array_equal(cloth.triangles, grid.triangles)


def test_quadratic_elements_have_nodes_between_the_corners() -> None:
    linear = mesh.tet_box((1, 2, 3), 2)
    quadratic = mesh.to_quadratic(linear)
    edges = {tuple(sorted(pair)) for t in linear.tets.tolist() for pair in zip(t, t[1:] + t[:1], strict=True)}
    edges |= {tuple(sorted(pair)) for t in linear.tets.tolist() for pair in ((t[0], t[2]), (t[1], t[3]))}
    assert quadratic.elements.shape == (len(linear.tets), 10)
    assert len(quadratic.vertices) == len(linear.vertices) + len(edges)
    assert np.array_equal(quadratic.elements[:, :4], linear.tets)
    middles = {tuple(p) for p in quadratic.vertices[quadratic.elements[:, 4:]].reshape(-1, 3).round(12)}
    assert middles == {tuple(linear.vertices[list(pair)].mean(axis=0).round(12)) for pair in edges}
    hexahedra = mesh.to_quadratic(mesh.box_hexahedra(1.0, 1))
    assert hexahedra.elements.shape == (1, 27) and len(hexahedra.vertices) == 27


@pytest.mark.parametrize(
    ("convert", "given", "message"),
    [
        (mesh.as_triangle_mesh, mesh.tet_box(1.0, 1), "got a TetMesh: must be a TriangleMesh"),
        (
            mesh.as_triangle_mesh,
            mesh.box_hexahedra(1.0, 1),
            r"got a SolidMesh.*use add_solid, or mesh\.surface",
        ),
        (mesh.as_triangle_mesh, mesh.lattice(mesh.box(1.0), cells=1), r"got a lattice.*mesh\.surface\(\)"),
        (mesh.as_triangle_mesh, "bunny.obj", r"stark\.mesh\.load"),
        (mesh.as_triangle_mesh, ([[0, 0, 0]], [[0, 1]]), r"must be \(m, 3\)"),
        (mesh.as_tet_mesh, mesh.box(1.0), "tetrahedralise"),
        (mesh.as_tet_mesh, 5, "got int"),
        (mesh.as_solid_mesh, ([[0, 0, 0]], np.zeros((1, 8))), "must be integers"),
        (mesh.as_polyline, mesh.box(1.0), "got a TriangleMesh"),
        (mesh.as_polyline, [[0, 0]], r"\(n, 3\)"),
    ],
)
def test_what_is_no_mesh_is_refused_with_the_name_of_the_body(convert, given, message: str) -> None:
    with pytest.raises(stark.InvalidMesh, match=message) as caught:
        convert(given, "cloth 'a'")
    assert str(caught.value).startswith("cloth 'a': ")
