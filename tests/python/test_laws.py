"""Materials of other laws and values of each element: what Python hands to the core."""

from __future__ import annotations

import copy
import inspect
import pickle

import numpy as np
import pytest

import stark
from stark import InvalidArgument, materials


def rubber(**changes: object) -> stark.SolidMaterial:
    return materials.mooney_rivlin(**({"c10": 3e4, "c01": 1e4, "bulk_modulus": 2e6} | changes))


def sagging(material: stark.SolidMaterial, steps: int = 3) -> np.ndarray:
    """Positions of a block that hangs on its top, after some steps."""
    mesh = stark.mesh.tet_box(0.1, 2)
    scene = stark.Scene()
    body = scene.add_solid(mesh, material, pins=mesh.vertices[:, 2] > 0.049)
    simulation = stark.Simulation(scene, time_step=0.01)
    for _ in range(steps):
        simulation.step()
    return body.positions


def test_every_law_has_a_documented_function() -> None:
    elastic = {**materials.solid_laws, **materials.shell_laws}
    for name, law in elastic.items():
        if name in ("stable_neo_hookean", "solid_damping", "strain_limit"):  # that of SolidMaterial itself
            continue
        function = getattr(materials, name)
        for row in law.parameters:
            assert row["name"] in function.__doc__
            assert row["unit"] and row["doc"] and row["rule"]
    assert list(inspect.signature(materials.mooney_rivlin).parameters)[:3] == ["c10", "c01", "bulk_modulus"]


def test_values_are_attributes_and_survive_copies() -> None:
    material = rubber(density=1100.0)
    assert (material.c10, material.density, material.law.name) == (3e4, 1100.0, "mooney_rivlin")
    changed = material.replace(c10=5e4, density=900.0)
    assert (changed.c10, changed.c01, changed.density) == (5e4, 1e4, 900.0)
    assert material.c10 == 3e4
    assert changed != material
    same = pickle.loads(pickle.dumps(material))
    assert same == material
    assert hash(same) == hash(material)
    assert "law=mooney_rivlin" in repr(material)
    assert "c10=30000" in repr(material)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: materials.mooney_rivlin(c10=1.0), "c01 .Pa., .*needed"),
        (lambda: rubber(c10=-1.0), r"c10 = -1 Pa: must be > 0"),
        (lambda: rubber(c10=[1.0, np.nan]), r"c10\[1\] = nan Pa"),
        (lambda: rubber(c10="hard"), "must be a number"),
        (lambda: rubber(c11=1.0), "unknown parameter 'c11'"),
        (
            lambda: materials.fiber_reinforced(
                fiber_stiffness=1.0, fiber_exponent=1.0, fiber_direction=(0, 0, 0)
            ),
            "must not be zero",
        ),
    ],
)
def test_wrong_values_are_refused_when_the_material_is_made(make: object, message: str) -> None:
    with pytest.raises(InvalidArgument, match=message):
        make()  # type: ignore[operator]


def test_wrong_numbers_of_values_are_refused_when_a_body_is_made() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.tet_box(0.1, 1)
    with pytest.raises(
        InvalidArgument, match="'a': c10 has 3 numbers: must be 1 for each of the 12 elements"
    ):
        scene.add_solid(mesh, rubber(c10=[1.0, 2.0, 3.0]), name="a")
    with pytest.raises(InvalidArgument, match="density"):
        scene.add_solid(mesh, materials.soft_rubber.replace(density=[1.0, 2.0]), name="b")
    assert len(scene.bodies) == 0


def test_softer_elements_sag_more() -> None:
    stiff = sagging(rubber(c10=3e3, c01=0.0, bulk_modulus=2e4))
    values = np.full(96, 3e3)
    assert np.array_equal(sagging(rubber(c10=values, c01=0.0, bulk_modulus=2e4)), stiff)
    values[:] = 1e3
    soft = sagging(rubber(c10=values, c01=0.0, bulk_modulus=2e4))
    assert soft[:, 2].min() < stiff[:, 2].min() - 1e-5


