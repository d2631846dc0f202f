"""Fits recover the parameters that synthetic curves were made with, from starts that are far off, and
refuse bad input before anything is computed."""

from __future__ import annotations

import dataclasses
import re
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark
from stark import curves
from stark.calibration.laws import law_formula
from stark.calibration.response import Response

STRETCH = np.linspace(1.05, 2.0, 9)
PATH = np.exp(np.concatenate([np.linspace(0.0, 0.02, 11)[1:], np.linspace(0.02, -0.015, 15)[1:]]))
RECOVERED = 1e-6  # relative: the search stops by rounding, at about 1e-9


def rubber(kind: Callable[..., curves.Curve] = curves.uniaxial, **more: Any) -> curves.Curve:
    """Of an incompressible Mooney-Rivlin solid with c10 = 2e5 Pa and c01 = 5e4 Pa [Rivlin 1948]."""
    if kind is curves.equibiaxial:
        return kind(STRETCH, 2.0 * (STRETCH - STRETCH**-5) * (2e5 + 5e4 * STRETCH**2), **more)
    return kind(STRETCH, 2.0 * (STRETCH - STRETCH**-2) * (2e5 + 5e4 / STRETCH), **more)


def answered(law: Any, test: curves.Curve, **values: Any) -> curves.Curve:
    """The test with the answer of a law in place of measurements."""
    free = [name for name, value in values.items() if np.ndim(value) == 0]
    fixed = {name: value for name, value in values.items() if name not in free}
    point = np.array([values[name] for name in free])
    stress = Response(law_formula(law), test, free, fixed, point)(point)[0]
    return dataclasses.replace(test, measured=stress)


def blank(kind: str, *imposed: Any, **more: Any) -> curves.Curve:
    values = np.stack(imposed, axis=1)
    columns = 2 if kind == "biaxial" else 1
    return curves.Curve(kind, values, np.ones((len(values), columns)), more.pop("times", None), kind, **more)


def test_rubber_from_its_closed_form() -> None:
    both = [rubber(), rubber(curves.equibiaxial)]
    fit = stark.fit(
        stark.materials.mooney_rivlin, both, start={"c10": 1e4, "c01": 1e6}, fixed={"bulk_modulus": 1e12}
    )
    assert fit.converged and fit.free == ("c10", "c01")
    # What is left is the compressibility: 2.5e5 / 1e12.
    assert abs(fit["c10"] / 2e5 - 1.0) < 1e-5 and abs(fit["c01"] / 5e4 - 1.0) < 1e-5


def maxwell() -> Any:
    return stark.generalized_maxwell(
        shear_modulus=5e4, bulk_modulus=2e6, moduli=[1e5, 1e5], times=[0.1, 5.0], density=1100.0
    )


