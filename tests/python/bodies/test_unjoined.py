"""Parts of one mesh that meet at vertices of their own come apart, which a warning says."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import stark

SAID = "lie at the places of vertices of another part of its mesh, and nothing joins the parts"


def two(mesh: Any, gap: float) -> Any:
    elements = mesh.triangles if isinstance(mesh, stark.mesh.TriangleMesh) else mesh.elements
    return type(mesh)(
        np.vstack([mesh.vertices, mesh.vertices + np.array([0.1 + gap, 0.0, 0.0])]),
        np.vstack([elements, elements + len(mesh.vertices)]),
    )


def start(scene: stark.Scene) -> stark.Simulation:
    return stark.Simulation(scene, time_step=0.01)


@pytest.mark.parametrize("gap", [0.0, 1e-9])
def test_parts_of_a_solid_come_apart(gap: float) -> None:
    mesh = two(stark.mesh.box_hexahedra(0.1, 2), gap)
    scene = stark.Scene()
    held = mesh.vertices[:, 0] < -0.0499
    bar = scene.add_solid(mesh, stark.materials.foam, pins=held, self_contact=False)
    with pytest.warns(stark.StarkWarning, match=f"solid 'solid': 9 of its vertices {SAID}"):
        sim = start(scene)
    sim.run_until(0.1)
    assert bar.positions[-1, 2] - mesh.vertices[-1, 2] < -0.04  # falls freely
    scene = stark.Scene()
    scene.add_solid(stark.mesh.merged(mesh, 1e-7), stark.materials.foam, pins=[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        start(scene)


def sheets() -> tuple[stark.Scene, stark.Cloth, Any, Any]:
    mesh = two(stark.mesh.grid(0.1, 0.1, cells=4), 0.0)
    left = np.flatnonzero(abs(mesh.vertices[:25, 0] - 0.05) < 1e-9)
    right = 25 + np.flatnonzero(abs(mesh.vertices[25:, 0] - 0.05) < 1e-9)
    scene = stark.Scene()
    return scene, scene.add_cloth(mesh, pins=[0], self_contact=False), left, right


@stark.energy
def tie(a: stark.Point, b: stark.Point, stiffness: float = 10.0) -> Any:
    return 0.5 * stiffness * stark.squared_norm(a.x - b.x)


@stark.energy
def drag(t: stark.Triangle, h: stark.TimeStep, c: float = 0.1) -> Any:
    return 0.5 * c * h * t.area * (t[0].v @ t[0].v)


def test_sheets_with_forces_within_their_parts_are_named() -> None:
    scene, cloth, _, _ = sheets()
    scene.add(drag(cloth.faces))
    with pytest.warns(stark.StarkWarning, match=f"cloth 'cloth': 5 of its vertices {SAID}"):
        start(scene)


@pytest.mark.parametrize("how", ["attached", "energy", "fibre", "pinned"])
def test_parts_that_something_joins_are_as_meant(how: str) -> None:
    scene, cloth, left, right = sheets()
    if how == "attached":
        scene.attach(cloth.vertices[right], cloth.vertices[left])
    if how == "energy":
        scene.add(tie(cloth.vertices[left], cloth.vertices[right]))
    if how == "fibre":
        cloth.add_fibres(stark.materials.rubber_cord, paths=[[int(left[0]) - 1, int(right[0]) + 1]])
    if how == "pinned":
        cloth.pin(right)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        start(scene)


def test_bodies_of_several_parts_that_do_not_touch_are_as_meant() -> None:
    scene = stark.Scene()
    scene.add_cloth(two(stark.mesh.grid(0.1, 0.1, cells=4), 1e-3))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        start(scene)
