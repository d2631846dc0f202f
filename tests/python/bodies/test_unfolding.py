"""Plates with a curved mesh that are at rest flat are said, and only those."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import stark

PAPER = stark.materials.paper


def bent(rise: float) -> stark.TriangleMesh:
    """A sheet of 0.2 m with a wave as deep as ``rise`` [m]."""
    flat = stark.mesh.grid(0.2, 0.1, cells=(20, 10))
    points = flat.vertices.copy()
    points[:, 2] = rise * np.cos(np.pi * points[:, 0] / 0.2)
    return stark.TriangleMesh(points, flat.triangles)


def said(mesh: stark.TriangleMesh, material: stark.ShellMaterial, curvature: bool, **how: Any) -> list[str]:
    scene = stark.Scene()
    sheet = scene.add_cloth(mesh, material, name="roof", **how)
    if curvature:
        sheet.natural_curvature = 2.0
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        stark.Simulation(scene)
    return [str(each.message) for each in told if "springs open" in str(each.message)]


def test_a_curved_plate_that_is_at_rest_flat_is_said() -> None:
    (text,) = said(bent(0.05), PAPER, curvature=False)
    assert "cloth 'roof'" in text and 'rest_angles="mesh"' in text


@pytest.mark.parametrize(
    ("mesh", "material", "curvature", "how"),
    [
        (bent(0.05), PAPER, False, {"rest_angles": "mesh"}),
        (bent(0.001), PAPER, False, {}),
        (bent(0.05), stark.materials.cotton, False, {}),
        (bent(0.05), PAPER, True, {}),
        (bent(0.0), PAPER, False, {"initial_positions": bent(0.05).vertices}),
    ],
    ids=["rest angles of the mesh", "flat", "no plate", "natural curvature", "starts bent"],
)
def test_others_are_not(mesh: Any, material: Any, curvature: bool, how: dict[str, Any]) -> None:
    assert not said(mesh, material, curvature, **how)


@pytest.mark.filterwarnings("ignore:.*springs open")
def test_it_does_spring_open() -> None:
    scene = stark.Scene()
    sheet = scene.add_cloth(bent(0.05), PAPER)
    sim = stark.Simulation(scene, time_step=0.005, gravity=(0, 0, 0))
    start = np.ptp(sheet.positions[:, 2])
    sim.run_until(0.05)
    assert np.ptp(sheet.positions[:, 2]) < 0.5 * start