TIMES = np.geomspace(0.01, 100.0, 25)
CASES: dict[str, tuple[Any, list[curves.Curve], dict[str, float], dict[str, Any], dict[str, Any]]] = {
    # law, tests, values, starts, fixed
    "mooney_rivlin": (
        stark.materials.mooney_rivlin,
        [blank("uniaxial", STRETCH), blank("equibiaxial", STRETCH),
         blank("volumetric", np.linspace(0.9, 0.99, 4))],
        {"c10": 2e5, "c01": 5e4, "bulk_modulus": 1e8}, {"c10": 1e4, "c01": 1e6, "bulk_modulus": 1e7}, {},
    ),
    "stable_neo_hookean": (
        stark.SolidMaterial, [blank("uniaxial", STRETCH), blank("planar", STRETCH)],
        {"youngs_modulus": 3e4, "poissons_ratio": 0.31}, {"youngs_modulus": 1e6, "poissons_ratio": 0.1}, {},
    ),
    "membrane": (
        stark.ShellMaterial, [blank("biaxial", STRETCH, STRETCH**0.5)],
        {"youngs_modulus": 3e4, "poissons_ratio": 0.31}, {"youngs_modulus": 1e6, "poissons_ratio": 0.1}, {},
    ),
    "woven cloth": (
        stark.materials.orthotropic_cloth,
        [blank("biaxial", 1.0 + 0.05 * STRETCH, 1.1 - 0.03 * STRETCH), blank("shear", STRETCH / 10.0),
         blank("bending", STRETCH)],
        {"warp_modulus": 2e6, "weft_modulus": 5e5, "shear_modulus": 1e4, "poissons_ratio": 0.2,
         "flexural_rigidity": 3e-6},
        {"warp_modulus": 1e6, "weft_modulus": 1e6, "shear_modulus": 1e5, "poissons_ratio": 0.1,
         "flexural_rigidity": 1e-4}, {},
    ),
    "fibres": (
        stark.materials.fiber_reinforced,
        [blank("uniaxial", np.linspace(1.01, 1.4, 12)), blank("shear", STRETCH / 3.0)],
        {"youngs_modulus": 1e5, "poissons_ratio": 0.4, "fiber_stiffness": 2e5, "fiber_exponent": 1.5},
        {"youngs_modulus": 5e4, "poissons_ratio": 0.3, "fiber_stiffness": 1e5, "fiber_exponent": 1.0},
        {"fiber_direction": np.array([0.8, 0.6, 0.0])},
    ),
    "wire": (
        stark.RodMaterial, [blank("uniaxial", STRETCH), blank("bending", STRETCH), blank("torsion", STRETCH)],
        {"axial_stiffness": 10.0, "bending_stiffness_1": 2e-4, "torsional_stiffness": 1e-4},
        {"axial_stiffness": 1.0, "bending_stiffness_1": 1.0, "torsional_stiffness": 1.0},
        {"bending_stiffness_2": 1.0},
    ),
    "cyclic plasticity": (
        stark.j2_plasticity, [blank("uniaxial", PATH)],
        {"shear_modulus": 8e10, "yield_stress": 2.4e8, "hardening_modulus": 3e9, "kinematic_modulus": 2e9},
        {"shear_modulus": 6e10, "yield_stress": 4e8, "hardening_modulus": 1e9, "kinematic_modulus": 5e8},
        {"bulk_modulus": 1.7e11, "saturation_increase": 0.0, "saturation_rate": 1.0},
    ),
    "saturation": (
        stark.j2_plasticity, [blank("uniaxial", np.exp(np.linspace(0.0, 0.3, 31)[1:]))],
        {"yield_stress": 4.5e8, "hardening_modulus": 1.3e8, "saturation_increase": 2.65e8,
         "saturation_rate": 16.93},
        {"yield_stress": 3e8, "hardening_modulus": 5e8, "saturation_increase": 1e8, "saturation_rate": 5.0},
        {"bulk_modulus": 1.642e11, "shear_modulus": 8.02e10, "kinematic_modulus": 0.0},
    ),
    "Prony series": (
        maxwell(), [curves.relaxation(TIMES, 1.0 + TIMES, stretch=1.2)],
        {"shear_modulus": 1e5, "modulus_1": 4e4, "time_1": 0.5, "modulus_2": 2e4, "time_2": 20.0}, {},
        {"bulk_modulus": 2e6},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_synthetic_curves_give_their_parameters_back(case: str) -> None:
    law, tests, values, start, fixed = CASES[case]
    names = set(values) - ({"flexural_rigidity"} if "flexural_rigidity" in values else set())
    made = []
    for test in tests:
        own = values if test.kind == "bending" else {k: v for k, v in values.items() if k in names}
        made.append(answered(law, test, **own, **fixed))
    fit = stark.fit(law, made, start=start, fixed=fixed)
    assert fit.converged
    for name, value in values.items():
        assert abs(fit[name] / value - 1.0) < RECOVERED, (name, fit[name])
    assert all(of.r_squared > 1.0 - 1e-12 for of in fit.curves)


def test_a_law_of_the_user() -> None:
    @stark.material
    def quartic(
        F: stark.DeformationGradient,
        a: float = stark.parameter(1e3, unit="Pa", above=0.0),
        b: float = stark.parameter(1e3, unit="Pa", min=0.0),
        bulk: float = stark.parameter(1e6, unit="Pa", above=0.0),
    ) -> Any:
        J = stark.determinant(F)
        I1 = stark.trace(F.T @ F) * J ** (-2 / 3)
        return a * (I1 - 3.0) + b * (I1 - 3.0) ** 2 + 0.5 * bulk * (J - 1.0) ** 2

    gamma = np.linspace(0.1, 1.0, 6)
    # I1 - 3 = gamma^2 in simple shear; starts are the defaults.
    fit = stark.fit(
        quartic, curves.shear(gamma, 2.0 * 3e4 * gamma + 4.0 * 7e3 * gamma**3), fixed={"bulk": 1e6}
    )
    assert abs(fit["a"] / 3e4 - 1.0) < RECOVERED and abs(fit["b"] / 7e3 - 1.0) < RECOVERED
    material = fit.material(density=1100.0, name="gum")
    assert material.law.name == "quartic" and material.a == fit["a"] and material.density == 1100.0
    again = stark.fit(material, curves.shear(gamma, 1e5 * gamma), fixed={"b": 0.0, "bulk": 1e6})
    assert abs(again["a"] / 5e4 - 1.0) < RECOVERED and again.material().density == 1100.0


def test_noise_of_known_size_weighs_curves() -> None:
    wrong = curves.planar(STRETCH, 3e5 * (STRETCH - 1.0), sigma=1e9)  # as good as not measured
    with pytest.warns(stark.StarkWarning, match="explains 0% of the variance of the curve 'planar'"):
        fit = stark.fit(
            stark.materials.mooney_rivlin,
            [rubber(sigma=1.0), wrong],
            start={"c10": 1e5, "c01": 1e5},
            fixed={"bulk_modulus": 1e12},
        )
    assert abs(fit["c10"] / 2e5 - 1.0) < 1e-4


def test_bounds_hold_and_are_reported() -> None:
    with pytest.warns(stark.StarkWarning, match="'c10' = 1e\\+05 ended at a bound"):
        fit = stark.fit(
            stark.materials.mooney_rivlin,
            rubber(),
            start={"c10": 5e4, "c01": 5e4},
            fixed={"bulk_modulus": 1e9},
            bounds={"c10": (0.0, 1e5)},
        )
    assert 0.99e5 < fit["c10"] <= 1e5 and np.isnan(fit.errors["c10"]) and np.isfinite(fit.errors["c01"])


def test_parameters_that_curves_do_not_determine_are_named() -> None:
    start = {"c10": 1e5, "c01": 1e5, "bulk_modulus": 1e9}
    with pytest.warns(stark.StarkWarning) as caught:
        fit = stark.fit(stark.materials.mooney_rivlin, rubber(), start=start)
    texts = [str(warning.message) for warning in caught]
    assert any("do not determine 'bulk_modulus'" in text and "volumetric" in text for text in texts)
    assert any("'bulk_modulus'" in text and "of the largest stress" in text for text in fit.warnings)
    gamma = np.array([0.1, 0.2, 0.4, 0.6])
    with pytest.warns(stark.StarkWarning, match="only a combination of 'c10', 'c01'"):
        stark.fit(
            stark.materials.mooney_rivlin, curves.shear(gamma, 5e5 * gamma), start={"c10": 1e5, "c01": 1e5},
            fixed={"bulk_modulus": 1e9},
        )  # fmt: skip


def test_a_search_that_ends_far_from_the_curve_says_so() -> None:
    law, tests, values, start, fixed = CASES["cyclic plasticity"]
    made = answered(law, tests[0], **values, **fixed)
    with pytest.warns(stark.StarkWarning) as caught:
        stark.fit(law, made, start={**start, "yield_stress": 1e10}, fixed=fixed)  # it never yields
    texts = " ".join(str(warning.message) for warning in caught)
    assert "of the variance of the curve 'uniaxial': it is not that of the material" in texts
    assert "do not determine 'yield_stress'" in texts and "do not determine 'hardening_modulus'" in texts


def test_a_search_that_was_cut_off_says_so() -> None:
    with pytest.warns(stark.StarkWarning, match="not converged in 1 evaluations; raise max_evaluations"):
        fit = stark.fit(
            stark.materials.mooney_rivlin,
            rubber(),
            start={"c10": 1.0, "c01": 1e7},
            fixed={"bulk_modulus": 1e9},
            max_evaluations=1,
        )
    assert not fit.converged and len(fit.warnings) == 1 and "! not converged" in str(fit)


def test_a_search_goes_back_from_where_there_are_no_derivatives() -> None:
    """Noise about zero leads to moduli of nearly nothing beside a bulk modulus of 1 GPa."""
    noise = np.random.default_rng(0).normal(size=12)
    curve = curves.uniaxial(np.linspace(1.05, 2.0, 12), noise)
    with pytest.warns(stark.StarkWarning, match="of the variance of the curve 'uniaxial'"):
        fit = stark.fit(stark.materials.mooney_rivlin, curve, start={"c10": 1e4, "c01": 1e3}, fixed=FIXED)
    assert abs(fit["c10"]) < 10.0 and abs(fit["c01"]) < 10.0


def test_the_section_of_a_rod_is_where_a_fit_of_it_starts() -> None:
    wire = stark.RodMaterial(youngs_modulus=1e9, radius=1e-3, density=8000.0)
    fixed = {
        name: wire.section[name] for name in ("axial_stiffness", "bending_stiffness_2", "torsional_stiffness")
    }
    fit = stark.fit(wire, curves.bending(STRETCH, 5e-4 * STRETCH), fixed=fixed)
    assert fit.material().section["bending_stiffness_1"] == pytest.approx(5e-4, rel=RECOVERED)
    assert fit.material().density == 8000.0


def test_the_same_curves_give_the_same_bits() -> None:
    def values() -> tuple[Any, ...]:
        fit = stark.fit(
            stark.materials.mooney_rivlin,
            rubber(),
            start={"c10": 1e5, "c01": 1e5},
            fixed={"bulk_modulus": 1e9},
        )
        return fit["c10"], fit["c01"], fit.covariance.tobytes()

    assert values() == values()


def test_scipy_is_asked_for_by_the_name_of_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy", None)
    with pytest.raises(ImportError, match=re.escape("pip install 'stark-sim[fit]'")):
        stark.fit(stark.materials.mooney_rivlin, rubber())


FIXED = {"bulk_modulus": 1e9}
START = {"c10": 1e5, "c01": 1e5}
REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "no law": ({"law": "mooney_rivlin"}, "law = 'mooney_rivlin': must be a law or a material"),
    "maxwell": ({"law": stark.generalized_maxwell}, "the number of its branches must be known"),
    "damping": (
        {"law": stark.materials.solid_laws["solid_damping"]},
        "law 'solid_damping': depends on the strain at the start of the step",
    ),
    "no curve": ({"curves": [1.0]}, "must be a curve of stark.curves"),
    "no start": (
        {"start": {"c10": 1e5}}, "no start for 'c01' [Pa]: must be given; the curve 'uniaxial' starts with"
    ),
    "unknown": (
        {"start": {**START, "c20": 1.0}}, "start has 'c20', which is no parameter of 'mooney_rivlin'"
    ),
    "rigidity": ({"start": {**START, "flexural_rigidity": 1.0}}, "bending curves determine it"),
    "both": ({"start": {**START, "bulk_modulus": 1e9}}, "'bulk_modulus' is in start and in fixed"),
    "range": ({"fixed": {"bulk_modulus": -1.0}}, "fixed['bulk_modulus'] = -1 Pa: must be > 0"),
    "start range": ({"start": {"c10": 0.0, "c01": 0.0}}, "start['c10'] = 0 Pa: must be > 0"),
    "not a number": ({"start": {"c10": "a", "c01": 0.0}}, "start['c10'] = 'a': must be a number"),
    "nan": ({"fixed": {"bulk_modulus": np.nan}}, "fixed['bulk_modulus'] = nan Pa: must be > 0"),
    "all fixed": ({"start": {}, "fixed": {**START, **FIXED}}, "all parameters of 'mooney_rivlin' are fixed"),
    "few points": (
        {"curves": curves.uniaxial([1.1, 1.2], [1e5, 2e5])},
        "2 measurements for 2 parameters (c10, c01): must be more measurements than parameters",
    ),
    "bounds": ({"bounds": {"c10": 3.0}}, "bounds['c10'] = 3.0: must be (lowest, highest)"),
    "empty bounds": ({"bounds": {"c10": (3.0, 2.0)}}, "bounds['c10'] = (3.0, 2.0): must leave a range"),
    "bounds of nan": ({"bounds": {"c10": (np.nan, 1e6)}}, "bounds['c10'] = (nan, 1000000.0): must leave"),
    "sheet that yields": (
        {"law": stark.materials.cotton.replace(yield_stress=1e6), "start": {}, "fixed": {}},
        "yield_stress = 1e+06: must be elastic",
    ),
    "wire that yields": (
        {"law": stark.materials.steel_wire.replace(yield_torque=1.0), "start": {}, "fixed": {}},
        "use .replace(yield_torque=0)",
    ),
    "outside": ({"bounds": {"c10": (1.0, 2.0)}}, "start['c10'] = 100000: must be within its bounds, 1 to 2"),
    "start is no dict": ({"start": [1.0]}, "start = [1.0]: must be a dict"),
    "evaluations": ({"max_evaluations": 0}, "max_evaluations = 0: must be a whole number >= 1"),
    "one sigma": (
        {"curves": [rubber(sigma=1.0), rubber()]}, "curve 'uniaxial 2' has no sigma, and others have"
    ),
    "bent solid": (
        {"curves": curves.bending(STRETCH, STRETCH)}, "is of the kind bending, the law one of solids"
    ),
    "sheared rod": (
        {"law": stark.RodMaterial(), "curves": curves.shear(STRETCH, STRETCH), "start": {}, "fixed": {}},
        "is of the kind shear, the law one of rods",
    ),
    "no times": (
        {"law": maxwell(), "start": {}, "fixed": {}}, "curve 'uniaxial' has no times, on which the law"
    ),
    "direction": (
        {"law": stark.materials.fiber_reinforced, "start": {}, "fixed": {}},
        "'fiber_direction' is made of 3 numbers, which are not fitted: must be in fixed",
    ),
    "values of elements": (
        {"law": stark.materials.soft_rubber.replace(youngs_modulus=[1e4, 2e4]), "start": {}, "fixed": {}},
        "has a value for each element: must be one value",
    ),
    "no state": (
        {"law": stark.materials.st_venant_kirchhoff,
         "curves": curves.equibiaxial([1.5, 2.5, 4.0], [1.0, 2.0, 3.0]),
         "start": {"youngs_modulus": 1.0, "poissons_ratio": 0.49}, "fixed": {}},
        "has no state without lateral stress at point",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_refused(case: str) -> None:
    changes, text = REFUSED[case]
    given = {
        "law": stark.materials.mooney_rivlin,
        "curves": rubber(),
        "start": START,
        "fixed": FIXED,
        **changes,
    }
    with pytest.raises(stark.InvalidArgument, match=re.escape(text)):
        stark.fit(given.pop("law"), given.pop("curves"), **given)


@stark.material
def standard_solid(
    F: stark.DeformationGradient,
    h: stark.TimeStep,
    mu: float = stark.parameter(1e4, unit="Pa", above=0.0),
    branch: float = stark.parameter(1e4, unit="Pa", above=0.0),
    tau: float = stark.parameter(0.05, unit="s", above=0.0),
    bulk: float = stark.parameter(1e5, unit="Pa", above=0.0),
    flow: stark.Mat3 = stark.internal(0.0),
):
    """A standard linear solid by implicit Euler: of first order in the time step."""
    E = 0.5 * (F.T @ F - stark.identity(3))
    r, trial, J = h / tau, E - flow, stark.determinant(F)
    psi = mu * stark.squared_norm(E) + 0.5 * bulk * (J - 1.0) ** 2
    return psi + branch / (1.0 + r) * stark.squared_norm(trial), {"flow": flow + r / (1.0 + r) * trial}


def test_substeps_take_the_bias_out_of_fits_of_laws_of_first_order() -> None:
    times = np.geomspace(0.01, 2.0, 40)
    stress = 0.01 * (1e4 + 2e4 * np.exp(-times / 0.2))
    off = {}
    for substeps in (1, 10):
        curve = curves.relaxation(times, stress, gamma=0.01, substeps=substeps)
        found = stark.fit(standard_solid, curve, fixed={"bulk": 1e5})
        off[substeps] = [abs(found["mu"] / 1e4 - 1.0), abs(found["branch"] / 2e4 - 1.0),
                         abs(found["tau"] / 0.2 - 1.0)]  # fmt: skip
    # docs/fitting.md states these.
    assert max(off[1]) == pytest.approx(0.031, abs=0.0015)
    assert max(off[10]) == pytest.approx(0.003, abs=0.0005)
