"""Pressure on elements of many nodes: the patch test, volumes of curved faces, cavities."""

from __future__ import annotations

import numpy as np
import pytest
from _load_scenes import advance, block_with_a_hole, by_elements, simulate

import stark


def solid_meshes() -> dict[str, stark.mesh.Mesh]:
    return by_elements(stark.mesh.tet_box(0.1, 2), stark.mesh.box_hexahedra((0.3, 0.2, 0.1), (3, 2, 1)))


@pytest.mark.parametrize("kind", list(solid_meshes()))
def test_pressure_on_a_free_block_strains_it_evenly(kind: str) -> None:
    """The patch test of pressure: strain -p/(3 K) at every node, within its square."""
    mesh = solid_meshes()[kind]
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3, mass_damping=20.0)
    block = scene.add_solid(mesh, rubber)
    scene.add_pressure(block, -100.0)
    sim = simulate(scene, 0.02)
    advance(sim, 0.6)
    strain = -100.0 * (1 - 2 * 0.3) / 1e5
    assert np.abs(block.positions - mesh.vertices * (1 + strain)).max() < 2e-3 * abs(strain) * 0.1


@pytest.mark.parametrize("kind", ["tet10", "hex8", "hex27"])
def test_pressure_knows_the_volume_of_curved_elements(kind: str) -> None:
    """Volume of the bent block from its elements, integrated without any surface; forces sum to zero."""
    mesh = solid_meshes()[kind]
    x = mesh.vertices
    bent = stark.SolidMesh(
        x + 0.3 * np.stack([x[:, 1] * x[:, 2], x[:, 0] ** 2, x[:, 0] * x[:, 1]], axis=1) / 0.1, mesh.elements
    )
    scene = stark.Scene()
    block = scene.add_solid(bent, stark.materials.soft_rubber, position=(5.0, 0.0, 0.0))
    air = scene.add_pressure(block.faces, 0.1)
    back = scene.add_pressure(stark.stencils(block, block.triangles[::-1, ::-1].copy()), 0.1)
    sim = simulate(scene, 1e-6)
    assert not sim.step().failed
    assert air.energy == pytest.approx(-0.1 * bent.volume, rel=1e-9)
    assert back.energy == pytest.approx(-0.1 * bent.volume, rel=1e-9)
    assert np.abs(air.forces.sum(axis=(0, 1))).max() < 1e-12
    half = np.arange(len(block.triangles)) % 8 != 0
    with pytest.raises(stark.InvalidArgument, match="not closed"):
        scene.add_pressure(block.faces[half], 0.1)


def test_a_cavity_between_quadratic_elements_is_one_of_their_faces() -> None:
    block = stark.mesh.to_quadratic(block_with_a_hole())
    scene = stark.Scene()
    body = scene.add_solid(block, stark.materials.soft_rubber)
    inner = np.abs(block.vertices[body.triangles]).max(axis=(1, 2)) < 0.051
    air = scene.add_pressure(body.faces[inner], 200.0)
    sim = simulate(scene)
    assert not sim.step().failed
    assert len(air.energies) == 12 * 20
    assert air.energy == pytest.approx(-200.0 * 1e-3, rel=0.1) and air.energy < -0.2