def test_all_solid_laws_agree_at_small_strain() -> None:
    """Stiff enough that the strain of gravity is 1e-5: the laws differ by its square."""
    E, nu = 1e8, 0.3
    reference = sagging(stark.SolidMaterial(youngs_modulus=E, poissons_ratio=nu), steps=2)
    rest = stark.mesh.tet_box(0.1, 2).vertices
    moved = np.abs(reference - rest).max()
    for law in ("neo_hookean", "st_venant_kirchhoff", "corotated"):
        positions = sagging(getattr(materials, law)(youngs_modulus=E, poissons_ratio=nu), steps=2)
        assert np.abs(positions - reference).max() < 1e-3 * moved
    mu, bulk = E / (2 * (1 + nu)), E / (3 * (1 - 2 * nu))
    positions = sagging(rubber(c10=0.4 * mu, c01=0.1 * mu, bulk_modulus=bulk), steps=2)
    assert np.abs(positions - reference).max() < 1e-3 * moved


def test_woven_cloth_stretches_by_the_modulus_of_its_direction() -> None:
    """A strip under its weight: the lower edge moves by rho g L^2/(2 E t), warp hanging or weft hanging."""
    weave = materials.orthotropic_cloth(
        warp_modulus=2e4,
        weft_modulus=5e3,
        shear_modulus=2e3,
        poissons_ratio=0.0,
        density=0.1,
        thickness=1e-3,
        bending_stiffness=0.0,
    )
    sag = {}
    for name, direction in (("warp", (0, 1, 0)), ("weft", (1, 0, 0))):
        mesh = stark.mesh.grid(0.1, 0.2, cells=(4, 8))
        scene = stark.Scene()
        cloth = scene.add_cloth(
            mesh,
            weave.replace(warp_direction=direction, mass_damping=20.0),
            pins=mesh.vertices[:, 1] > 0.0999,
        )
        simulation = stark.Simulation(
            scene, time_step=0.02, **{"gravity": (0.0, -1.0, 0.0), "contact.enabled": False}
        )
        simulation.run_until(2.0)
        sag[name] = -0.1 - cloth.positions[:, 1].min()
    assert sag["warp"] == pytest.approx(0.1 * 1.0 * 0.2**2 / (2 * 2e4 * 1e-3), rel=0.05)
    assert sag["weft"] == pytest.approx(0.1 * 1.0 * 0.2**2 / (2 * 5e3 * 1e-3), rel=0.05)


@stark.material
def fibred(
    F: stark.DeformationGradient,
    mu: float = stark.parameter(1e4, unit="Pa", above=0.0),
    fibre: stark.Vec3 = stark.parameter((1.0, 0.0, 0.0)),
):
    J, f = stark.determinant(F), F @ fibre
    return 0.5 * mu * (stark.trace(F.T @ F) - 3 - 2 * stark.log(J) + 4 * (J - 1) ** 2 + (f @ f - 1) ** 2)


@stark.material
def cord(stretch, EA: float = stark.parameter(unit="N", above=0.0)):
    return 0.5 * EA * (stretch - 1) ** 2


@pytest.mark.parametrize(
    "material",
    [
        fibred(mu=2e4, fibre=(0, 1, 0), density=777.0, name="meat"),
        fibred(mu=[1e4, 2e4, 3e4]).replace(density=900.0),
        fibred(fibre=np.tile([0.0, 1.0, 0.0], (4, 1))),
        cord(EA=20.0, base=materials.rubber_cord),
        stark.generalized_maxwell(shear_modulus=1e5, bulk_modulus=1e9, moduli=[1e4, 2e4], times=[1.0, 9.0]),
        stark.measured.steel,
        stark.measured.skin,
    ],
    ids=repr,
)
def test_materials_of_functions_may_be_pickled_and_copied(material: stark.SolidMaterial) -> None:
    for same in (pickle.loads(pickle.dumps(material)), copy.deepcopy(material)):
        assert same == material and type(same) is type(material)
        assert (same.name, same.source) == (material.name, material.source)
        before, after = material.to_dict(), same.to_dict()
        assert before.keys() == after.keys()
        assert all(np.array_equal(before[name], after[name]) for name in before)


def test_a_material_of_a_function_within_another_cannot_be_pickled() -> None:
    @stark.material
    def within(F: stark.DeformationGradient, mu: float = 1e4):
        return mu * (stark.trace(F.T @ F) - 2 * stark.log(stark.determinant(F)))

    with pytest.raises((AttributeError, pickle.PicklingError), match="within"):
        pickle.dumps(within(mu=2e4))
