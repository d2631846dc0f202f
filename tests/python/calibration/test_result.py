"""What fits say of themselves: confidence intervals that hold, reports, plots, predictions of other tests."""

from __future__ import annotations

import copy
import pickle
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import stark
from stark import curves

GAMMA = np.linspace(0.1, 1.2, 15)


@stark.material
def quartic(
    F: stark.DeformationGradient,
    a: float = stark.parameter(2e4, unit="Pa", above=0.0),
    b: float = stark.parameter(2e3, unit="Pa", min=0.0),
    bulk: float = stark.parameter(1e6, unit="Pa", above=0.0),
) -> Any:
    """A law whose simple shear is tau = 2 a gamma + 4 b gamma^3."""
    J = stark.determinant(F)
    I1 = stark.trace(F.T @ F) * J ** (-2 / 3)
    return a * (I1 - 3.0) + b * (I1 - 3.0) ** 2 + 0.5 * bulk * (J - 1.0) ** 2


def noisy(rng: np.random.Generator, sigma: float = 300.0) -> stark.Fit:
    """Of the law with a = 2e4 Pa and b = 2e3 Pa, and noise of 300 Pa."""
    tau = 4e4 * GAMMA + 8e3 * GAMMA**3
    return stark.fit(
        quartic, curves.shear(GAMMA, tau + sigma * rng.normal(size=len(GAMMA))), fixed={"bulk": 1e9}
    )


def test_errors_are_those_of_linear_regression() -> None:
    fit = noisy(np.random.default_rng(1))
    design = np.stack([2.0 * GAMMA, 4.0 * GAMMA**3], axis=1)
    measured = fit.curves[0].curve.measured[:, 0]
    best, squares = np.linalg.lstsq(design, measured, rcond=None)[:2]
    covariance = squares[0] / (len(GAMMA) - 2) * np.linalg.inv(design.T @ design)
    np.testing.assert_allclose([fit["a"], fit["b"]], best, rtol=1e-8)
    np.testing.assert_allclose(fit.covariance, covariance, rtol=1e-8)
    assert fit.degrees_of_freedom == len(GAMMA) - 2
    assert fit.correlation[0, 1] == pytest.approx(
        covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    )
    low, high = fit.interval("a", 0.95)
    t = 2.160368656  # Student, 13 degrees of freedom, 97.5 %
    assert (high - low) / 2.0 == pytest.approx(t * fit.errors["a"], rel=1e-8) and (
        low + high
    ) / 2 == pytest.approx(fit["a"])


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng, held = np.random.default_rng(5), np.zeros((2, 2))
    count = 300
    for _ in range(count):
        fit = noisy(rng)
        for i, (name, truth) in enumerate((("a", 2e4), ("b", 2e3))):
            for j, confidence in enumerate((0.5, 0.95)):
                low, high = fit.interval(name, confidence)
                held[i, j] += low <= truth <= high
    # Three standard deviations of a binomial distribution: 26 around 150, 11.3 around 285.
    assert (np.abs(held[:, 0] - 0.5 * count) < 26).all() and (
        np.abs(held[:, 1] - 0.95 * count) < 11.4
    ).all(), held


def test_curves_say_how_well_they_are_described() -> None:
    fit = noisy(np.random.default_rng(2))
    of = fit.curves[0]
    residuals = of.predicted - of.curve.measured
    assert of.rms == pytest.approx(np.sqrt((residuals**2).mean())) and 150.0 < of.rms < 500.0
    assert of.largest == np.abs(residuals).max() and 0.999 < of.r_squared < 1.0
    np.testing.assert_array_equal(of.residuals, residuals)


def test_the_report_has_parameters_curves_and_warnings() -> None:
    text = str(noisy(np.random.default_rng(3)))
    assert text.startswith("quartic: 2 parameters from 1 curve, 15 measurements")
    assert re.search(r"^a +[12]\S* Pa +\d+\S* +\S+ to \S+$", text, re.MULTILINE)
    assert re.search(r"^bulk +1e\+09 Pa +fixed$", text, re.MULTILINE)
    assert re.search(r"^shear +15 ", text, re.MULTILINE) and "!" not in text
    with pytest.warns(stark.StarkWarning, match="do not determine 'bulk'"):
        fit = stark.fit(quartic, curves.shear(GAMMA, 4e4 * GAMMA + 8e3 * GAMMA**3))
    assert "! the curves do not determine 'bulk'" in str(fit)


