"""Properties that hold for every formula, on random ones that hypothesis draws and shrinks.

Each is compared with second-order jets whose tolerances come from error bounds (_jets.py), and its code with the
interpreter bit by bit. 500 formulas are drawn, always the same; STARK_NIGHTLY=1 draws 10 000 new ones."""

from __future__ import annotations

import os
from collections import Counter

import numpy as np
import pytest
from _engine import Expected, Recorded, back_ends, evaluate, same_bits
from _formulas import Formula, formulas
from hypothesis import HealthCheck, event, given, settings

from stark._core import symbolic as core
from stark.symbolic import ExpressionGraph

NIGHTLY = os.environ.get("STARK_NIGHTLY") == "1"
COUNT = 10_000 if NIGHTLY else 500
ELEMENTS = 64
JUDGED = 16  # elements that the oracle evaluates
BACK_ENDS = back_ends()

profile = settings(
    max_examples=COUNT,
    derandomize=not NIGHTLY,
    database=None,
    deadline=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)

seen: Counter = Counter()
operations: Counter = Counter()


def check_against_oracle(formula: Formula, x: np.ndarray, results: list) -> None:
    expected = Expected(formula, x[:, :JUDGED])
    value, gradient, _ = results[1]
    expected.value.check(results[0][0][:JUDGED, 0], "value")
    expected.gradient.check(gradient[:JUDGED, 0], "gradient")
    value, gradient, hessian = results[2]
    expected.gradient.check(gradient[:JUDGED, 0], "gradient beside the Hessian")
    expected.hessian.check(hessian[:JUDGED], "hessian")
    assert same_bits(hessian, np.swapaxes(hessian, 1, 2)), "the Hessian is not symmetric"
    assert same_bits(results[0][0], results[1][0]), "the value differs beside the gradient"
    assert same_bits(results[0][0], value), "the value differs beside the Hessian"
    seen["elements"] += JUDGED
    seen["known values"] += int(expected.value.known.sum())
    seen["known Hessians"] += int(expected.hessian.known.all((1, 2)).sum())


def check_lanes(function: core.ArrayFunction, x: np.ndarray, unknowns: int, results: list) -> None:
    """Elements do not depend on how many there are, in which order, or on what ran before."""
    for order, whole in enumerate(results):
        for count in (1, 7, 8, 9):
            part = evaluate(function, order, x[:, :count], unknowns)
            assert all(same_bits(a, b[:count]) for a, b in zip(part, whole, strict=True) if a is not None)
        turned = evaluate(function, order, x[:, ::-1], unknowns)
        assert all(same_bits(a, b[::-1]) for a, b in zip(turned, whole, strict=True) if a is not None)


def check_formula(formula: Formula) -> None:
    x = formula.inputs(ELEMENTS)
    reference = None
    for back_end in BACK_ENDS:
        recorded = Recorded(formula)
        function = recorded.compile(back_end)
        results = [evaluate(function, order, x, formula.unknowns) for order in range(3)]
        if reference is None:
            reference = results
            check_against_oracle(formula, x, results)
            seen[function.statistics(2)["algorithm"]] += 1
        for order in range(3):
            same = zip(results[order], reference[order], strict=True)
            assert all(same_bits(a, b) for a, b in same if a is not None), f"{back_end}, order {order}"
        check_lanes(function, x, formula.unknowns, results)
    assert repr(recorded.result).startswith("Scalar(")
    listing = ExpressionGraph("formula", [recorded.result])
    assert str(listing).startswith("formula:") and listing.dot().endswith("}")


@pytest.mark.slow
@profile
@given(formulas())
def test_derivatives_bits_and_lanes(formula: Formula) -> None:
    check_formula(formula)
    seen["formulas"] += 1
    for operation in formula.operations:
        operations[operation.name] += 1
