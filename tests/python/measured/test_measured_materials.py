"""The table of real materials: complete, sourced, and what simulations accept; the fitted ones are what a
fit gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark
from stark import curves, measured
from stark.calibration.laws import law_formula
from stark.calibration.response import Response

ROOT = Path(__file__).resolve().parents[3]
WANTED = [
    "rubber",
    "foam",
    "pet",
    "paper",
    "aluminium_foil",
    "copper_wire",
    "skin",
    "terry_towel",
    "cotton",
    "steel",
]
KINDS = ("fit:", "published fit:", "published test:", "data sheet:", "handbook:", "standard:")


def test_there_are_the_ten_materials_each_with_its_source() -> None:
    assert list(measured.presets) == WANTED
    own = [preset for preset in measured.presets.values() if preset not in stark.materials.presets.values()]
    assert len(own) == 7 and all(preset.source.startswith(KINDS) for preset in own)
    assert all(preset.source for preset in measured.presets.values())
    guide = (ROOT / "docs/fitting.md").read_text()
    assert all(f"| `{name}` |" in guide for name in WANTED)


def test_sheets_have_a_thickness_and_the_mass_of_it() -> None:
    for name, density in (("pet", 1390.0), ("aluminium_foil", 2710.0), ("paper", 800.0)):
        sheet = measured.presets[name]
        assert isinstance(sheet, stark.ShellMaterial)
        assert sheet.density == pytest.approx(density * sheet.thickness)
        assert sheet.flexural_rigidity == pytest.approx(
            sheet.youngs_modulus * sheet.thickness**3 / (12.0 * (1.0 - sheet.poissons_ratio**2))
        )


def test_rubber_is_what_a_fit_to_the_curves_of_treloar_gives() -> None:
    fit = stark.fit(
        measured.carroll,
        measured.treloar(),
        start={"a": 1e5, "b": 0.1, "c": 1e5},
        fixed={"bulk_modulus": 1.95e9},
    )
    assert fit.converged and not fit.warnings
    for name in fit.free:
        assert measured.rubber.to_dict()[name] == pytest.approx(fit[name], rel=5e-4)
    # Carroll 2011 gives 0.15 MPa, 3.1e-7 MPa and 0.095 MPa for the same rubber.
    for name, published in (("a", 0.15e6), ("b", 0.31), ("c", 0.095e6)):
        assert fit[name] == pytest.approx(published, rel=0.15)
    assert all(of.r_squared > 0.997 for of in fit.curves)
    assert all(of.rms < 0.02 * of.curve.scale for of in fit.curves)


def test_mooney_rivlin_holds_for_moderate_stretches_of_rubber_only() -> None:
    start, fixed = {"c10": 1e5, "c01": 1e4}, {"bulk_modulus": 1.95e9}
    moderate = stark.fit(stark.materials.mooney_rivlin, measured.treloar(3.1), start=start, fixed=fixed)
    # Textbooks have c10 = 0.16 to 0.19 MPa and a small c01 for this rubber; the fit is within 5 % of the
    # largest stress.
    assert 1.4e5 < moderate["c10"] < 2.0e5 and 0.0 < moderate["c01"] < 0.2 * moderate["c10"]
    assert all(of.rms < 0.05 * of.curve.scale for of in moderate.curves)
    with pytest.warns(stark.StarkWarning, match="'c01' = .* ended at a bound"):
        whole = stark.fit(stark.materials.mooney_rivlin, measured.treloar()[0], start=start, fixed=fixed)
    assert whole.curves[0].rms > 0.1 * whole.curves[0].curve.scale  # it does not stiffen


def test_steel_has_the_modulus_yield_stress_and_slope_of_the_standard() -> None:
    strain = np.array([0.5e-3, 1.0e-3, 0.01, 0.02])
    values = {
        name: measured.steel.to_dict()[name]
        for name in (
            "shear_modulus",
            "bulk_modulus",
            "yield_stress",
            "hardening_modulus",
            "kinematic_modulus",
            "saturation_increase",
            "saturation_rate",
        )
    }
    point = np.array(list(values.values()))
    test = curves.uniaxial(np.exp(strain), strain)
    stress = Response(law_formula(stark.j2_plasticity), test, list(values), {}, point)(point)[0][
        :, 0
    ] * np.exp(strain)
    np.testing.assert_allclose(stress[:2], 210e9 * strain[:2], rtol=1e-6)
    assert (stress[3] - stress[2]) / 0.01 == pytest.approx(2.1e9, rel=1e-5)
    assert stress[2] == pytest.approx(235e6 + 2.1e9 * (0.01 - 235e6 / 210e9), rel=1e-5)


def test_skin_is_as_strong_as_the_specimens_that_it_was_fitted_to() -> None:
    # Ni Annaidh et al., J. Mech. Behav. Biomed. Mater. 5 (2012) 139: mean strength 21.6 +- 8.4 MPa at 54 %
    # on average.
    fit_start = {"shear_modulus": measured.skin.shear_modulus}
    fixed = {
        name: measured.skin.to_dict()[name]
        for name in ("fibre_ratio", "fibre_exponent", "dispersion", "bulk_modulus")
    }
    stress = []
    for angle in (
        measured.skin.angle,
        0.5 * np.pi - measured.skin.angle,
    ):  # along and across the Langer lines
        test = curves.uniaxial([1.27, 1.54], [1.0, 2.0])
        point = np.array(list(fit_start.values()))
        answer = Response(
            law_formula(measured.dispersed_fibres), test, list(fit_start), {**fixed, "angle": angle}, point
        )
        stress.append(answer(point)[0][:, 0])
    along, across = stress
    assert along[1] > 1.5 * across[1] and 13.2e6 < across[1] < 30e6 and across[0] < 0.2 * across[1]


@pytest.mark.parametrize("name", WANTED)
def test_a_body_of_it_takes_a_step(name: str) -> None:
    material, scene = measured.presets[name], stark.Scene()
    if isinstance(material, stark.SolidMaterial):
        scene.add_solid(stark.mesh.tet_box(0.01, 1), material, pins=[0, 1, 2])
    elif isinstance(material, stark.ShellMaterial):
        scene.add_cloth(stark.mesh.grid(0.02, 0.02, cells=2), material, pins=[0, 1])
    else:
        scene.add_rod([(0, 0, 0), (0.01, 0, 0), (0.02, 0, 0)], material, pins=[0])
    report = stark.Simulation(scene, **{"contact.enabled": False}).step()
    assert not report.failed
