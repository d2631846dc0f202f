"""What must hold for a formula: against the oracle, between back ends, between elements. `seen` counts what
was really checked, so that a test can tell that the oracle had something to say."""

from __future__ import annotations

from collections import Counter

import numpy as np
from _engine import Expected, Recorded, back_ends, evaluate, same_bits
from _formulas import Formula

from stark._core import symbolic as core
from stark.symbolic import ExpressionGraph

ELEMENTS = 64
JUDGED = 16  # elements that the oracle evaluates
BACK_ENDS = back_ends()

seen: Counter = Counter()


def check_orders(formula: Formula, x: np.ndarray, results: list) -> None:
    """Value, gradient and Hessian of the three orders against the oracle and each other."""
    expected = Expected(formula, x[:, :JUDGED])
    expected.value.check(results[0][0][:JUDGED, 0], "value")
    expected.gradient.check(results[1][1][:JUDGED, 0], "gradient")
    expected.gradient.check(results[2][1][:JUDGED, 0], "gradient beside the Hessian")
    hessian = results[2][2]
    expected.hessian.check(hessian[:JUDGED], "hessian")
    assert same_bits(hessian, np.swapaxes(hessian, 1, 2)), "the Hessian is not symmetric"
    assert same_bits(results[0][0], results[1][0]), "the value differs beside the gradient"
    assert same_bits(results[0][0], results[2][0]), "the value differs beside the Hessian"
    seen["elements"] += JUDGED
    seen["known Hessians"] += int(expected.hessian.known.all((1, 2)).sum())
    seen["curved"] += bool(expected.hessian.exact.any())


def check_lanes(function: core.ArrayFunction, x: np.ndarray, unknowns: int, results: list) -> None:
    """Elements do not depend on how many there are, on their order, or on what ran before."""
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
        recorded = Recorded(formula)  # anew: the same formula gives the same graph and bits
        function = recorded.compile(back_end)
        results = [evaluate(function, order, x, formula.unknowns) for order in range(3)]
        if reference is None:
            reference = results
            check_orders(formula, x, results)
        for order in range(3):
            same = zip(results[order], reference[order], strict=True)
            assert all(same_bits(a, b) for a, b in same if a is not None), f"{back_end}, order {order}"
        check_lanes(function, x, formula.unknowns, results)
    assert repr(recorded.result).startswith("Scalar(")
    listing = ExpressionGraph("formula", [recorded.result])
    assert str(listing).startswith("formula:")
    assert listing.dot().endswith("}")


def check_derivatives_as_expressions(formula: Formula) -> None:
    """Other ways to the same derivatives: as expressions by reverse sweeps, the Jacobian of the gradient by
    the cheaper of forward and reverse, and kernels without and with marked stages."""
    x = formula.inputs(JUDGED)
    n = formula.unknowns
    expected = Expected(formula, x)
    recorded = Recorded(formula)
    gradient = core.jacobian([recorded.result], recorded.unknowns)[0]
    rows = core.hessian(recorded.result, recorded.unknowns)
    outputs = [recorded.result, *gradient, *(entry for row in rows for entry in row)]
    values, _, _ = evaluate(recorded.compile("automatic", outputs), 0, x, n)
    expected.value.check(values[:, 0], "value")
    expected.gradient.check(values[:, 1 : 1 + n], "gradient as an expression")
    expected.hessian.check(values[:, 1 + n :].reshape(-1, n, n), "Hessian as an expression")
    _, jacobian, _ = evaluate(recorded.compile("automatic", gradient), 1, x, n)
    expected.hessian.check(jacobian.reshape(-1, n, n), "Jacobian of the gradient")
    for stages in ("none", "all"):
        function = Recorded(formula, stages).compile("automatic")
        _, gradient_values, hessian = evaluate(function, 2, x, n)
        expected.gradient.check(gradient_values[:, 0], f"gradient, {stages} marked")
        expected.hessian.check(hessian, f"Hessian, {stages} marked")
        seen[function.statistics(2)["algorithm"]] += 1
