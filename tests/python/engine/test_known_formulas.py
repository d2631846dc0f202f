"""Formulas that once went wrong or are easy to get wrong, checked like the random ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from _checks import check_derivatives_as_expressions, check_formula
from _engine import Recorded, evaluate
from _formulas import Formula, Operation


@dataclass(frozen=True)
class Written:
    """A formula written by hand, at points of a grid."""

    unknowns: int
    function: Callable[..., Any]
    values: tuple[float, ...] = (-2.0, -1.0, -0.5, -0.0, 0.0, 0.3, 1.0, 1.5, 3.0)
    others: int = 0

    def of(self, functions, inputs, on_value=lambda value, is_stage: None):
        return self.function(functions, *inputs)

    def inputs(self, elements: int) -> np.ndarray:
        n = self.unknowns + self.others
        grid = np.stack(np.meshgrid(*[self.values] * n, indexing="ij")).reshape(n, -1)
        order = np.random.default_rng(0).permutation(grid.shape[1])
        return grid[:, np.resize(order, elements)]


def drawn(unknowns: int, seed: int, *operations: tuple) -> Formula:
    return Formula(unknowns, 0, tuple(Operation(*operation) for operation in operations), seed)


def shared_root(f, x, y):
    """A root that is NaN below 1, under more different conditions than are kept apart."""
    root = f.sqrt(x - 1.0)
    total = x
    for k in range(20):
        total = total + f.where((x > 1.0 + 0.1 * k) & (y > 0.1 * k - 2.0), (k + 1.0) * root * y, x * y)
    return total


FORMULAS = {
    # Guards that were weakened, until a mask had no condition (internal error) or let NaN through.
    "guards of many branches, 1": drawn(
        5,
        23004,
        ("multiply", (0, 0, 0), 0),
        ("add", (0, 0, 0), 0),
        ("guarded_sqrt", (0, 0, 6), 0),
        ("negate", (6, 0, 0), 0),
        ("guarded_asin", (0, 0, 0), 0),
        ("add", (0, 0, 0), 0),
        ("where_nested", (0, 0, 5), 0),
        ("multiply_subtract", (0, 0, 4), 0),
        ("where_nested", (0, 0, 7), 0),
        ("add", (0, 0, 0), 0),
        ("where_not", (0, 8, 6), 0),
        ("add", (0, 5, 0), 0),
        ("add", (0, 0, 0), 0),
        ("add", (0, 0, 0), 0),
        ("add", (0, 5, 0), 0),
    ),
    "guards of many branches, 2": drawn(
        6,
        11663,
        ("add", (0, 0, 0), 0),
        ("negative_multiply_add", (0, 0, 0), 0),
        ("add", (0, 0, 0), 0),
        ("add", (4, 8, 0), 0),
        ("guarded_divide", (0, 7, 1), 0),
        ("guarded_nested", (15, 0, 0), 0),
        ("where_not", (0, 0, 1), 0),
        ("multiply", (0, 0, 0), 48),
        ("where_both", (0, 0, 4), 0),
        ("minimum", (3, 2, 0), 0),
        ("add", (0, 0, 0), 0),
        ("add", (0, 0, 0), 0),
        ("negate", (7, 0, 0), 0),
        ("minimum", (0, 2, 0), 0),
        ("add", (0, 0, 0), 0),
        ("add", (0, 0, 0), 0),
        ("where", (0, 6, 8), 0),
    ),
    "a root shared by many branches": Written(2, shared_root, (-2.0, 0.5, 1.0, 1.35, 2.95, 4.0)),
    "ties of minimum and maximum": Written(2, lambda f, x, y: f.minimum(x, y) * x + f.maximum(x * x, y)),
    "barrier": Written(
        1, lambda f, x: f.where(x < 1.0, -((x - 1.0) ** 2) * f.log(x), 0.0), (0.1, 0.5, 0.9, 1.0, 2.0)
    ),
    "norm at zero": Written(
        2, lambda f, x, y: f.where(x * x + y * y > 0.0, f.sqrt(x * x + y * y) * x, x), (-1.0, 0.0, 1e-9, 2.0)
    ),
    "condition by arithmetic": Written(2, lambda f, x, y: f.where(~((x < y) | (y < 0.0)), x / y, x * y)),
    "same operand twice": Written(
        1, lambda f, x: f.fma(x, x, x) + f.atan2(x, x + 4.0) + f.pow(x + 3.0, x + 3.0)
    ),
    "numbers as branches": Written(2, lambda f, x, y: f.where(x > 0.0, 3.0, x) * f.where(x > y, y, math.inf)),
    "constant": Written(1, lambda f, x: x - x + 2.0),
    "linear": Written(2, lambda f, x, y: 3.0 * x - y),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_known_formula(name: str) -> None:
    check_formula(FORMULAS[name])
    check_derivatives_as_expressions(FORMULAS[name])


def test_nan_in_a_comparison_is_false() -> None:
    formula = Written(
        1, lambda f, x: f.where(f.sqrt(x) >= 0.0, x, 2.0 * x) + f.where(~(f.sqrt(x) < 0.0), 10.0, 0.0)
    )
    x = np.array([[-4.0, 4.0]])
    value, gradient, hessian = evaluate(Recorded(formula).compile("automatic"), 2, x, 1)
    assert value[:, 0].tolist() == [2.0, 14.0]
    assert gradient[:, 0, 0].tolist() == [2.0, 1.0]
    assert not hessian.any()
