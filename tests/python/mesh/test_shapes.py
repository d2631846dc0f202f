"""Generated meshes: closed surfaces, volumes against closed forms, documented counts."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark import mesh

SHAPES = {
    # closed form of the volume, relative tolerance: the faceted shape is smaller than the round one
    "box": (mesh.box((1, 2, 3), 2), 6.0, 1e-13),
    "sphere": (mesh.sphere(0.5, 5), np.pi / 6, 2e-3),
    "cylinder": (mesh.cylinder(0.5, 2.0, 128), np.pi / 2, 1e-3),
    "capsule": (mesh.capsule(0.5, 1.0, 64, 32), np.pi / 4 + np.pi / 6, 5e-3),
    "torus": (mesh.torus(1.0, 0.25, 128, 64), 2 * np.pi**2 / 16, 4e-3),
}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_closed_and_enclose_their_volume(name: str) -> None:
    shape, volume, tolerance = SHAPES[name]
    assert shape.is_closed
    assert shape.volume == pytest.approx(volume, rel=tolerance)
    assert shape.volume <= volume * (1 + 1e-12)
    np.testing.assert_allclose(shape.bounds.mean(axis=0), 0, atol=1e-3)


@pytest.mark.parametrize("shells", [(1.0,), (0.5, 1.0), (0.3, 0.55, 0.8, 1.0)])
def test_a_ball_of_tetrahedra_fills_its_sphere(shells: tuple[float, ...]) -> None:
    ball, sphere = mesh.tet_ball(0.1, 2, shells), mesh.sphere(0.1, 2)
    assert ball.vertices.shape == (1 + len(shells) * 162, 3)
    assert len(ball.tets) == 320 * (3 * len(shells) - 2)
    assert (ball.volumes > 0.0).all() and ball.volume == pytest.approx(sphere.volume, rel=1e-12)
    # Prisms cut the sides that they share alike: the surface is the sphere, nothing is open inside.
    surface = ball.surface()
    assert surface.is_closed and surface.area == pytest.approx(sphere.area, rel=1e-12)


def test_shells_of_a_ball_grow_to_its_surface() -> None:
    for shells in ((), (0.5,), (0.5, 0.5, 1.0), (0.0, 1.0), (0.5, 1.2), 1.0, (0.5, float("nan"), 1.0)):
        with pytest.raises(stark.InvalidArgument, match=r"tet_ball: shells = .* must grow from above 0 to 1"):
            mesh.tet_ball(0.1, 1, shells)
    with pytest.raises(stark.InvalidArgument, match="tet_ball: radius = -1"):
        mesh.tet_ball(-1.0)
    with pytest.raises(stark.InvalidArgument, match="tet_ball: subdivisions"):
        mesh.tet_ball(1.0, -1)


def test_grids_and_tet_boxes_have_the_documented_counts() -> None:
    grid = mesh.grid(0.4, 0.2, (4, 2))
    assert grid.vertices.shape == (15, 3) and grid.triangles.shape == (16, 3)
    assert grid.area == pytest.approx(0.08, rel=1e-14) and not grid.is_closed
    np.testing.assert_allclose(grid.bounds, [[-0.2, -0.1, 0], [0.2, 0.1, 0]])
    box = mesh.tet_box(0.2, 20)
    assert len(box.vertices) == 17_261 and len(box.tets) == 96_000
    assert (box.volumes > 0).all() and box.volume == pytest.approx(0.008, rel=1e-12)
