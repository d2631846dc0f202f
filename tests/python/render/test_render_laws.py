"""Energies and stresses of the built-in laws, against the energy that the solver reports."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark
from stark.render.deformation import of_cloth, of_solid
from stark.render.laws import density_and_stress

COMMON = {"youngs_modulus": 1e4, "poissons_ratio": 0.3, "density": 1000.0}
FIBRES = {"fiber_stiffness": 1e4, "fiber_exponent": 2.0, "fiber_direction": (0.3, 0.2, 1.0)}
BLOCK = stark.mesh.tet_box((0.1, 0.1, 0.2), (2, 2, 2))
SOLIDS = {
    "stable_neo_hookean": stark.materials.soft_rubber,
    "limited": stark.materials.soft_rubber.replace(strain_limit=0.05),
    "neo_hookean": stark.materials.neo_hookean(**COMMON),
    "st_venant_kirchhoff": stark.materials.st_venant_kirchhoff(**COMMON),
    "corotated": stark.materials.corotated(**COMMON),
    "mooney_rivlin": stark.materials.mooney_rivlin(c10=3e3, c01=1e3, bulk_modulus=2e4, density=1000.0),
    "fiber_reinforced": stark.materials.fiber_reinforced(**COMMON, **FIBRES),
    "by element": stark.materials.fiber_reinforced(
        **COMMON | {"youngs_modulus": np.linspace(1e4, 2e4, len(BLOCK.tets))},
        **FIBRES | {"fiber_direction": np.tile([FIBRES["fiber_direction"]], (len(BLOCK.tets), 1))},
    ),
}
SHELLS = {
    "membrane_neo_hookean": stark.materials.cotton.replace(strain_limit=np.inf),
    "limited": stark.materials.cotton.replace(strain_limit=0.05),
    "membrane_st_venant_kirchhoff": stark.materials.membrane_st_venant_kirchhoff(
        youngs_modulus=5e3, poissons_ratio=0.3
    ),
    "orthotropic_cloth": stark.materials.orthotropic_cloth(
        warp_modulus=5e3,
        weft_modulus=2e3,
        shear_modulus=500.0,
        poissons_ratio=0.2,
        warp_direction=(1, 0.4, 0),
    ),
}


def reported_energy(scene: stark.Scene) -> tuple[float, Any]:
    """Elastic energy [J] of a scene that is pinned all over, and the simulation."""
    sim = stark.Simulation(scene, time_step=1e-3)
    return sim.step().energy["elastic"], sim


def deformed(vertices: np.ndarray, seed: int, rough: float = 0.0) -> np.ndarray:
    random = np.random.default_rng(seed)
    F = np.eye(3) + random.uniform(-0.1, 0.1, (3, 3))
    return vertices @ F.T + rough * random.uniform(-1.0, 1.0, vertices.shape)


@pytest.mark.parametrize("law", SOLIDS)
def test_energy_of_tetrahedra_is_that_of_the_solver(law: str) -> None:
    scene, x = stark.Scene(), deformed(BLOCK.vertices, 1, 0.005)
    scene.add_solid(BLOCK, SOLIDS[law], name="s", initial_positions=x, pins=np.arange(len(x)))
    expected, sim = reported_energy(scene)
    deformation = of_solid(sim["s"])
    psi = density_and_stress(SOLIDS[law], deformation.gradients, "s")[0]
    assert psi[:, 0] @ deformation.sizes == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("law", SHELLS)
def test_energy_of_cloth_is_that_of_the_solver(law: str) -> None:
    mesh = stark.mesh.grid(0.2, 0.2, cells=4)
    scene, x = stark.Scene(), deformed(mesh.vertices, 2)  # stays flat
    material = SHELLS[law].replace(bending_stiffness=0.0)
    scene.add_cloth(mesh, material, name="c", initial_positions=x, pins=np.arange(len(x)))
    expected, sim = reported_energy(scene)
    deformation = of_cloth(sim["c"], material._fields.get("warp_direction"))
    psi = density_and_stress(material, deformation.gradients, "c")[0]
    assert psi[:, 0] @ deformation.sizes * material.thickness == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("d", [3, 2])
def test_stresses_are_slopes_of_energies(d: int) -> None:
    """Central differences; the limits and corotated elasticity are not differentiated by the engine."""
    random, h = np.random.default_rng(4), 1e-6
    for law, material in (SOLIDS if d == 3 else SHELLS).items():
        if law == "by element":
            continue
        F = np.eye(3)[:, :d] + random.uniform(-0.15, 0.15, (6, 1, 3, d))
        P = density_and_stress(material, F, "x")[1]
        for i in range(3):
            for j in range(d):
                step = np.zeros((3, d))
                step[i, j] = h
                up, down = (density_and_stress(material, F + s * step, "x")[0] for s in (1.0, -1.0))
                slope = (up - down) / (2.0 * h)
                assert P[..., i, j] == pytest.approx(slope, abs=2e-5 * np.abs(P).max()), law


def test_laws_of_users_are_refused() -> None:
    law = stark.materials.solid_laws["strain_limit"]
    material = stark.SolidMaterial(law=law, strain_limit=0.1)
    with pytest.raises(
        stark.InvalidArgument, match=r"'bar': stress: its law 'strain_limit' is not.*field={'bar'"
    ):
        density_and_stress(material, np.eye(3)[None, None], "bar")