def test_a_parameter_that_nothing_depends_on_leaves_the_errors_of_others() -> None:
    """One plane of bending says nothing of the other: its error is infinite, others have theirs."""
    random = np.random.default_rng(5)
    bent, strain = np.linspace(1.0, 20.0, 9), 0.01 * np.arange(1, 11)
    tests = [
        curves.uniaxial(1.0 + strain, 560.0 * strain + random.normal(scale=0.2, size=10)),
        curves.bending(bent, 1.3e-3 * bent + random.normal(scale=1e-4, size=9)),
        curves.torsion(bent, 9.8e-4 * bent + random.normal(scale=1e-4, size=9)),
    ]
    rod = stark.RodMaterial(youngs_modulus=1e7, radius=0.003)
    with pytest.warns(stark.StarkWarning, match="do not determine 'bending_stiffness_2'"):
        fit = stark.fit(rod, tests)
    known = stark.fit(rod, tests, fixed={"bending_stiffness_2": 1e-3})
    ratio = np.sqrt(25 / 24)  # of degrees of freedom: one parameter more
    assert fit.errors["bending_stiffness_2"] == np.inf
    for name, error in known.errors.items():
        assert fit.errors[name] == pytest.approx(ratio * error, rel=1e-3)
        assert fit.interval(name)[0] < known[name] < fit.interval(name)[1]


def test_other_tests_are_predicted() -> None:
    fit = noisy(np.random.default_rng(4), sigma=0.0)
    stretch = np.array([1.5, 2.0])
    predicted = fit.predict(curves.uniaxial(stretch))
    I1 = stretch**2 + 2.0 / stretch
    expected = 2.0 * (stretch - stretch**-2) * (2e4 + 2.0 * 2e3 * (I1 - 3.0))
    np.testing.assert_allclose(predicted[:, 0], expected, rtol=1e-3)  # compressible by K = 25000 mu
    with pytest.raises(stark.InvalidArgument, match="must be a curve of"):
        fit.predict(stretch)  # type: ignore[arg-type]
    sheet = stark.fit(
        stark.ShellMaterial,
        curves.uniaxial(stretch, stretch - 1.0),
        start={"youngs_modulus": 1.0},
        fixed={"poissons_ratio": 0.3},
    )
    with pytest.raises(stark.InvalidArgument, match="is of bending: must have been fitted, too"):
        sheet.predict(curves.bending(GAMMA))


@pytest.mark.parametrize(
    ("planned", "measured"),
    [
        (curves.uniaxial([1.2, 0.8]), curves.uniaxial([1.2, 0.8], [1.0, -1.0])),
        (curves.equibiaxial([1.2, 1.4]), curves.equibiaxial([1.2, 1.4], [1.0, 2.0])),
        (curves.planar([1.2, 1.4]), curves.planar([1.2, 1.4], [1.0, 2.0])),
        (
            curves.biaxial([1.2, 1.4], [1.1, 1.2]),
            curves.biaxial([1.2, 1.4], [1.1, 1.2], [1.0, 2.0], [1.0, 1.0]),
        ),
        (curves.shear([-0.2, 0.4]), curves.shear([-0.2, 0.4], [-1.0, 2.0])),
        (curves.volumetric([0.9, 0.8]), curves.volumetric([0.9, 0.8], [1.0, 2.0])),
        (
            curves.relaxation([0.1, 1.0], gamma=0.2),
            curves.relaxation([0.1, 1.0], [2.0, 1.0], gamma=0.2),
        ),
    ],
)
def test_a_test_to_be_predicted_needs_no_stresses(planned: curves.Curve, measured: curves.Curve) -> None:
    fit = noisy(np.random.default_rng(4), sigma=0.0)
    assert np.array_equal(fit.predict(planned), fit.predict(measured))
    assert measured.is_measured and not planned.is_measured
    with pytest.raises(stark.InvalidArgument, match="stress_1 is missing: must be given where stress_2 is"):
        curves.biaxial([1.2, 1.4], [1.1, 1.2], stress_2=[1.0, 2.0])
    with pytest.raises(stark.InvalidArgument, match="was not measured: must have stresses to be fitted"):
        stark.fit(quartic, [measured, planned])


