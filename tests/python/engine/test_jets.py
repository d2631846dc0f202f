"""The oracle itself against 50 digits: derivatives of random formulas by differences of mpmath."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from _engine import Expected
from _formulas import Formula, formulas
from hypothesis import HealthCheck, Phase, given, reject, settings

FUNCTIONS = ["sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh"]


def each(function, count):
    """The function on arrays of mpmath's numbers; NaN where it is complex or has no value."""

    def real(*x):
        try:
            y = function(*x)
        except (ValueError, ZeroDivisionError):
            return mpmath.nan
        return y if isinstance(y, mpmath.mpf) else mpmath.nan

    return staticmethod(np.frompyfunc(real, count, 1))


class Digits:
    """The functions of formulas on arrays of mpmath's numbers."""

    fma = staticmethod(lambda a, b, c: a * b + c)
    square = staticmethod(lambda a: a * a)
    where = staticmethod(np.where)
    abs = each(mpmath.fabs, 1)
    minimum = staticmethod(lambda a, b: np.where(a < b, a, b))
    maximum = staticmethod(lambda a, b: np.where(a > b, a, b))
    pow = each(lambda a, b: mpmath.power(a, b) if b == int(b) or a >= 0 else mpmath.nan, 2)
    atan2 = each(mpmath.atan2, 2)


for _name in FUNCTIONS:
    setattr(Digits, _name, each(getattr(mpmath, _name), 1))


def value(formula: Formula, x: np.ndarray, i: int, j: int, a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpf:
    """The formula at x + a e_i + b e_j."""
    inputs = [mpmath.mpf(float(xi)) for xi in x]
    inputs[i] += a
    inputs[j] += b
    result = formula.of(Digits, [np.array([xi], dtype=object) for xi in inputs])
    return mpmath.mpf(np.ravel(result)[0])


@pytest.mark.slow
def test_oracle_against_differences() -> None:
    compared = 0

    @settings(
        max_examples=60,
        derandomize=True,
        database=None,
        deadline=None,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
    )
    @given(formulas(largest=12, most_unknowns=4))
    def run(formula: Formula) -> None:
        nonlocal compared
        # Ordinary points: differences are wrong where a condition changes.
        x = np.random.default_rng(formula.seed).normal(size=(formula.unknowns + formula.others, 4))
        oracle = Expected(formula, x)
        for element in np.flatnonzero(oracle.hessian.known.all((1, 2))):
            i, j = 0, formula.unknowns - 1
            with mpmath.workdps(50):
                try:
                    place = (formula, x[:, element], i, j)
                    exact = value(*place, 0, 0)
                    slope = mpmath.diff(lambda b: value(*place, 0, b), 0)  # noqa: B023
                    curvature = mpmath.diff(lambda a, b: value(*place, a, b), (0, 0), (1, 1))  # noqa: B023
                except ZeroDivisionError:
                    reject()
            for numbers, index, digits in (
                (oracle.value, (element,), exact),
                (oracle.gradient, (element, j), slope),
                (oracle.hessian, (element, i, j), curvature),
            ):
                error = abs(float(numbers.exact[index] - digits))
                # Differences of 50 digits are exact to about 1e-15 of the size of the function.
                assert error <= numbers.tolerance[index] + 1e-14 * abs(float(exact)), (element, index)
                compared += 1

    run()
    assert compared > 150
