"""Selections of points and stencils, embedded points, reports of checks, listings, timings."""

from __future__ import annotations

import numpy as np
import pytest
from _scenes import anchor, sheet, sheet_and_box, spring, tie

import stark


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


@stark.energy
def kinked(e: stark.Edge, k: float = 10.0):
    return k * stark.maximum(e.length - e.rest_length, 0.0)


@stark.energy
def jumping(e: stark.Edge, k: float = 10.0):
    return stark.where(e.length > e.rest_length, k, 0.5 * k) * e.length


@stark.energy(translation_invariant=True)
def wrongly_declared(e: stark.Edge, k: float = 10.0):
    return k * stark.squared_norm(e[0].x + e[1].x)


def test_reports_name_what_is_wrong() -> None:
    _, cloth = sheet(4)
    good = spring.check(cloth.edges)
    assert good.ok and "nothing is wrong" in str(good)
    assert good["gradient"].value < 1e-8 and good["hessian"].value < 1e-8
    assert {good[name].status for name in ("translation", "rotation", "start", "back ends")} == {"ok"}
    assert good["definiteness"].status == "note" and 0.2 < good["definiteness"].value < 0.8
    kink = kinked.check(cloth.edges)
    assert kink.ok and kink["continuous forces"].status == "note"
    jump = jumping.check(cloth.edges)
    assert not jump.ok and jump["continuous energy"].status == "wrong"
    assert not wrongly_declared.check(cloth.edges).ok
    pulled = anchor.check(cloth.vertices, target=(0.0, 0.0, 0.3))
    assert pulled.ok
    assert {pulled[name].status for name in ("translation", "rotation", "start")} == {"note"}
    with pytest.raises(KeyError, match="no finding"):
        good["colour"]


def test_invariance_under_translation_is_found_in_the_formula() -> None:
    scene, cloth, box = sheet_and_box()
    assert spring(cloth.edges).translation_invariant
    assert tie(cloth.vertices, box.points((0.0, 0.0, 0.0))).translation_invariant
    assert not anchor(cloth.vertices, target=(0.0, 0.0, 0.0)).translation_invariant

    @stark.energy
    def about_the_middle(t: stark.Triangle):
        return sum(stark.squared_norm(p.x - t.center) for p in t)

    @stark.energy
    def damped(e: stark.Edge, h: stark.TimeStep):
        # The velocity of a point changes when positions are moved and previous ones are not.
        return h * stark.squared_norm(e[0].v + e[1].v)

    assert about_the_middle(cloth.faces).translation_invariant
    assert not damped(cloth.edges).translation_invariant
    assert not wrongly_declared.trace().translation_invariant
    scene.add(about_the_middle(cloth.faces))
    stark.Simulation(scene)  # checks declared invariance numerically


def test_listings_counts_and_timings() -> None:
    _, cloth = sheet(2)
    text = str(spring.graph())
    assert text.startswith("spring(e, stiffness):")
    assert all(word in text for word in ("e[1].x[0]", "e[0].X[2]", "stiffness", "sqrt"))
    statistics = spring.statistics
    assert statistics.instructions["hessian"] > statistics.instructions["value"] > 10
    assert statistics.algorithm and statistics.backend in str(statistics)
    nanoseconds = spring.benchmark(cloth.edges)
    assert list(nanoseconds) == ["value", "gradient", "hessian"]
    assert all(0.0 < ns < 1e5 for ns in nanoseconds.values())
    assert spring.name == "spring" and "Spring between" in spring.__doc__
    assert repr(spring(cloth.edges)) == "<spring on 16 elements; add it with scene.add>"


def test_meshes_of_other_elements_have_no_tetrahedra() -> None:
    scene = stark.Scene()
    solid = scene.add_solid(stark.mesh.box_hexahedra(0.1, 1), name="brick")
    assert len(solid.vertices) == 8 and len(solid.faces) == 12
    for stencils in ("tetrahedra", "edges"):
        with pytest.raises(stark.InvalidArgument, match="'brick': its elements have 8 nodes"):
            getattr(solid, stencils)