def test_materials_simulate_with_what_was_fitted() -> None:
    fit = stark.fit(
        stark.ShellMaterial,
        [curves.uniaxial(1.0 + GAMMA / 100.0, 5e4 * GAMMA / 100.0), curves.bending(GAMMA, 2e-6 * GAMMA)],
        start={"youngs_modulus": 1e4, "flexural_rigidity": 1e-5},
        fixed={"poissons_ratio": 0.3},
    )
    cloth = fit.material(density=0.2, thickness=3e-4, name="sheet")
    known = stark.fit(
        stark.ShellMaterial,
        [of.curve for of in fit.curves],
        start={"youngs_modulus": 1e4},
        fixed={"poissons_ratio": 0.3, "flexural_rigidity": 2e-6},
    )
    assert known["flexural_rigidity"] == known.material().flexural_rigidity == 2e-6
    assert re.search(r"^flexural_rigidity +2e-06 N m +fixed$", str(known), re.MULTILINE)
    assert repr(known).startswith("<stark.Fit of 'membrane_neo_hookean': youngs_modulus = 5.03")
    assert isinstance(cloth, stark.ShellMaterial) and cloth.flexural_rigidity == pytest.approx(2e-6)
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), cloth, pins=[0])
    assert not stark.Simulation(scene).step().failed


def test_a_plot_is_a_picture_of_all_curves(tmp_path: Path) -> None:
    fit = noisy(np.random.default_rng(6))
    path = fit.plot(tmp_path / "fit.svg")
    tree = ElementTree.parse(path)
    circles = tree.findall(".//{http://www.w3.org/2000/svg}circle")
    assert len(circles) == len(GAMMA) and len(tree.findall(".//{http://www.w3.org/2000/svg}polyline")) == 1
    box = [float(x) for x in tree.getroot().attrib["viewBox"].split()]
    assert all(0 < float(c.attrib["cx"]) < box[2] and 0 < float(c.attrib["cy"]) < box[3] for c in circles)
    with pytest.raises(stark.InvalidArgument, match="must end in"):
        fit.plot(tmp_path / "fit.png")
    with pytest.raises(stark.Error, match="cannot be written"):
        fit.plot(tmp_path / "nowhere" / "fit.svg")


def test_unknown_names_are_refused() -> None:
    fit = noisy(np.random.default_rng(7))
    for call, text in (
        (lambda: fit["c10"], "no parameter 'c10': must be a, b, bulk"),
        (lambda: fit.interval("bulk"), "'bulk' was not fitted: must be a, b"),
        (lambda: fit.interval("a", 95.0), "confidence = 95: must be between 0 and 1"),
    ):
        with pytest.raises(stark.InvalidArgument, match=re.escape(text)):
            call()


@pytest.mark.parametrize("law", [quartic, stark.SolidMaterial, stark.materials.silicone, quartic(a=1e4)])
def test_fits_may_be_pickled_and_copied(law: Any) -> None:
    tau = 4e4 * GAMMA
    start = {"youngs_modulus": 1e5} if law is stark.SolidMaterial else None
    fixed = (
        {"poissons_ratio": 0.45} if law in (stark.SolidMaterial, stark.materials.silicone) else {"bulk": 1e9}
    )
    fit = stark.fit(law, curves.shear(GAMMA, tau), start=start, fixed=fixed)
    for same in (pickle.loads(pickle.dumps(fit)), copy.deepcopy(fit)):
        assert str(same) == str(fit) and same.values == fit.values
        assert np.array_equal(
            same.predict(curves.shear([0.5, 0.6])),
            fit.predict(curves.shear([0.5, 0.6])),
        )
        assert same.material(density=900.0) == fit.material(density=900.0)
