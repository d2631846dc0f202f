"""Soft solids: surface, faces, volumes."""

from __future__ import annotations

import pytest

import stark
from stark import mesh


def make_scene() -> stark.Scene:
    scene = stark.Scene("kitchen")
    scene.add_cloth(mesh.grid(0.4, 0.4, 4), name="napkin", position=(0, 0, 0.5), friction=0.9)
    scene.add_solid(mesh.tet_box(0.1, 2), name="cheese", position=(0, 0, 0.2), friction=0.4)
    scene.add_box((0.1, 0.2, 0.3), density=500.0, position=(1, 0, 0.2))
    scene.add_floor()
    return scene


def test_the_surface_of_a_solid_leaves_inner_vertices_out() -> None:
    solid = make_scene()["cheese"]
    assert len(solid.positions) == 27 + 8
    assert solid.surface_positions.shape == (26, 3)
    surface = mesh.TriangleMesh(solid.surface_positions, solid.surface_triangles)
    assert surface.is_closed and surface.volume == pytest.approx(1e-3, rel=1e-12)
    assert mesh.TriangleMesh(solid.positions, solid.triangles).volume == pytest.approx(1e-3, rel=1e-12)
