"""Mesh types: surfaces, areas, volumes, transformations, and arrays that are no mesh."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark import mesh


def test_the_surface_of_tets_agrees_with_the_core() -> None:
    box = mesh.tet_box((1, 2, 3), (2, 3, 4))
    surface = box.surface()
    assert surface.is_closed and surface.volume == pytest.approx(6.0, rel=1e-13)
    assert len(surface.vertices) == 3 * 4 * 5 - 1 * 2 * 3


def test_transformations() -> None:
    box = mesh.box(1.0)
    assert box.scaled(1e-3).volume == pytest.approx(1e-9, rel=1e-13)
    assert box.scaled((1, 2, 3)).volume == pytest.approx(6.0, rel=1e-13)
    np.testing.assert_allclose(box.translated((1, 2, 3)).centered().vertices, box.vertices, atol=1e-15)
    turned = box.rotated(stark.rotation(axis="z", angle=np.pi / 2))
    np.testing.assert_allclose(turned.vertices[:, 0], -box.vertices[:, 1], atol=1e-15)
    assert box.flipped().volume == pytest.approx(-1.0, rel=1e-13)


def test_volumes_and_sides_of_surfaces_do_not_depend_on_where_they_are() -> None:
    """About the origin, that of a ring 1 km away was 10 % off, and at 100 km rounding chose its outside."""
    ring = mesh.torus(0.01, 0.004)
    away = ring.translated((1e3, 2e3, -1e3))
    assert away.volume == pytest.approx(ring.volume, rel=1e-8)
    for there in (away, ring.translated((1e5, -1e5, 2e5))):
        for given in (there, there.flipped()):
            assert mesh.oriented(given).volume == pytest.approx(ring.volume, rel=1e-3)


def test_areas_and_bounds_are_those_of_closed_forms() -> None:
    sheet = mesh.grid(2.0, 3.0, (4, 5))
    assert sheet.area == pytest.approx(6.0, rel=1e-13) and not sheet.is_closed
    low, high = mesh.box((1, 2, 3)).bounds
    assert low.tolist() == [-0.5, -1, -1.5] and high.tolist() == [0.5, 1, 1.5]
    assert mesh.box((1, 2, 3)).area == pytest.approx(22.0, rel=1e-13)
    assert mesh.tet_box((1, 2, 3), 2).volume == pytest.approx(6.0, rel=1e-13)


def test_arrays_that_are_no_mesh_are_refused() -> None:
    corners = np.eye(3)
    with pytest.raises(stark.InvalidMesh, match=r"must be in \[0, 3\)"):
        _ = mesh.TriangleMesh(corners, [[0, 1, 3]]).area
    for elements in ([[0, 1, 2, 3]], [list(range(8))]):
        nothing = mesh.SolidMesh(np.empty((0, 3)), elements)
        for ask in (lambda m: m.volumes, lambda m: m.volume, mesh.to_quadratic):
            with pytest.raises(stark.InvalidMesh, match=r"refers to vertex 0: .*must be in \[0, 0\)"):
                ask(nothing)
    with pytest.raises(stark.InvalidMesh, match=r"must be \(m, 4\)"):
        mesh.TetMesh(corners, [[0, 1, 2]])
    with pytest.raises(stark.InvalidMesh, match=r"must be \(n, 3\)"):
        mesh.Polyline([[0, 0], [1, 1]])


def test_compact_leaves_unused_vertices_out_and_keeps_the_shape() -> None:
    box = mesh.box(1.0)
    padded = mesh.TriangleMesh(np.concatenate([[[9, 9, 9]], box.vertices]), box.triangles + 1)
    kept = mesh.compact(padded)
    assert np.array_equal(kept.vertices[kept.triangles], box.vertices[box.triangles])
    assert len(kept.vertices) == len(box.vertices)


def test_tetrahedra_have_the_name_of_other_elements_too() -> None:
    box = mesh.tet_box(0.1, 1)
    assert box.elements is box.tets
    assert box.vertices[box.elements].shape == (len(box.tets), 4, 3)


def test_arrays_that_are_given_are_copied() -> None:
    """A loop that moves one array and makes a mesh of it in each pass gets different meshes."""
    places, corners = mesh.grid(0.1, 0.1, 2).vertices.copy(), np.array([[0, 1, 3]], dtype=np.int32)
    frames = []
    for _ in range(3):
        frames.append(mesh.TriangleMesh(places, corners))
        places += (0.0, 0.0, 0.5)
    corners[:] = 7
    assert [frame.vertices[0, 2] for frame in frames] == [0.0, 0.5, 1.0]
    assert frames[0].triangles.tolist() == [[0, 1, 3]]


def test_arrays_change_in_place_also_by_augmented_assignment() -> None:
    """`mesh.vertices += x` writes into the array, as `mesh.vertices[:] += x` does."""
    sheet, lump = mesh.grid(0.1, 0.1, 1), mesh.tet_box(0.1, 1)
    before = sheet.vertices.copy()
    offset = np.array([0.0, 0.0, 0.5])
    sheet.vertices += offset
    np.testing.assert_array_equal(sheet.vertices, before + offset)
    lump.elements += 0
    for name in ("vertices", "triangles", "bounds", "new"):
        with pytest.raises(AttributeError, match=f"TriangleMesh is immutable: .* instead of setting {name}"):
            setattr(sheet, name, before)
    cloth = stark.Scene().add_cloth(sheet)
    with pytest.raises(ValueError, match="read-only"):
        cloth.mesh.vertices += 1.0
    np.testing.assert_array_equal(cloth.mesh.vertices, sheet.vertices)
