"""The table of kinds of bodies: it says of each kind what handles and the core have."""

from __future__ import annotations

import re

import numpy as np
import pytest

import stark
from stark.bodies import HANDLES
from stark.body_kinds import has_frames, has_points, has_pose, names_of, row_of, title_of


@pytest.fixture(scope="module")
def sim() -> stark.Simulation:
    scene = stark.Scene("one of each")
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2))
    scene.add_solid(stark.mesh.tet_box(0.1, cells=1), position=(1.0, 0.0, 0.0))
    scene.add_rod([(2.0, 0.0, 0.0), (2.1, 0.0, 0.0), (2.2, 0.0, 0.0)])
    scene.add_box(0.1, mass=1.0, position=(3.0, 0.0, 0.0))
    return stark.Simulation(scene)


def test_each_kind_has_a_handle_and_a_function_that_adds_it(sim: stark.Simulation) -> None:
    assert set(HANDLES) == set(names_of()) == {body.kind for body in sim.bodies}
    for kind in names_of():
        assert callable(getattr(stark.Scene, f"add_{kind}"))


def test_what_moves_a_kind_is_what_the_core_has_of_it(sim: stark.Simulation) -> None:
    for body, (_, points, _, bodies) in zip(sim.bodies, sim._core.places(), strict=True):
        vertices = len(body.positions)
        assert (points, bodies) == {
            "points": (vertices, 0),
            "pose": (0, 1),
            "frames": (0, vertices),
        }[row_of(body).moved_by]
        assert [has_points(body), has_pose(body), has_frames(body)].count(True) == 1
        assert hasattr(body, "pose") == has_pose(body)
        assert hasattr(body, "clamped") == has_frames(body)


def test_kinds_that_touch_with_triangles_have_some(sim: stark.Simulation) -> None:
    for body in sim.bodies:
        assert (len(body.triangles) > 0) == row_of(body).has_triangles
        assert hasattr(body, "growth") == row_of(body).strains


def test_a_handle_is_made_again_from_what_was_given(sim: stark.Simulation) -> None:
    given = {name: arguments[0] for name, arguments in sim.scene._core.calls if name.startswith("add_")}
    for body in sim.bodies:
        mesh = type(body)._mesh_of(given[f"add_{body.kind}"])
        assert type(mesh) is type(body.mesh)
        np.testing.assert_array_equal(mesh.vertices, body.mesh.vertices)


def test_unknown_kinds_are_taken_for_points() -> None:
    assert has_points(type("Body", (), {"kind": "cloud"}))
    assert not row_of(type("Body", (), {"kind": "cloud"})).is_sheet


def test_titles_are_those_of_the_core(sim: stark.Simulation) -> None:
    for body in sim.bodies:
        with pytest.raises(stark.InvalidArgument, match=re.escape(title_of(body))):
            sim.scene._core.set_surface_directions(body._index, np.zeros((1, 3)))
