"""Soft solids: surface, faces, volumes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark
from stark import mesh
from stark.bodies.solid import doubles


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


def test_elements_that_are_there_twice_are_said() -> None:
    """Their mass and stiffness counted twice in silence."""
    box = mesh.tet_box(0.1, 2)
    turned = box.tets[[5, 7]][:, [1, 2, 0, 3]]
    double = mesh.TetMesh(box.vertices, np.concatenate([box.tets, turned]))
    with pytest.warns(
        stark.StarkWarning, match="2 elements are there twice, such as 96, whose .* those of 5:"
    ):
        stark.Scene().add_solid(double)
    cubes = mesh.box_hexahedra(0.1, 2)
    double = mesh.SolidMesh(cubes.vertices, np.concatenate([cubes.elements, cubes.elements[3:4]]))
    with pytest.warns(stark.StarkWarning, match="1 element is there twice, such as 8, whose nodes .* of 3:"):
        stark.Scene().add_solid(double)


def test_doubles_are_found_where_keys_are_many() -> None:
    elements = np.random.default_rng(0).integers(0, 12, (400, 4), dtype=np.int32)
    found = {(int(first), int(second)) for first, second in doubles(elements)}
    rows = [tuple(sorted(row)) for row in elements.tolist()]
    assert found == {(rows.index(row), k) for k, row in enumerate(rows) if rows.index(row) != k} and found
    assert len(doubles(mesh.tet_box(0.1, 6).tets)) == 0


@pytest.mark.parametrize(
    ("make", "excess"),
    [
        (mesh.box_hexahedra, 2.0),
        (mesh.grid, 2.0),
        (mesh.tet_box, 1.25),
        (lambda size, n: mesh.to_quadratic(mesh.tet_box(size, n)), 0.324),
        (lambda size, n: mesh.to_quadratic(mesh.box_hexahedra(size, n)), 0.0),
    ],
)
def test_masses_at_nodes_are_hard_to_turn(make: Callable[..., Any], excess: float) -> None:
    """docs/solids.md: a cube and a square sheet of n cells across have 1 + excess/n^2 times the inertia."""
    for n in (1, 2, 4):
        scene = stark.Scene()
        shape = (0.1, 0.1) if make is mesh.grid else (0.1,)
        add = scene.add_cloth if make is mesh.grid else scene.add_solid
        body = add(make(*shape, n), angular_velocity=(0.0, 0.0, 1.0))
        report = stark.Simulation(scene, time_step=1e-5, gravity=(0, 0, 0)).step()
        inertia = report.angular_momentum[2] / (body.mass * 0.1**2 / 6.0)
        assert inertia == pytest.approx(1.0 + excess / n**2, rel=3e-3)
