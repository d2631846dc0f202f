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


STEEL = {"shear_modulus": 8e10, "bulk_modulus": 1.7e11, "yield_stress": 2.5e8, "hardening_modulus": 2e9}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("formulation", ["displacement", "mean_dilatation"])
def test_metal_that_yields_has_the_stress_of_its_hardening(order: int, formulation: str) -> None:
    """Uniaxial: sigma = Y + H p, the pull over the section, and lengths are those of both strains."""
    mesh: Any = stark.mesh.box_hexahedra((0.1, 0.02, 0.02), (4, 1, 1))
    mesh = stark.mesh.to_quadratic(mesh) if order == 2 else mesh
    scene = stark.Scene()
    steel = stark.j2_plasticity(**STEEL, density=7850.0)
    bar = scene.add_solid(mesh, steel, name="bar", formulation=formulation)
    at = mesh.vertices
    for k, axis in enumerate("xyz"):
        scene.add_rollers(bar.vertices[abs(at[:, k] - at[:, k].min()) < 1e-9], axis)
    pull = scene.add_rollers(bar.vertices[abs(at[:, 0] - at[:, 0].max()) < 1e-9], "x", shift=0.0)
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    K, G, Y, H = (
        STEEL["bulk_modulus"],
        STEEL["shear_modulus"],
        STEEL["yield_stress"],
        STEEL["hardening_modulus"],
    )
    young = 9 * K * G / (3 * K + G)
    for shift in (1e-4, 1e-3, 2e-3, 1.9e-3):
        pull.shift = shift
        assert not sim.step().failed
        flow = bar.internal_variables["plastic_strain"]
        p = flow.mean()
        assert flow.shape == (4, 27 if order == 2 else 8) and np.ptp(flow) < 1e-3 * max(p, 1e-3)
        section = np.ptp(bar.positions[:, 1]) * np.ptp(bar.positions[:, 2])
        stress = stark.render.tensor_values(sim, "stress", at="elements")["bar"]
        assert stress.shape == (4, 1, 3, 3)
        np.testing.assert_allclose(stress[:, 0, 0, 0], pull.forces.sum(axis=(0, 1))[0] / section, rtol=1e-4)
        assert np.abs(stress[:, 0, 1, 1]).max() < 1e-3 * Y  # supports give way a little
        if shift in (1e-3, 2e-3):  # it flows; von Mises of Kirchhoff stresses: J of elastic strains
            np.testing.assert_allclose(stress[:, 0, 0, 0], Y + H * p, rtol=2e-3)
        elongation = np.log(np.ptp(bar.positions[:, 0]) / 0.1)
        np.testing.assert_allclose(stress[0, 0, 0, 0] / young + p, elongation, rtol=2e-3)
        shown = stark.render.field_values(sim, "plastic_strain")["bar"]
        np.testing.assert_allclose(shown, p, rtol=1e-3, atol=1e-12)


def test_foil_that_yields_and_elastic_bodies_beside_it() -> None:
    Y, H = 6e7, 5e8
    foil = stark.ShellMaterial(
        density=0.135, thickness=5e-5, youngs_modulus=7e10, poissons_ratio=0.33, flexural_rigidity=8.2e-4,
        yield_stress=Y, hardening_modulus=H,
    )  # fmt: skip
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.1, 0.02, cells=(10, 2)), foil, name="foil")
    scene.add_cloth(
        stark.mesh.grid(0.1, 0.02, cells=2), stark.materials.cotton, name="cotton", position=(0, 1, 0)
    )
    at = sheet.mesh.vertices
    ends = [np.flatnonzero(abs(at[:, 0] - x) < 1e-9) for x in (-0.05, 0.05)]
    for k in (0, 1):
        scene.add_rollers(sheet.vertices[ends[0] if k == 0 else np.flatnonzero(at[:, 1] < -0.0099)], "xy"[k])
    pull = scene.add_rollers(sheet.vertices[ends[1]], "x", shift=2e-4)
    sheet.pin([int(ends[0][0])])
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    p = sheet.internal_variables["plastic_work"] / Y
    stress = stark.render.tensor_values(sim, "stress", at="elements")["foil"]
    assert p.mean() > 1e-3 and stress.shape == (40, 1, 3, 3)
    width = np.ptp(sheet.positions[:, 1])
    np.testing.assert_allclose(
        stress[:, 0, 0, 0].mean(), pull.forces.sum(axis=(0, 1))[0] / (width * 5e-5), rtol=1e-3
    )
    np.testing.assert_allclose(stress[:, 0, 0, 0], Y + H * p[:, 0], rtol=5e-3)
    shown = stark.render.field_values(sim, "plastic_strain")
    np.testing.assert_allclose(shown["foil"], p.mean(), rtol=0.05)
    assert not shown["cotton"].any() and sim["cotton"].internal_variables == {}


@pytest.mark.parametrize("h", [0.02, 0.2])
def test_stress_relaxes_as_the_prony_series(h: float) -> None:
    """Uniaxial strain e from the start of the first step on: (K + 4/3 G(t)) e, exact for any step."""
    K, G, branch, tau, e = 8e4, 4e4, 8e4, 0.1, 1e-5
    law = stark.generalized_maxwell(
        shear_modulus=G, bulk_modulus=K, moduli=[branch], times=[tau], density=1000.0
    )
    mesh = stark.mesh.box_hexahedra((0.1, 0.1, 0.1), 2)
    scene = stark.Scene()
    inner = int(np.linalg.norm(mesh.vertices, axis=1).argmin())
    pins = [k for k in range(len(mesh.vertices)) if k != inner]
    block = scene.add_solid(mesh, law, name="block", pins=pins)
    sim = stark.Simulation(
        scene, time_step=h, gravity=(0, 0, 0), settings={"newton.residual_tolerance": 1e-9}
    )
    block.pin_targets = mesh.vertices[pins] * (1.0 + e, 1.0, 1.0)
    for n in range(3):
        assert not sim.step().failed
        left = branch * np.exp(-(n + 1) * h / tau)
        stress = stark.render.tensor_values(sim, "stress", at="elements")["block"][:, 0]
        along, across = K + 4 / 3 * (G + left), K - 2 / 3 * (G + left)
        np.testing.assert_allclose(stress[:, 0, 0], along * e, rtol=1e-4)
        np.testing.assert_allclose(stress[:, [1, 2], [1, 2]], across * e, rtol=2e-4)
    # Virtual work of the pins, now that all is at rest.
    work = block.pin_forces[:, 0] @ block.positions[pins, 0]
    np.testing.assert_allclose(stress[0, 0, 0], work / (1e-3 * (1.0 + e)), rtol=1e-6)


