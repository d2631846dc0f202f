"""Materials: presets against their sources, masses, values that do not change."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest

import stark
from stark import mesh


def test_presets_have_the_documented_numbers() -> None:
    cotton, rubber, towel = stark.materials.cotton, stark.materials.soft_rubber, stark.materials.towel
    assert cotton.to_dict() == {
        "density": 0.2, "thickness": 1e-3, "youngs_modulus": 5e3, "poissons_ratio": 0.3, "strain_limit": 0.1,
        "strain_limit_stiffness": 1e6, "strain_limit_hardening": 500.0,
        "strain_limit_law": "green_strain", "bending_stiffness": 1e-6, "flexural_rigidity": 0.0,
        "yield_stress": math.inf, "hardening_modulus": 0.0, "bending_yield_moment": 0.0,
        "bending_hardening": 0.0,
        "mass_damping": 0.1, "strain_damping": 0.5, "bending_damping": 1e-7,
        "thermal_expansion": 0.0,
    }  # fmt: skip
    steel = stark.materials.plate(
        youngs_modulus=2.1e11, poissons_ratio=0.3, thickness=1e-4, density=7850.0, bending_stiffness=0.0
    )
    sheet = stark.materials.steel_sheet.to_dict()
    assert steel.flexural_rigidity == pytest.approx(2.1e11 * 1e-12 / (12 * 0.91), rel=1e-12)
    assert sheet.pop("strain_limit_law") == steel.strain_limit_law
    assert {name: steel.to_dict()[name] for name in sheet} == pytest.approx(sheet, rel=1e-12)
    assert rubber.to_dict() == {
        "density": 1000.0, "youngs_modulus": 1e4, "poissons_ratio": 0.3, "strain_limit": 1.0,
        "strain_limit_stiffness": 1e2, "strain_limit_hardening": 500.0,
        "strain_limit_law": "green_strain", "mass_damping": 0.1, "strain_damping": 0.0,
        "thermal_expansion": 0.0,
    }  # fmt: skip
    # The towel of the paper: 0.484 kg on 1.75 m x 0.75 m, E 15 kPa, 3.25 mm, damping 0.1 of the stiffness.
    assert towel.density * 1.75 * 0.75 == pytest.approx(0.484, rel=1e-14)
    assert (towel.youngs_modulus, towel.thickness, towel.mass_damping) == (1.5e4, 3.25e-3, 2.0)
    assert towel.strain_damping == pytest.approx(0.1 * towel.thickness * towel.youngs_modulus, rel=1e-14)
    assert all(preset.source for preset in stark.materials.presets.values())


def test_presets_of_solids_and_rods_follow_from_their_sources() -> None:
    m = stark.materials
    assert m.foam.youngs_modulus == pytest.approx(45e6 * (m.foam.density / 1200.0) ** 2)  # Gibson, Ashby
    assert (m.natural_rubber.youngs_modulus, m.rubber_cord.youngs_modulus) == (1.5e6, 1.5e6)  # 40 IRHD
    assert (m.steel.youngs_modulus, m.steel.density, m.steel.poissons_ratio) == (2.1e11, 7850.0, 0.3)
    assert (m.pet_solid.youngs_modulus, m.pet_solid.density) == (3.1e9, 1360.0)
    # 4 mm of rubber: 11.9 g/m, and E A = 18.8 N for a doubled length.
    assert m.rubber_cord.section["mass"] == pytest.approx(0.01194, rel=1e-3)
    assert m.rubber_cord.section["axial_stiffness"] == pytest.approx(18.85, rel=1e-3)


def test_deformable_bodies_have_the_mass_that_they_are_given() -> None:
    """Momentum of free fall after one step is m g h."""
    for add in (
        lambda s: s.add_cloth(mesh.grid(0.3, 0.2, 4), mass=0.02),
        lambda s: s.add_solid(mesh.tet_box(0.1, 2), mass=0.02),
        lambda s: s.add_solid(mesh.box_hexahedra(0.1, 2), mass=0.02),
        lambda s: s.add_rod(mesh.polyline((0, 0, 0), (1, 0, 0), 8), mass=0.02),
    ):
        scene = stark.Scene()
        add(scene)
        sim = stark.Simulation(scene, time_step=1e-3, **{"contact.enabled": False})
        damped = 1.0 + 0.1 * 1e-3  # every preset has the mass damping 0.1/s
        assert sim.step().momentum[2] == pytest.approx(-0.02 * 9.81 * 1e-3 / damped, rel=1e-4)


def test_materials_are_immutable_values() -> None:
    cotton = stark.materials.cotton
    stiff = cotton.replace(bending_stiffness=1e-5)
    assert (stiff.bending_stiffness, cotton.bending_stiffness) == (1e-5, 1e-6)
    assert stiff != cotton and stiff.replace(bending_stiffness=1e-6) == cotton
    assert hash(stiff.replace(bending_stiffness=1e-6)) == hash(cotton)
    with pytest.raises(AttributeError, match=r"replace\(density=3"):
        cotton.density = 3  # type: ignore[misc]
    assert not hasattr(cotton, "colour")
    assert pickle.loads(pickle.dumps(stiff)) == stiff
    assert "bending_stiffness=1e-05" in repr(stiff)


@pytest.mark.parametrize("kind", [stark.ShellMaterial, stark.SolidMaterial])
def test_the_annotations_of_materials_are_the_parameters_of_the_core(kind: type) -> None:
    names = [parameter["name"] for parameter in kind.parameters()]
    assert [name for name in kind.__annotations__ if not name.startswith("_")] == names
    assert all(parameter["doc"] for parameter in kind.parameters())
    assert [row["name"] for row in kind.parameters() if not row["unit"]] == ["strain_limit_law"]


def test_unknown_presets_are_answered_with_the_nearest() -> None:
    with pytest.raises(AttributeError, match=r"no material 'coton' in .*; did you mean 'cotton'"):
        _ = stark.materials.coton  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"'xyz'.*presets are cotton"):
        _ = stark.materials.xyz  # type: ignore[attr-defined]


def test_laws_are_given_by_name_or_as_they_are() -> None:
    values = {"density": 1000.0, "youngs_modulus": 1e5, "poissons_ratio": 0.3}
    by_name = stark.SolidMaterial(law="neo_hookean", **values)
    assert by_name.law is stark.materials.solid_laws["neo_hookean"]
    assert stark.SolidMaterial(law=by_name.law, **values).law is by_name.law
    assert by_name.replace(density=900.0).law is by_name.law
    scene = stark.Scene()
    scene.add_solid(mesh.tet_box(0.1, 1), by_name)
    for kind, law in (
        (stark.SolidMaterial, "hooke"),
        (stark.ShellMaterial, "neo_hookean"),
        (stark.ShellMaterial, by_name.law),
        (stark.RodMaterial, 3),
    ):
        with pytest.raises(
            stark.InvalidArgument, match=f"{kind.__name__}: law = .*must be one of .*@stark.material"
        ):
            kind(law=law)


def test_numbers_in_quotes_are_refused() -> None:
    with pytest.raises(
        stark.InvalidArgument, match="youngs_modulus = '1e5': must be a number, not a text; write"
    ):
        stark.SolidMaterial(youngs_modulus="1e5")
    with pytest.raises(
        stark.InvalidArgument, match="'soft_rubber': density = ' 900': must be a number, not a text"
    ):
        stark.materials.soft_rubber.replace(density=" 900")
    assert (
        stark.materials.soft_rubber.replace(strain_limit_law="green_strain").strain_limit_law
        == "green_strain"
    )


def test_names_of_materials_are_texts() -> None:
    cotton = stark.materials.cotton
    assert cotton.replace(name="linen").name == "linen"
    with pytest.raises(stark.InvalidArgument, match="ShellMaterial: name = nan: must be a text"):
        cotton.replace(name=float("nan"))  # type: ignore[arg-type]
    with pytest.raises(stark.InvalidArgument, match="RodMaterial: name = 3: must be a text"):
        stark.RodMaterial(name=3)  # type: ignore[arg-type]


def test_parameters_that_a_law_does_not_have_are_refused() -> None:
    """Young's modulus of the class stays in a material of another law, which does not read it."""
    mooney_rivlin = stark.materials.mooney_rivlin
    rubber = mooney_rivlin(c10=3e4, c01=1e4, bulk_modulus=2e6, density=1100.0)
    assert "youngs_modulus" not in repr(rubber) and "poissons_ratio" not in repr(rubber)
    assert "youngs_modulus=3000" in repr(stark.materials.neo_hookean(youngs_modulus=3e3))
    message = r"youngs_modulus = .*: must be left out.*'mooney_rivlin'.* has c10, c01, bulk_modulus instead"
    with pytest.raises(stark.InvalidArgument, match=f"material 'mooney_rivlin': {message}"):
        rubber.replace(youngs_modulus=1e5)
    with pytest.raises(stark.InvalidArgument, match=f"material 'mooney_rivlin': {message}"):
        mooney_rivlin(c10=3e4, c01=1e4, bulk_modulus=2e6, youngs_modulus=np.full(3, 1e5))
    with pytest.raises(stark.InvalidArgument, match=f"SolidMaterial: {message}"):
        stark.SolidMaterial(law="mooney_rivlin", c10=3e4, c01=1e4, bulk_modulus=2e6, youngs_modulus=1e5)
    with pytest.raises(stark.InvalidArgument, match=r"'rubber': poissons_ratio = 0\.4: must be left out"):
        stark.measured.rubber.replace(poissons_ratio=0.4)

    @stark.material
    def own(F: stark.DeformationGradient, mu: float = 1.0) -> Any:
        return mu * stark.squared_norm(F.T @ F - stark.identity(3))

    with pytest.raises(stark.InvalidArgument, match=r"own: youngs_modulus = 1\.0: must be left out.* has mu"):
        own(youngs_modulus=1.0)
    assert own(mu=2.0, base=stark.materials.soft_rubber).replace(mu=3.0, density=5.0).mu == 3.0
    assert pickle.loads(pickle.dumps(rubber)) == rubber
    for stuff, read in ((rubber, "c10, c01, bulk_modulus"), (own(mu=2.0), "mu")):
        assert not {"youngs_modulus", "poissons_ratio"} & {*stuff.to_dict(), *dir(stuff)}
        with pytest.raises(
            AttributeError, match=f"'{stuff.law.name}' has no youngs_modulus.* has {read} inst"
        ):
            stuff.youngs_modulus  # noqa: B018
    assert stark.materials.neo_hookean(youngs_modulus=3e3).to_dict()["youngs_modulus"] == 3e3
    cord = stark.generalized_maxwell_rod(stark.materials.rubber_cord, moduli=[1e6], times=[0.5])
    assert cord.replace(youngs_modulus=1e5).youngs_modulus == 1e5  # for its shear stiffness


