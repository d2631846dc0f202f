"""Simplified surfaces, hulls and convex parts."""

from __future__ import annotations

import numpy as np
import pytest

import stark


def test_a_simplified_ball_is_a_ball() -> None:
    pytest.importorskip("fast_simplification")
    ball = stark.mesh.sphere(1.0, 5)
    found = stark.mesh.simplified(ball, 1000)
    assert 900 <= len(found.triangles) <= 1000
    # An inscribed polyhedron of 1000 triangles has 1 % less volume.
    assert abs(found.volume - ball.volume) < 0.02 * ball.volume
    assert stark.mesh.simplified(found, 5000) is found
    with pytest.raises(
        stark.InvalidArgument, match=r"simplified: triangles = 3: must be a whole number in \[4"
    ):
        stark.mesh.simplified(ball, 3)


@pytest.mark.parametrize("size", [1e-3, 0.1, 1e3])
def test_a_simplified_cylinder_is_one_at_any_size_and_place(size: float) -> None:
    """Lengths are compared with errors inside: of small cylinders a third of the volume was lost."""
    pytest.importorskip("fast_simplification")
    rod = stark.mesh.cylinder(0.5, 1.0, 64, 20).scaled(size)
    found = stark.mesh.simplified(rod, 134)
    assert found.is_closed and abs(found.volume / rod.volume - 1.0) < 0.01
    moved = stark.mesh.simplified(rod.translated((100.0 * size, 0, 0)), 134)
    assert moved.volume == pytest.approx(found.volume, rel=1e-9)


def test_the_hull_is_the_same_far_from_the_origin() -> None:
    """It lost its small triangles 1 km away, and was a flat tetrahedron at 1,000 km."""
    pytest.importorskip("manifold3d")
    ring = stark.mesh.torus(0.05, 0.02)
    here = stark.mesh.convex_hull(ring)
    for away in (1e3, 1e6):
        there = stark.mesh.convex_hull(ring.translated((away, -away, 0)))
        assert len(there.triangles) == len(here.triangles)
        assert there.volume == pytest.approx(here.volume, rel=1e-6)


def test_the_hull_of_a_box_with_a_dent_is_the_box() -> None:
    pytest.importorskip("manifold3d")
    box = stark.mesh.box((1, 2, 3), 4)
    dented = stark.mesh.TriangleMesh(
        box.vertices * np.where(box.vertices[:, [2]] > 1.4, (0.5, 0.5, 0.2), 1.0), box.triangles
    )
    found = stark.mesh.convex_hull(np.concatenate([box.vertices, dented.vertices]))
    assert found.is_closed and abs(found.volume - 6.0) < 1e-9
    assert stark.mesh.convex_hull(dented).volume > dented.volume
    with pytest.raises(stark.InvalidMesh, match="the 9 points enclose no volume"):
        stark.mesh.convex_hull(stark.mesh.grid(1.0, 1.0, 2))
    with pytest.raises(stark.InvalidMesh, match="must be finite points"):
        stark.mesh.convex_hull(np.zeros(3))
    with pytest.raises(stark.InvalidMesh, match=r"got str: must be a mesh or points .*stark\.mesh\.load"):
        stark.mesh.convex_hull("part.obj")


def test_an_l_is_two_convex_parts() -> None:
    pytest.importorskip("coacd")
    outline = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    vertices = np.array([[*point, z] for z in (0.0, 1.0) for point in outline])
    caps = np.array([[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]])
    sides = [(k, (k + 1) % 6, (k + 1) % 6 + 6) for k in range(6)] + [
        (k, (k + 1) % 6 + 6, k + 6) for k in range(6)
    ]
    shape = stark.mesh.TriangleMesh(vertices, np.concatenate([caps[:, ::-1], caps + 6, sides]))
    assert shape.is_closed and abs(shape.volume - 3.0) < 1e-12
    parts = stark.mesh.convex_parts(shape)
    assert len(parts) == 2 and all(part.is_closed for part in parts)
    assert abs(sum(part.volume for part in parts) - 3.0) < 0.05
    again = stark.mesh.convex_parts(shape)
    for part, other in zip(parts, again, strict=True):
        np.testing.assert_array_equal(part.vertices, other.vertices)
    with pytest.raises(stark.InvalidMesh, match="is open or empty"):
        stark.mesh.convex_parts(stark.mesh.grid(1.0, 1.0, 2))
    with pytest.raises(stark.InvalidArgument, match=r"concavity = 0: must be in \[0.01, 1\]"):
        stark.mesh.convex_parts(shape, concavity=0)
