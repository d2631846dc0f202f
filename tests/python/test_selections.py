"""Selections of points and stencils: indices, embedded points, bodies that have them."""

from __future__ import annotations

import numpy as np
import pytest

import stark


@stark.energy
def anchor(p: stark.Point, target: stark.Vec3, stiffness: float = 10.0):
    """Spring of rest length zero to a place in the world."""
    d = p.x - target
    return 0.5 * stiffness * (d @ d)


def sheet(cells: int = 4) -> tuple[stark.Scene, stark.Cloth]:
    """A scene with a square cloth of 0.4 m about the origin."""
    scene = stark.Scene()
    return scene, scene.add_cloth(stark.mesh.grid(0.4, 0.4, cells=cells), name="sheet")


def test_selections_are_indexed_like_arrays() -> None:
    _, cloth = sheet(2)
    vertices = cloth.vertices
    assert len(vertices) == 9 and len(vertices[4]) == len(vertices[-1]) == 1
    np.testing.assert_array_equal(vertices[4:6].positions, cloth.positions[4:6])
    mask = cloth.positions[:, 0] > 0.1
    np.testing.assert_array_equal(vertices[mask].positions, cloth.positions[mask])
    np.testing.assert_array_equal(vertices[[3, 1]].rest_positions, cloth.mesh.vertices[[3, 1]])
    edges = cloth.edges
    assert (len(edges), len(cloth.faces), len(cloth.hinges)) == (16, 8, 8)
    assert len(edges[3:5]) == 2 and edges[3].point_count == 2
    assert repr(vertices[:2]) == "<2 points of 'sheet'>"
    assert repr(edges) == "<16 edges of 2 points of 'sheet'>"


def test_solids_and_rigid_bodies_have_stencils_of_their_own() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.tet_box(0.1, 1)
    solid = scene.add_solid(mesh)
    turn = stark.rotation(axis="z", angle=0.5)
    box = scene.add_box(size=0.1, position=(0.0, 0.0, 1.0), rotation=turn, mass=1.0)
    assert len(solid.tetrahedra) == len(mesh.tets) and len(solid.faces) == 12
    assert len(box.edges) == 18 and len(box.vertices) == 8
    np.testing.assert_allclose(box.points((0.1, 0.0, 0.0)).positions, [[0, 0, 1.0] + turn[:, 0] * 0.1])
    inside = solid.embedded([0], [[0.25, 0.25, 0.25, 0.25]])
    np.testing.assert_allclose(inside.positions, [mesh.vertices[mesh.tets[0]].mean(axis=0)], atol=1e-16)


def test_forces_on_embedded_points_go_to_their_vertices() -> None:
    scene, cloth = sheet(2)
    weights = np.array([0.2, 0.3, 0.5])
    pull = scene.add(anchor(cloth.embedded([5], weights), target=(0.0, 0.0, 0.5), stiffness=2.0))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.step()
    x = weights @ cloth.positions[cloth.triangles[5]]
    np.testing.assert_allclose(pull.forces[0, 0], 2.0 * (np.array([0.0, 0.0, 0.5]) - x), rtol=1e-12)


def test_meshes_of_other_elements_have_no_tetrahedra() -> None:
    scene = stark.Scene()
    solid = scene.add_solid(stark.mesh.box_hexahedra(0.1, 1), name="brick")
    assert len(solid.vertices) == 8 and len(solid.faces) == 12
    for stencils in ("tetrahedra", "edges"):
        with pytest.raises(stark.InvalidArgument, match="'brick': its elements have 8 nodes"):
            getattr(solid, stencils)