def test_a_mesh_of_unusual_size_is_warned_of_once() -> None:
    scene = stark.Scene()
    with pytest.warns(stark.StarkWarning) as found:
        scene.add_rigid(mesh.box(400.0), density=1.0, name="big")  # beyond 100 m, when it is added
        stark.Simulation(scene)
    assert [str(w.message).count("extent") for w in found if "extent" in str(w.message)] == [1]
    scene = stark.Scene()
    scene.add_rigid(mesh.box(80.0), density=100.0)  # unusual for what moves alone
    with pytest.warns(stark.StarkWarning, match="extent of the mesh = 80 m"):
        stark.Simulation(scene)


@pytest.mark.parametrize("mass", [np.full(25, 0.01), [0.01] * 25, [[1.0], [1.0, 2.0]]])
def test_masses_by_vertex_are_refused_with_what_to_give_instead(mass: object) -> None:
    sheet = stark.mesh.grid(0.2, 0.2, cells=4)
    with pytest.raises(
        stark.InvalidArgument, match=r"cloth: mass has .* numbers: must be one.* density for each"
    ):
        stark.Scene().add_cloth(sheet, stark.materials.cotton, mass=mass)  # type: ignore[arg-type]
    values = np.linspace(0.1, 0.3, len(sheet.triangles))
    body = stark.Scene().add_cloth(sheet, stark.materials.cotton.replace(density=values))
    assert body.mass == pytest.approx(0.04 * values.mean())
