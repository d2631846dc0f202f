"""Joints of users: what they hold and their coordinates, from frames. Their formulas are read from the
recording, operation by operation."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Origin and axes (columns) of frame a, then of frame b.
Frames = tuple[Floats, Floats, Floats, Floats]


class UnknownFormula(Exception):  # noqa: N818 (says what it is)
    """A formula that needs what is not recorded, or does what is not known here."""


_OPERATIONS: dict[str, Callable[..., float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "fma": lambda a, b, c: a * b + c,
    "neg": lambda a: -a,
    "abs": abs,
    "min": min,
    "max": max,
    "pow": math.pow,
    "atan2": math.atan2,
    "select": lambda c, a, b: a if c else b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    "&&": lambda a, b: bool(a) and bool(b),
    "||": lambda a, b: bool(a) or bool(b),
    "not": lambda a: not a,
    "held": lambda a: a,
    **{
        name: getattr(math, name)
        for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh")
    },
}


def evaluate(
    formula: dict[str, Any],
    frames: dict[str, Frames | None],
    values: dict[str, Any],
    clocks: dict[str, float],
) -> list[float]:
    """Outputs of a recorded formula. ``frames``: those at the end of the step ("x"), at its start ("x_prev")
    and at time 0 ("x_initial"), None where they are not known. Raises UnknownFormula."""
    points = {source: None if f is None else _points(f) for source, f in frames.items()}
    results: list[Any] = []
    for operation, *operands in formula["nodes"]:
        if operation == "constant":
            results.append(float(operands[0]))
        elif operation == "input":
            results.append(_input(operands, points, values, clocks))
        elif operation in _OPERATIONS:
            try:
                results.append(_OPERATIONS[operation](*(results[k] for k in operands)))
            except (ArithmeticError, ValueError):  # of a branch that is not taken, as a rule
                results.append(math.nan)
        else:
            raise UnknownFormula(f"the operation '{operation}' is not known here")
    outputs = [float(results[k]) for k in formula["outputs"]]
    if any(math.isnan(value) for value in outputs):
        raise UnknownFormula("it has no value here, where rounding may decide")
    return outputs


def _points(frames: Frames) -> Floats:
    """Origin and axes of frame a, then of frame b (8, 3)."""
    p, A, q, B = frames
    return np.concatenate([p[None], A.T, q[None], B.T])


def _input(
    operands: Sequence[Any],
    points: dict[str, Floats | None],
    values: dict[str, Any],
    clocks: dict[str, float],
) -> float:
    source, point, component = operands
    if source in points:
        known = points[source]
        if known is None:
            raise UnknownFormula(f"it depends on {source}, which is not recorded")
        return float(known[point, component])
    if source in values:
        return float(np.ravel(np.array(values[source][0]))[component])
    if source in clocks and math.isfinite(clocks[source]):
        return clocks[source]
    raise UnknownFormula(f"it depends on '{source}', which is not recorded")
