"""Tensors in elements and at vertices, against closed forms and the same law written twice."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

STILL: dict[str, Any] = {"gravity": (0, 0, 0), "time.integrator": "quasistatic"}
E, NU = 2e6, 0.3


@stark.material
def saint_venant(
    F: stark.DeformationGradient,
    stiffness: float = stark.parameter(unit="Pa", above=0.0),
    shear: float = stark.parameter(unit="Pa", above=0.0),
) -> Any:
    G = 0.5 * (F.T @ F - stark.symbolic.identity(3))
    return shear * stark.trace(G @ G) + 0.5 * stiffness * stark.trace(G) ** 2


def pulled(material: Any, mesh: Any) -> tuple[Any, Any, Any]:
    """A bar with free sides that is stretched by a tenth, its simulation, and the rollers that pull."""
    scene = stark.Scene()
    bar = scene.add_solid(mesh, material, name="bar")
    at = mesh.vertices
    for k, axis in enumerate("xyz"):
        scene.add_rollers(bar.vertices[abs(at[:, k] - at[:, k].min()) < 1e-9], axis, stiffness=1e8)
    length = np.ptp(at[:, 0])
    end = bar.vertices[abs(at[:, 0] - at[:, 0].max()) < 1e-9]
    rollers = scene.add_rollers(end, "x", shift=0.1 * length, stiffness=1e8)
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    return sim, bar, rollers


@pytest.mark.parametrize("order", [1, 2])
def test_stress_is_the_pull_over_the_section(order: int) -> None:
    mesh: Any = stark.mesh.tet_box((0.1, 0.04, 0.03), 3)
    mesh = stark.mesh.to_quadratic(mesh) if order == 2 else mesh
    sim, bar, rollers = pulled(stark.SolidMaterial(density=1000, youngs_modulus=E, poissons_ratio=NU), mesh)
    section = np.ptp(bar.positions[:, 1]) * np.ptp(bar.positions[:, 2])
    expected = np.diag([rollers.forces.sum(axis=(0, 1))[0] / section, 0.0, 0.0])
    at_vertices = stark.render.tensor_values(sim, "stress")["bar"]
    in_elements = stark.render.tensor_values(sim, "stress", at="elements")["bar"]
    assert in_elements.shape == (len(mesh.elements), 1 if order == 1 else 10, 3, 3)
    # Supports of 1e8 N/m give way by 1e-4 of the stretch.
    np.testing.assert_allclose(
        at_vertices, np.broadcast_to(expected, at_vertices.shape), atol=1e-3 * expected[0, 0]
    )
    np.testing.assert_allclose(
        in_elements, np.broadcast_to(expected, in_elements.shape), atol=1e-3 * expected[0, 0]
    )
    F = stark.render.tensor_values(sim, "deformation_gradient", at="elements")["bar"]
    np.testing.assert_allclose(F[..., 0, 0], 1.1, rtol=1e-3)


def test_laws_of_users_have_the_stress_of_the_same_law() -> None:
    mesh = stark.mesh.box_hexahedra((0.1, 0.04, 0.03), (4, 2, 2))
    shear, stiffness = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
    field = np.linspace(1.0, 2.0, len(mesh.elements))
    own = saint_venant(stiffness=stiffness * field, shear=shear * field, density=1000.0)
    built_in = stark.SolidMaterial(
        density=1000, youngs_modulus=E * field, poissons_ratio=NU, law="st_venant_kirchhoff"
    )
    found = [
        stark.render.tensor_values(sim, "stress")["bar"]
        for sim, _, _ in (pulled(own, mesh), pulled(built_in, mesh))
    ]
    scale = np.abs(found[1]).max()
    assert scale > 1e5
    np.testing.assert_allclose(found[0], found[1], atol=1e-7 * scale)


def test_cloth_and_what_has_no_tensors() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, position=(0, 0, 1))
    sheet = stark.ShellMaterial(density=0.2, thickness=1e-3, youngs_modulus=E, poissons_ratio=0.0)
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.1, (4, 2)), sheet, name="sheet")
    sim = stark.Simulation(scene, time_step=0.01, **STILL)
    cloth.positions = cloth.mesh.vertices * (1.01, 1.0, 1.0)
    stress = stark.render.tensor_values(sim, "stress")
    assert list(stress) == ["sheet"]
    # First Piola-Kirchhoff E strain to the first order; the ratio of areas is 1.01.
    np.testing.assert_allclose(stress["sheet"][:, 0, 0], 0.01 * E, rtol=0.02)
    assert stark.render.tensor_values(sim, "deformation_gradient", at="elements")["sheet"].shape == (
        16,
        1,
        3,
        2,
    )
    with pytest.raises(stark.InvalidArgument, match="tensor 'strain' is unknown: must be one of stress, def"):
        stark.render.tensor_values(sim, "strain")
    with pytest.raises(stark.InvalidArgument, match="no values at vertices: must be at='elements'"):
        stark.render.tensor_values(sim, "deformation_gradient")
