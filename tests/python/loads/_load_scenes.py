"""What the tests of loads share: simulations without gravity, a block with a cavity."""

from __future__ import annotations

from typing import Any

import numpy as np

import stark

ORIGIN = (0.0, 0.0, 0.0)


def simulate(scene: stark.Scene, step: float = 0.01, **settings: Any) -> stark.Simulation:
    return stark.Simulation(scene, time_step=step, gravity=ORIGIN, **{"contact.enabled": False, **settings})


def by_elements(tetrahedra: stark.TetMesh, hexahedra: stark.mesh.SolidMesh) -> dict[str, stark.mesh.Mesh]:
    """These meshes and their quadratic ones, by the kind of their elements."""
    quadratic = stark.mesh.to_quadratic
    return {
        "tet4": tetrahedra,
        "tet10": quadratic(tetrahedra),
        "hex8": hexahedra,
        "hex27": quadratic(hexahedra),
    }


def advance(sim: stark.Simulation, until: float) -> None:
    for report in sim.run(until):
        assert not report.failed, report.message


def block_with_a_hole() -> stark.TetMesh:
    """Block of 3 x 3 x 3 cells without the one in the middle."""
    block = stark.mesh.tet_box(0.3, 3)
    centres = block.vertices[block.tets].mean(axis=1)
    solid = np.abs(centres).max(axis=1) > 0.05
    return stark.mesh.compact(stark.TetMesh(block.vertices, block.tets[solid]))
