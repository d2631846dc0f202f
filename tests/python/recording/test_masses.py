"""Masses of vertices that recordings keep, against the core and against the energies that steps report."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark.recording.masses import point_masses

THREAD = stark.materials.steel_wire


def coated() -> list[stark.Body]:
    """A cloth with threads along an edge and a patch, a block with a skin of a given mass and a thread."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 8), stark.materials.pet)
    cloth.add_fibres(THREAD, paths=[range(9)], bending=False)
    cloth.add_skin(stark.materials.cotton, triangles=cloth.mesh.triangles[:20])
    block = scene.add_solid(stark.mesh.tet_box(0.1, 3), stark.materials.silicone, position=(1.0, 0.0, 0.0))
    block.add_skin(stark.materials.pet, mass=0.05)
    block.add_fibres(THREAD, paths=[[0, 1, 2, 3]], bending=False, mass=0.02)
    return [cloth, block]


@pytest.mark.parametrize("index", [0, 1])
def test_layers_count(index: int) -> None:
    body = coated()[index]
    masses = point_masses(body)
    assert masses is not None
    assert masses.sum() == pytest.approx(body.mass, rel=1e-12)
    thread = next(layer for layer in body.layers if layer.kind == "fibres")
    bare = masses[np.setdiff1d(np.arange(len(masses)), thread.paths[0])]
    assert bare.sum() < body.mass - thread.mass + 1e-12


def test_frames_that_turn_are_not_known() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 8))
    assert point_masses(cloth) is not None
    cloth.add_fibres(THREAD, paths=[range(9)])
    assert point_masses(cloth) is None
