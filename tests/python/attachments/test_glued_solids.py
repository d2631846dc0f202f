"""Solids of different meshes glued face to face, docs/attachments.md: a block that is pulled."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import stark

_E, _PULL, _SIDE = 1e6, 1e4, 0.1


def glued(upper: int, lower: int) -> tuple[stark.Scene, stark.Solid, stark.Solid, stark.Attachment]:
    """Two cubes of so many cells, the upper one attached to the lower one, which stands on rollers."""
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=_E, poissons_ratio=0.0)
    cubes = [
        scene.add_solid(
            stark.mesh.box_hexahedra(_SIDE, cells), rubber, position=(0.0, 0.0, side * _SIDE / 2), name=name
        )
        for cells, side, name in ((upper, 1, "upper"), (lower, -1, "lower"))
    ]
    for cube in cubes:
        for axis, coordinate in zip("xy", cube.mesh.vertices.T[:2], strict=True):
            scene.add_rollers(cube.vertices[coordinate < 1e-9 - _SIDE / 2], axis)
    scene.add_rollers(cubes[1].vertices[cubes[1].mesh.vertices[:, 2] < 1e-9 - _SIDE / 2], "z")
    foot = cubes[0].mesh.vertices[:, 2] < 1e-9 - _SIDE / 2
    return scene, *cubes, scene.attach(cubes[0].vertices[foot], cubes[1], name="glue")


def pulled(upper: int, lower: int) -> tuple[float, float]:
    """How far the top goes over what one block does, and the glue's force over the load."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene, top, _, glue = glued(upper, lower)
    high = top.mesh.vertices[:, 2] > _SIDE / 2 - 1e-9
    scene.add_traction(top.faces[high[top.triangles].all(axis=1)], (0.0, 0.0, _PULL))
    settings = {"time.integrator": "quasistatic", "contact.enabled": False}
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), settings=settings)
    report = sim.step()
    assert not report.failed, report.message
    way = (top.positions[high, 2] - _SIDE).mean() / (2 * _SIDE * _PULL / _E)
    return float(way), float(-glue.force[2] / (_PULL * _SIDE**2))


@pytest.mark.parametrize(("upper", "lower"), [(4, 4), (4, 2), (4, 3)])
def test_a_fine_face_on_a_coarse_one_stretches_as_one_block(upper: int, lower: int) -> None:
    way, force = pulled(upper, lower)
    assert way == pytest.approx(1.0, abs=0.01)
    assert force == pytest.approx(1.0, rel=1e-6)


def test_a_coarse_face_on_a_fine_one_is_too_soft() -> None:
    way, force = pulled(2, 4)
    assert way > 1.15
    assert force == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(("upper", "lower"), [(2, 4), (3, 5), (4, 6)])
def test_coarse_faces_on_fine_ones_warn(upper: int, lower: int) -> None:
    with pytest.warns(
        stark.StarkWarning, match="'glue': faces of 'upper' that are glued have .* times the area"
    ):
        glued(upper, lower)


@pytest.mark.parametrize(("upper", "lower"), [(4, 4), (6, 3), (4, 5), (3, 4)])
def test_other_faces_do_not(upper: int, lower: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        glued(upper, lower)


def test_a_few_points_of_a_face_do_not_warn() -> None:
    """A foot that is glued at its corners is meant so."""
    scene = stark.Scene()
    cube, plate = (
        scene.add_solid(stark.mesh.box_hexahedra(size, cells), position=(0.0, 0.0, z), name=name)
        for size, cells, z, name in (
            ((0.1, 0.1, 0.1), (2, 2, 2), 0.05, "cube"),
            ((0.2, 0.2, 0.1), (12, 12, 6), -0.05, "plate"),
        )
    )
    corners = np.flatnonzero((np.abs(cube.mesh.vertices[:, :2]) > 0.0499).all(axis=1))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.attach(cube.vertices[corners], plate)
