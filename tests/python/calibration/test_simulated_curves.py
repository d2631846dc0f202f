"""Tensile tests in simulation: a block under dead loads gives a curve, and a fit gives its material back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark
from stark import curves

EXACT: dict[str, Any] = {
    "contact.enabled": False,
    "gravity": (0, 0, 0),
    "newton.acceleration_tolerance": 0.0,
    "newton.residual_tolerance": 1e-9,
    "newton.step_tolerance": 0.0,
}
SIDE = 0.1  # [m]


def stretch_of_a_block(material: stark.SolidMaterial, stress: float) -> float:
    """Stretch along x of a free block under the nodal forces of a nominal stress [Pa], after 200 s."""
    mesh = stark.mesh.tet_box(SIDE, 1)
    X, forces = np.asarray(mesh.vertices), np.zeros((len(mesh.vertices), 3))
    for tet in np.asarray(mesh.tets):  # V P grad N
        edges = (X[tet[1:]] - X[tet[0]]).T
        gradients = np.linalg.inv(edges)
        gradients = np.vstack([-gradients.sum(axis=0), gradients])
        forces[tet, 0] += abs(np.linalg.det(edges)) / 6.0 * stress * gradients[:, 0]
    scene = stark.Scene()
    body = scene.add_solid(mesh, material, name="block")
    for k, force in enumerate(forces):
        scene.add_force(body.vertices[[k]], tuple(force))
    sim = stark.Simulation(scene, time_step=10.0, **EXACT)
    for _ in range(20):
        assert not sim.step().failed
    x = sim["block"].positions[:, 0]
    return float((x[X[:, 0] > 0.0].mean() - x[X[:, 0] < 0.0].mean()) / SIDE)


@pytest.mark.parametrize(
    ("material", "start", "fixed"),
    [
        (
            stark.materials.mooney_rivlin(c10=3e4, c01=1e4, bulk_modulus=4e5, density=1e-3),
            {"c10": 1e4, "c01": 3e4},
            {"bulk_modulus": 4e5},
        ),
        (
            stark.SolidMaterial(youngs_modulus=1e5, poissons_ratio=0.3, density=1e-3),
            {"youngs_modulus": 1e4},
            {"poissons_ratio": 0.3},
        ),
    ],
)
def test_a_fit_gives_the_material_of_the_block(
    material: stark.SolidMaterial, start: dict[str, float], fixed: dict[str, float]
) -> None:
    stress = np.array([1e4, 3e4, 6e4, 8e4, 1e5])  # under dead pressure a free block would turn around
    stretch = np.array([stretch_of_a_block(material, s) for s in stress])
    law = type(material) if material.law is None else material.law
    fit = stark.fit(law, curves.uniaxial(stretch, stress), start=start, fixed=fixed)
    for name in start:
        assert fit[name] == pytest.approx(material.to_dict()[name], rel=1e-6)