def test_stress_of_what_remembers_is_without_damping() -> None:
    """A strip under 20 N/m at rest, of a sheet that could yield: dampers have nothing to say."""
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.2, 0.1, (8, 4))
    x = mesh.vertices[:, 0]
    sheet = stark.ShellMaterial(
        density=0.2, thickness=1e-3, youngs_modulus=5e5, poissons_ratio=0.0, yield_stress=1e9,
        bending_stiffness=1e-6, strain_damping=50.0, mass_damping=5.0,
    )  # fmt: skip
    cloth = scene.add_cloth(mesh, sheet, pins=np.flatnonzero(x < -0.0999), name="strip")
    end = np.flatnonzero(x > 0.0999)
    share = np.where(np.abs(mesh.vertices[end, 1]) > 0.0499, 0.0125, 0.025)
    scene.add_force(cloth.vertices[end], np.outer(share, (20.0, 0.0, 0.0)))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), time_step=0.01)
    for report in sim.run(2.0):
        assert not report.failed, report.message
    np.testing.assert_allclose(stark.render.field_values(sim, "stress")["strip"], 2e4, rtol=1e-3)


def quarter_of_tube(kind: str) -> stark.mesh.SolidMesh | stark.mesh.TetMesh:
    """Radii of 0.1 and 0.2 m, 0.02 m long, 8 x 12 cells."""
    make = stark.mesh.tet_box if kind == "tet10" else stark.mesh.box_hexahedra
    cells = make(1.0, (8, 12, 1))
    u, v, w = (cells.vertices + 0.5).T
    radius, angle = 0.1 + 0.1 * u, v * np.pi / 2
    bent = np.column_stack((radius * np.cos(angle), radius * np.sin(angle), 0.02 * w))
    mesh = type(cells)(bent, cells.elements)
    return mesh if kind == "hex8" else stark.mesh.to_quadratic(mesh)


@pytest.mark.parametrize("kind", ["hex8", "hex27", "tet10"])
def test_stress_of_mean_dilatation_is_that_of_lame(kind: str) -> None:
    """A tube of hardly compressible rubber under inner pressure p. The volume ratio of single nodes, which
    the law does not see, gave radial stresses of up to 370 p in place of -p."""
    mesh, p = quarter_of_tube(kind), 1e3
    x, y, z = mesh.vertices.T
    r = np.hypot(x, y)
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e6, poissons_ratio=0.4999)
    tube = scene.add_solid(mesh, rubber, formulation="mean_dilatation", position=(0.3, 0.0, 0.2), name="tube")
    for normal, held in (("x", x < 1e-9), ("y", y < 1e-9), ("z", (z < 1e-9) | (z > 0.02 - 1e-9))):
        scene.add_rollers(tube.vertices[held], normal)
    inside = r < 0.1 + 1e-3
    scene.add_face_pressure(tube.faces[inside[tube.triangles].all(axis=1)], p)
    sim = stark.Simulation(scene, time={"integrator": "quasistatic"}, time_step=1.0, gravity=(0, 0, 0))
    assert not sim.step().failed
    stress, out = stark.render.tensor_values(sim, "stress")["tube"], np.column_stack((x / r, y / r, 0.0 * r))
    around = np.column_stack((-out[:, 1], out[:, 0], 0.0 * r))
    radial, hoop = (np.einsum("ni,nij,nj->n", n, stress, n) / p for n in (out, around))
    middle = np.abs(r - 0.15) < 1e-3
    assert radial[middle] == pytest.approx((1.0 - 0.04 / 0.0225) / 3.0, abs=0.01)
    assert hoop[middle] == pytest.approx((1.0 + 0.04 / 0.0225) / 3.0, abs=0.01)
    assert radial[inside] == pytest.approx(-1.0, abs=0.12)  # linear elements: the mean of the first cell


@pytest.mark.parametrize("order", [1, 2])
def test_stress_of_mean_dilatation_in_a_lattice_is_the_pressure_around(order: int) -> None:
    turned = stark.mesh.box((0.2, 0.1, 0.1)).rotated(stark.rotation(axis=(1, 2, 3), angle=0.7))
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e6, poissons_ratio=0.4999)
    block = scene.add_solid(
        stark.mesh.lattice(turned, cell_size=0.05, order=order),
        rubber,
        formulation="mean_dilatation",
        name="block",
    )
    scene.add_pressure(block, -1e3)  # outside over inside
    sim = stark.Simulation(scene, time_step=0.5, gravity=(0, 0, 0))
    for _ in range(10):
        assert not sim.step().failed
    stress = stark.render.tensor_values(sim, "stress")["block"] / 1e3
    pressure = -np.trace(stress, axis1=1, axis2=2) / 3.0
    assert np.mean(pressure) == pytest.approx(1.0, abs=0.02)
    assert np.std(pressure) < 0.25  # most of it in slivers
