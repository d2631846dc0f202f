"""Measured curves: what they hold, the path of a test, and input that is refused with what to do about it."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark
from stark import curves

STRETCH = np.linspace(1.0, 2.0, 5)
STRESS = 1e5 * (STRETCH - 1.0)


def test_a_curve_holds_what_it_was_given() -> None:
    curve = curves.biaxial(STRETCH, STRETCH**0.5, STRESS, 2.0 * STRESS, sigma=10.0, name="sheet")
    assert curve.kind == "biaxial" and curve.name == "sheet" and curve.sigma == 10.0 and len(curve) == 5
    np.testing.assert_array_equal(curve.imposed, np.stack([STRETCH, STRETCH**0.5], axis=1))
    np.testing.assert_array_equal(curve.measured, np.stack([STRESS, 2.0 * STRESS], axis=1))
    assert repr(curve) == "<stark.curves.Curve 'sheet': biaxial, 5 points>"
    assert curve.scale == 2e5 and curve.at_rest == 1.0 and curve.times is None


def test_the_path_starts_at_rest_and_is_divided_into_substeps() -> None:
    values, spans, shown = curves.uniaxial([1.2, 1.1], [1.0, 0.5], times=[2.0, 3.0], substeps=2).steps()
    np.testing.assert_allclose(values[:, 0], [1.1, 1.2, 1.15, 1.1], rtol=1e-15)
    np.testing.assert_allclose(spans, [1.0, 1.0, 0.5, 0.5], rtol=1e-15)
    assert shown.tolist() == [False, True, False, True]


def test_without_times_each_point_is_a_second_after_the_one_before() -> None:
    assert curves.shear([0.1, 0.2], [1.0, 2.0]).steps()[1].tolist() == [1.0, 1.0]


def test_a_relaxation_is_a_step_and_then_constant() -> None:
    curve = curves.relaxation([0.5, 1.0, 4.0], [3.0, 2.0, 1.0], stretch=1.3, ramp=0.1)
    values, spans, shown = curve.steps()
    np.testing.assert_allclose(values[:, 0], 1.3)
    np.testing.assert_allclose(spans, [0.1, 0.4, 0.5, 3.0], rtol=1e-12)
    assert shown.tolist() == [False, True, True, True]
    early = curves.uniaxial([1.0, 1.1], [0.0, 1.0], times=[0.0, 2.0]).steps()[1]
    assert 0.0 < early[0] < 1e-8 and abs(early[1] - 2.0) < 1e-8  # rates need a duration
    finer = curves.relaxation([0.5, 1.0], [3.0, 2.0], stretch=1.3, ramp=0.1, substeps=2).steps()
    np.testing.assert_allclose(finer[0][:, 0], [1.15, *[1.3] * 5])
    np.testing.assert_allclose(finer[1], [0.05, 0.05, 0.2, 0.2, 0.25, 0.25], rtol=1e-12)
    assert finer[2].tolist() == [False, False, False, True, False, True]
    at_once = curves.relaxation([0.0, 1.0], [3.0, 2.0], gamma=0.2)
    assert at_once.kind == "shear" and at_once.steps()[2].tolist() == [True, True]
    assert at_once.steps()[1][0] < 1e-8  # imposed at once: far below the first time


def test_curves_of_the_same_name_are_numbered() -> None:
    named = curves.require_curves([curves.uniaxial(STRETCH, STRESS), curves.uniaxial(STRETCH, STRESS)])
    assert [curve.name for curve in named] == ["uniaxial 1", "uniaxial 2"]


NAN = [*STRESS[:-1], np.nan]
CASES: dict[str, tuple[Callable[[], Any], str]] = {
    "nan": (lambda: curves.uniaxial(STRETCH, NAN), "stress[4] = nan: must be finite"),
    "infinite": (lambda: curves.shear([0.0, np.inf], [0.0, 1.0]), "gamma[1] = inf: must be finite"),
    "text": (lambda: curves.uniaxial(["a", "b"], [1, 2]), "must be of real numbers"),
    "table": (lambda: curves.uniaxial(np.ones((2, 2)), [1, 2]), "has the shape (2, 2): must be (n,)"),
    "lengths": (lambda: curves.uniaxial(STRETCH, STRESS[:-1]), "5 of stretch, 4 of stress"),
    "one point": (lambda: curves.uniaxial([1.1], [1.0]), "1 points: must be 2 or more"),
    "nothing measured": (lambda: curves.uniaxial(STRETCH, 0.0 * STRESS), "stress is 0 at all points"),
    "strain from 0": (
        lambda: curves.uniaxial(STRETCH - 1.0, STRESS),
        "stretch[0] = 0: must be > 0, and 1 at rest; of a strain give 1 + strain",
    ),
    "strain": (
        lambda: curves.uniaxial([0.1, 0.2, 0.3], [1.0, 2.0, 3.0]),
        "stretch[0] = 0.1 with stress[0] = 1: must be on the same side of rest",
    ),
    "percentage": (lambda: curves.uniaxial([5.0, 60.0], [1.0, 2.0]), "1 + percentage / 100"),
    "shear in percent": (lambda: curves.shear([5.0, 60.0], [1.0, 2.0]), "give percentage / 100"),
    "sign": (lambda: curves.shear([0.1, 0.2], [-1.0, -2.0]), "look at the signs"),
    "compression given as positive": (
        lambda: curves.planar([0.9, 0.8], [1.0, 2.0]), "must be on the same side of rest"
    ),
    "unsorted times": (
        lambda: curves.relaxation([0.0, 2.0, 1.0], [3, 2, 1], stretch=1.1),
        "times[2] = 1 s comes after 2 s: must increase",
    ),
    "negative time": (
        lambda: curves.uniaxial([1.1, 1.2], [1, 2], times=[-1.0, 1.0]), "times[0] = -1 s: must be >= 0"
    ),
    "both": (lambda: curves.relaxation([0, 1], [2, 1], stretch=1.1, gamma=0.1), "give one of the two"),
    "rest": (lambda: curves.relaxation([0, 1], [2, 1], stretch=1.0), "must differ from 1, which is rest"),
    "ramp": (lambda: curves.relaxation([0, 1], [2, 1], gamma=0.1, ramp=-1.0), "ramp = -1 s: must be >= 0"),
    "sigma": (lambda: curves.uniaxial(STRETCH, STRESS, sigma=0.0), "sigma = 0: must be > 0"),
    "substeps": (lambda: curves.uniaxial(STRETCH, STRESS, substeps=0), "substeps = 0: must be a whole"),
    "substeps of a relaxation": (
        lambda: curves.relaxation([0, 1], [2, 1], gamma=0.1, substeps=1.5),  # type: ignore[arg-type]
        "substeps = 1.5: must be a whole",
    ),
    "axis": (lambda: curves.bending([1, 2], [1, 2], axis=3), "axis = 3: must be 1 or 2"),
    "no curves": (lambda: curves.require_curves([]), "must be a curve of stark.curves"),
    "an array": (lambda: curves.require_curves(STRESS), "must be a curve of stark.curves"),  # type: ignore[arg-type]
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_bad_data_is_refused_with_a_remedy(case: str) -> None:
    make, text = CASES[case]
    with pytest.raises(stark.InvalidArgument, match=re.escape(text)):
        make()
