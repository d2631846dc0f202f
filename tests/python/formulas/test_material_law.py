"""Laws that were recorded: the materials they make, values by element, warnings, listings."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import stark
from stark import InvalidArgument, StarkWarning

MODULUS = stark.parameter(1e4, unit="Pa", above=0.0)


@stark.material
def saint_venant(F: stark.DeformationGradient, mu: float = MODULUS, lam: float = MODULUS):
    """St. Venant-Kirchhoff."""
    E = 0.5 * (F.T @ F - stark.identity(3))
    return mu * stark.squared_norm(E) + 0.5 * lam * stark.trace(E) ** 2


@stark.material
def membrane(C: stark.CauchyGreen, mu: float = MODULUS, lam: float = MODULUS):
    E = 0.5 * (C - stark.identity(2))
    return mu * stark.squared_norm(E) + 0.5 * lam * stark.trace(E) ** 2


@stark.material
def woven(
    F: stark.ShellDeformationGradient,
    F_prev: stark.ShellDeformationGradient,
    h: stark.TimeStep,
    warp: float = MODULUS,
    weft: float = MODULUS,
    viscosity: float = stark.parameter(0.0, unit="Pa s", min=0.0),
):
    E = 0.5 * (F.T @ F - stark.identity(2))
    E_prev = 0.5 * (F_prev.T @ F_prev - stark.identity(2))
    elastic = 0.5 * warp * E[0, 0] ** 2 + 0.5 * weft * E[1, 1] ** 2 + warp * E[0, 1] ** 2
    return elastic + 0.5 * viscosity / h * stark.squared_norm(E - E_prev)


def test_laws_make_materials_with_the_other_fields() -> None:
    material = saint_venant(mu=2e4, density=1234.0, strain_damping=0.1, name="block")
    assert isinstance(material, stark.SolidMaterial)
    assert (material.mu, material.lam, material.density, material.name) == (2e4, 1e4, 1234.0, "block")
    cloth = membrane(base=stark.materials.cotton, mu=5e3)
    assert isinstance(cloth, stark.ShellMaterial)
    assert cloth.density == stark.materials.cotton.density
    assert cloth.bending_stiffness == stark.materials.cotton.bending_stiffness
    assert cloth.replace(mu=6e3).mu == 6e3
    with pytest.raises(InvalidArgument, match="mu"):
        cloth.replace(mu=-1.0)


def test_values_may_differ_by_element() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.tet_box((0.2, 0.05, 0.05), (4, 1, 1))
    soft = np.where(mesh.vertices[mesh.tets].mean(axis=1)[:, 0] < 0.0, 1e4, 1e6)
    bar = scene.add_solid(mesh, saint_venant(mu=soft, lam=1e4, density=500.0), pins=[0])
    stretched = mesh.vertices * [1.0, 1.0, 1.0]
    assert bar.positions.shape == stretched.shape
    assert not stark.Simulation(scene, time_step=0.01).step().failed
    with pytest.raises(InvalidArgument, match="mu"):
        scene.add_solid(mesh, saint_venant(mu=np.full(3, 1e4)), position=(1.0, 0.0, 0.0))


def warned(law: object, **values: object) -> str:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        law(**values)
    assert all(issubclass(w.category, StarkWarning) for w in caught)
    assert all(w.filename == __file__ for w in caught)  # the user's line, not one of the package
    return "\n".join(str(w.message) for w in caught)


def test_a_law_that_is_not_objective_is_warned_about() -> None:
    @stark.material
    def small_strain(F: stark.DeformationGradient, mu: float = MODULUS):
        e = 0.5 * (F + F.T) - stark.identity(3)
        return mu * stark.squared_norm(e)

    message = warned(small_strain)
    assert "small_strain: not objective" in message and "resists rotation" in message
    assert "C = F.T @ F" in message and "in small_strain" in message
    assert small_strain.check()["objectivity"].status == "wrong"

    @stark.material(objective=False)
    def meant(F: stark.DeformationGradient, mu: float = MODULUS):
        e = 0.5 * (F + F.T) - stark.identity(3)
        return mu * stark.squared_norm(e)

    assert warned(meant) == ""
    assert warned(saint_venant) == warned(membrane) == warned(woven) == ""


def test_a_law_that_is_not_stable_is_warned_about() -> None:
    @stark.material
    def upside_down(C: stark.CauchyGreen, mu: float = MODULUS):
        E = 0.5 * (C - stark.identity(2))
        return -mu * stark.squared_norm(E)

    assert "upside_down: unstable at rest" in warned(upside_down)
    assert upside_down.check()["stability"].status == "wrong"


def test_stress_at_rest_is_no_instability() -> None:
    """A law that wants to be longer along x is under pressure at rest, which a rotation of F along a straight
    way relieves. Its strains are resisted, and it goes to the stretches in closed form."""

    @stark.material(stress_free=False)
    def nematic(F: stark.DeformationGradient, mu: float = MODULUS, r: float = 2.0):
        along = stark.vec(1.0, 0.0, 0.0)
        C = F.T @ F
        J = stark.determinant(F)
        ordered = r ** (1 / 3) * (stark.trace(C) + (1 / r - 1) * (along @ (C @ along)))
        return 0.5 * mu * (ordered - 3 - 2 * stark.log(J)) + 50 * mu * (J - 1) ** 2

    assert warned(nematic) == ""
    assert nematic.check()["stability"].status == "ok"
    scene = stark.Scene()
    block = scene.add_solid(stark.mesh.tet_box(0.1, 2), nematic(density=1e3))
    sim = stark.Simulation(scene, {"time.integrator": "quasistatic"}, gravity=(0, 0, 0))
    sim.step()
    stretches = np.sort(np.ptp(block.positions, axis=0)) / 0.1
    assert stretches == pytest.approx([2 ** (-1 / 6), 2 ** (-1 / 6), 2 ** (1 / 3)], rel=1e-5)


def test_values_of_no_elements_are_refused() -> None:
    with pytest.raises(
        stark.InvalidArgument, match=r"'yield_stress' \[Pa\] has the shape \(0,\): must be \(\)"
    ):
        stark.j2_plasticity(shear_modulus=1.0, bulk_modulus=1.0, yield_stress=[])


def test_a_law_with_stress_at_rest_is_refused_unless_it_is_meant() -> None:
    @stark.material
    def tense(F: stark.DeformationGradient, mu: float = MODULUS):
        return 0.5 * mu * (stark.squared_norm(F) - 3.0)

    with pytest.raises(InvalidArgument, match=r"tense: the stress at rest.* 1e\+04 Pa: must be zero"):
        tense()

    @stark.material(stress_free=False)
    def balloon(F: stark.DeformationGradient, mu: float = MODULUS):
        return 0.5 * mu * (stark.squared_norm(F) - 3.0)

    assert isinstance(balloon(), stark.SolidMaterial)


def test_listing_and_counts() -> None:
    text = str(saint_venant.graph())
    assert text.startswith("saint_venant(F, mu, lam):") and "F[0,0]" in text
    assert saint_venant.statistics.operations["hessian"] > saint_venant.statistics.operations["value"] > 10
    report = saint_venant.check(mu=1e4)
    assert report.ok and "nothing is wrong" in str(report)
    assert report["stress"].value < 1e-8 and report["stiffness"].value < 1e-8


def test_strains_that_nothing_resists_are_named() -> None:
    """A solid without shear stiffness, a fluid with the volume alone, a sheet of threads along x and y."""

    @stark.material
    def threads(F: stark.DeformationGradient, k: float = 1e5):
        E = 0.5 * (F.T @ F - stark.identity(3))
        return 0.5 * k * (E[0, 0] ** 2 + E[1, 1] ** 2 + E[2, 2] ** 2)

    @stark.material
    def fluid(F: stark.DeformationGradient, k: float = 1e5):
        return 0.5 * k * (stark.determinant(F) - 1.0) ** 2

    report = threads.check()
    assert not report.ok
    assert "no stiffness at rest against shear xy, shear xz, shear yz" in report["stability"].text
    text = fluid.check()["stability"].text
    assert "against shear xy, shear xz, shear yz, 2 combinations of stretch and shear" in text
    scene = stark.Scene()
    with pytest.warns(stark.StarkWarning, match="threads: no stiffness at rest against shear xy"):
        scene.add_solid(stark.mesh.tet_box(0.1, 1), threads(density=1000.0))
