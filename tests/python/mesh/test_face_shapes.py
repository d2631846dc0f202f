"""Faces of elements: the nodes of a surface's faces, and what each has of the area."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark.mesh.face_shapes import face_nodes, face_shares, shape_functions, uncut_faces


@pytest.mark.parametrize(
    ("count", "shares"),
    [
        (4, [1 / 4] * 4),
        (6, [0.0] * 3 + [1 / 3] * 3),
        (9, [1 / 36] * 4 + [4 / 36] * 4 + [16 / 36]),
    ],
)
def test_nodes_have_the_integrals_of_their_shape_functions(count: int, shares: list[float]) -> None:
    np.testing.assert_allclose(face_shares(count), shares, atol=1e-13)


@pytest.mark.parametrize("quadratic", [False, True])
def test_faces_of_a_surface_have_its_nodes_and_their_places(quadratic: bool) -> None:
    mesh = stark.mesh.box_hexahedra(0.2, 2)
    if quadratic:
        mesh = stark.mesh.to_quadratic(mesh)
    surface = mesh.surface_triangles()
    faces = uncut_faces(mesh, surface)
    assert faces is not None and len(faces) == 24
    np.testing.assert_array_equal(faces, face_nodes(mesh, surface))
    middles = shape_functions(faces.shape[1], 0.5, 0.5)[0] @ mesh.vertices[faces]
    assert np.allclose(np.abs(middles).max(axis=1), 0.1)  # on the box
    assert len(np.unique(middles.round(9), axis=0)) == 24


def test_surfaces_of_triangles_are_cut_from_nothing() -> None:
    block, sheet = stark.mesh.tet_box(0.2, 1), stark.mesh.grid(1.0, 1.0, 2)
    assert uncut_faces(block, block.surface_triangles()) is None
    assert uncut_faces(sheet, sheet.triangles) is None
