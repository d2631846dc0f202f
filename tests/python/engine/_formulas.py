"""Random formulas: what hypothesis draws, and how it becomes an expression.

A formula is a list of operations on earlier values. It runs on any scalars that have the operators and
functions of stark.symbolic: on the engine's to be recorded, on jets (_jets.py) to be evaluated by the oracle.
Domains are guarded by `where` (the branch that is not taken is NaN or infinite), by construction, or not at
all."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

CONSTANTS = [0.0, -0.0, 1.0, -1.0, 2.0, 0.5, -0.75, 3.0, 1.0 / 3.0, math.pi, 0.1, 1e-3, 1e3, 1e-8, 1e8]
EXTREME = [1e-300, 1e300, 5e-324, 1.7976931348623157e308, 2.0**-1022, -(2.0**1023), 1e16, 1e-16]
EXPONENTS = [2, 3, -1, -2, 4, 5, 7, 0, 1, 9, -3, 0.5, 1.5, -0.5, 2.5, 1.0 / 3.0, -1.7, 2.0, -1.0, 0.0, 1.0]


def _bounded(f, a):
    return f.tanh(a)


OPERATIONS = {
    # arithmetic
    "add": lambda f, a, b, c, k: a + b,
    "subtract": lambda f, a, b, c, k: a - b,
    "multiply": lambda f, a, b, c, k: a * b,
    "multiply_add": lambda f, a, b, c, k: a * b + c,
    "multiply_subtract": lambda f, a, b, c, k: a * b - c,
    "negative_multiply_add": lambda f, a, b, c, k: c - a * b,
    "divide": lambda f, a, b, c, k: a / b,
    "divide_safely": lambda f, a, b, c, k: a / (1.0 + b * b),
    "negate": lambda f, a, b, c, k: -a,
    "shift": lambda f, a, b, c, k: a + CONSTANTS[k % len(CONSTANTS)],
    "scale": lambda f, a, b, c, k: CONSTANTS[k % len(CONSTANTS)] * a,
    "scale_extremely": lambda f, a, b, c, k: EXTREME[k % len(EXTREME)] * a,
    "subtract_from": lambda f, a, b, c, k: CONSTANTS[k % len(CONSTANTS)] - a,
    "divide_by_constant": lambda f, a, b, c, k: a / (CONSTANTS[k % len(CONSTANTS)] or 7.0),
    "divide_constant": lambda f, a, b, c, k: CONSTANTS[k % len(CONSTANTS)] / a,
    "fma": lambda f, a, b, c, k: f.fma(a, b, c),
    "fma_constant": lambda f, a, b, c, k: f.fma(a, CONSTANTS[k % len(CONSTANTS)], c),
    "square": lambda f, a, b, c, k: f.square(a),
    # functions where they are defined
    "sqrt": lambda f, a, b, c, k: f.sqrt(1.0 + a * a),
    "exp": lambda f, a, b, c, k: f.exp(_bounded(f, a)),
    "log": lambda f, a, b, c, k: f.log(1.5 + a * a),
    "sin": lambda f, a, b, c, k: f.sin(a),
    "cos": lambda f, a, b, c, k: f.cos(a),
    "tan": lambda f, a, b, c, k: f.tan(0.8 * _bounded(f, a)),
    "asin": lambda f, a, b, c, k: f.asin(0.9 * _bounded(f, a)),
    "acos": lambda f, a, b, c, k: f.acos(0.9 * _bounded(f, a)),
    "atan": lambda f, a, b, c, k: f.atan(a),
    "atan2": lambda f, a, b, c, k: f.atan2(a, 1.1 + _bounded(f, b)),
    "sinh": lambda f, a, b, c, k: f.sinh(_bounded(f, a)),
    "cosh": lambda f, a, b, c, k: f.cosh(_bounded(f, a)),
    "tanh": lambda f, a, b, c, k: f.tanh(a),
    "abs": lambda f, a, b, c, k: f.abs(a),
    "power": lambda f, a, b, c, k: f.pow(1.2 + _bounded(f, a), EXPONENTS[k % len(EXPONENTS)]),
    "integer_power": lambda f, a, b, c, k: f.pow(a, k % 6),
    "power_of_variables": lambda f, a, b, c, k: f.pow(1.2 + _bounded(f, a), 0.8 * b),
    "minimum": lambda f, a, b, c, k: f.minimum(a, b),
    "maximum": lambda f, a, b, c, k: f.maximum(a, b),
    "maximum_constant": lambda f, a, b, c, k: f.maximum(a, CONSTANTS[k % len(CONSTANTS)]),
    # anywhere, where their values may be NaN or infinite
    "raw_sqrt": lambda f, a, b, c, k: f.sqrt(a),
    "raw_log": lambda f, a, b, c, k: f.log(a),
    "raw_exp": lambda f, a, b, c, k: f.exp(a),
    "raw_tan": lambda f, a, b, c, k: f.tan(a),
    "raw_asin": lambda f, a, b, c, k: f.asin(a),
    "raw_acos": lambda f, a, b, c, k: f.acos(a),
    "raw_atan2": lambda f, a, b, c, k: f.atan2(a, b),
    "raw_sinh": lambda f, a, b, c, k: f.sinh(a),
    "raw_cosh": lambda f, a, b, c, k: f.cosh(a),
    "raw_power": lambda f, a, b, c, k: f.pow(a, EXPONENTS[k % len(EXPONENTS)]),
    "raw_power_of_variables": lambda f, a, b, c, k: f.pow(a, b),
    # choices
    "where": lambda f, a, b, c, k: f.where(a < b, a * c, b - c),
    "where_not": lambda f, a, b, c, k: f.where(~(a <= CONSTANTS[k % len(CONSTANTS)]), b, c),
    "where_both": lambda f, a, b, c, k: f.where((a > 0.0) & (b < c), b * c, a),
    "where_either": lambda f, a, b, c, k: f.where((a >= 0.1) | ~(b < c), f.square(b), c),
    "where_nested": lambda f, a, b, c, k: f.where(a > b, f.where(b > c, a * b, c), f.where(a < c, c * c, b)),
    "where_mixed": lambda f, a, b, c, k: f.where(((a < b) | (b < c)) & ~((a < 0.0) & (c > 0.0)), a, b * c),
    # choices that keep NaN and infinity in the branch that is not taken
    "guarded_sqrt": lambda f, a, b, c, k: f.where(a > 0.0, b * f.sqrt(a), c),
    "guarded_log": lambda f, a, b, c, k: f.where(a > 0.0, f.log(a) * b, a - b),
    "guarded_divide": lambda f, a, b, c, k: f.where(f.abs(a) > 1e-3, b / a, c),
    "guarded_asin": lambda f, a, b, c, k: f.where((a > -1.0) & (a < 1.0), f.asin(a), b),
    "guarded_acos": lambda f, a, b, c, k: f.where((a <= -1.0) | (a >= 1.0), b * c, f.acos(a) * c),
    "guarded_power": lambda f, a, b, c, k: f.where(
        ~(a > 0.0), c, f.pow(a, 0.1 + EXPONENTS[k % len(EXPONENTS)])
    ),
    "guarded_pair": lambda f, a, b, c, k: (
        f.where(a > 0.5, f.sqrt(a - 0.5), 0.0) + f.where(a > 0.5, b * f.sqrt(a - 0.5), c)
    ),
    "guarded_nested": lambda f, a, b, c, k: f.where(
        a > 0.0, f.where(b > 0.0, f.log(a * b), f.sqrt(a) * b), f.where(b > 0.0, f.sqrt(b) / (b - a), c)
    ),
    "guarded_exp": lambda f, a, b, c, k: f.where(a < 20.0, f.exp(a), b),
    "guarded_norm": lambda f, a, b, c, k: f.where(a * a + b * b > 1e-6, c / f.sqrt(a * a + b * b), a),
    "guarded_infinite": lambda f, a, b, c, k: f.where(a > b, c, f.where(a > b, math.inf, b)),
}
NAMES = list(OPERATIONS)


@dataclass(frozen=True)
class Operation:
    """One operation on earlier values, which are counted from the newest; every sixteenth is a stage."""

    name: str
    operands: tuple[int, int, int]
    choice: int

    @property
    def is_stage(self) -> bool:
        return self.choice % 16 == 0 and self.choice > 0


@dataclass(frozen=True)
class Formula:
    unknowns: int
    others: int  # inputs that are not differentiated
    operations: tuple[Operation, ...]
    seed: int

    def of(self, functions, inputs, on_value=lambda value, is_stage: None):
        values = list(inputs)
        for operation in self.operations:
            a, b, c = (values[-1 - i % len(values)] for i in operation.operands)
            values.append(OPERATIONS[operation.name](functions, a, b, c, operation.choice))
            on_value(values[-1], operation.is_stage)
        return values[-1]

    def inputs(self, elements):
        """Values (inputs, elements): ordinary ones, ties, and places where functions and derivatives end."""
        rng = np.random.default_rng(self.seed)
        n = self.unknowns + self.others
        x = rng.normal(size=(n, elements)) * rng.choice([0.1, 1.0, 1.0, 3.0], size=elements)
        special = rng.choice([0.0, -0.0, 1.0, -1.0, 0.5, 1e-9, -1e-9, 1e4, 2.0], size=(n, elements))
        x = np.where(rng.random((n, elements)) < 0.1, special, x)
        x[:, elements // 4] = x[0, elements // 4]  # all equal
        return x


def formulas(largest=30, most_unknowns=12):
    # Mostly recent values, so that most operations reach the result.
    place = st.one_of(st.integers(0, 8), st.integers(0, 40))
    operation = st.builds(
        Operation, st.sampled_from(NAMES), st.tuples(place, place, place), st.integers(0, 63)
    )
    # Lists of hypothesis are short unless told otherwise; small ones come first, for shrinking.
    lists = st.sampled_from([1, largest // 5, 2 * largest // 5, 2 * largest // 3, largest]).flatmap(
        lambda least: st.lists(operation, min_size=least, max_size=largest)
    )
    return st.builds(
        Formula,
        st.integers(1, most_unknowns),
        st.integers(0, 3),
        lists.map(tuple),
        st.integers(0, 2**16),
    )
