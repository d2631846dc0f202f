"""Formulas in the engine: recorded, compiled for a back end, evaluated; comparison with the oracle."""

from __future__ import annotations

import _jets
import numpy as np
from _formulas import Formula

from stark._core import InvalidArgument
from stark._core import symbolic as core


def back_ends():
    """Names of all that this processor can execute, the interpreter first."""
    graph = core.Graph()
    x = graph.input()
    names = ["interpreter"]
    for name in ("avx2", "avx512"):
        try:
            if core.compile_arrays([x * x], [("x", [x], True)], name).backend == name:
                names.append(name)
        except InvalidArgument:
            pass
    return names


class Recorded:
    """A formula as an expression of a graph of its own. stages: none, some (as drawn) or all values."""

    def __init__(self, formula: Formula, stages: str = "some") -> None:
        self.graph = core.Graph()
        self.unknowns = [self.graph.input("unknown", f"x[{i}]") for i in range(formula.unknowns)]
        kinds = ("element", "uniform")
        self.others = [self.graph.input(kinds[i % 2], f"p{i}") for i in range(formula.others)]

        def mark(value, drawn):
            wanted = {"none": False, "some": drawn, "all": True}[stages]
            if wanted and isinstance(value, core.Scalar) and value.graph is not None:
                self.graph.mark_stage(value)

        result = formula.of(core, self.unknowns + self.others, mark)
        self.result = core.constant(result)

    def compile(self, back_end: str, outputs: list | None = None) -> core.ArrayFunction:
        arguments = [("x", self.unknowns, True), ("p", self.others, False)]
        return core.compile_arrays([self.result] if outputs is None else outputs, arguments, back_end)


def evaluate(function: core.ArrayFunction, order: int, x: np.ndarray, unknowns: int):
    """(values, first, second) of inputs (inputs, elements)."""
    count = x.shape[1]
    arrays = [np.ascontiguousarray(x[:unknowns].T), np.ascontiguousarray(x[unknowns:].T)]
    shapes = [[unknowns], [len(x) - unknowns]]
    return function.evaluate(order, True, order > 0, arrays, shapes, [count])


def bits(array: np.ndarray) -> np.ndarray:
    """For comparisons bit by bit; NaN is one value, whatever its sign and payload."""
    return np.where(
        np.isnan(array), np.uint64(0x7FF8000000000000), np.ascontiguousarray(array).view(np.uint64)
    )


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and bool((bits(a) == bits(b)).all())


class Expected:
    """Value, gradient and Hessian by the oracle, elements first, with tolerances and where they are known."""

    def __init__(self, formula: Formula, x: np.ndarray) -> None:
        with np.errstate(all="ignore"):
            inputs = _jets.variables(list(x), formula.unknowns)
            y = _jets.jet(formula.of(_jets, inputs), inputs[0])
            known = np.isfinite(y.v) & np.isfinite(y.v_error)
            self.value = _Numbers(y.v, y.v_error, known)
            self.gradient = _Numbers(y.g.T, y.g_error.T, known)
            self.hessian = _Numbers(np.moveaxis(y.H, -1, 0), np.moveaxis(y.H_error, -1, 0), known)


class _Numbers:
    def __init__(self, exact: np.ndarray, error: np.ndarray, known: np.ndarray) -> None:
        known = known.reshape(-1, *[1] * (exact.ndim - 1))
        self.exact = exact
        self.tolerance = _jets.SAFETY * error + 1e-290  # products of derivatives may become subnormal
        self.known = known & np.isfinite(exact) & np.isfinite(error)

    def wrong(self, computed: np.ndarray) -> np.ndarray:
        """Where the computed number is known to be wrong; NaN is."""
        with np.errstate(invalid="ignore"):
            return self.known & ~(np.abs(computed - self.exact) <= self.tolerance)

    def check(self, computed: np.ndarray, what: str) -> None:
        wrong = self.wrong(computed)
        if wrong.any():
            place = tuple(int(i) for i in np.argwhere(wrong)[0])
            raise AssertionError(
                f"{what}{list(place)}: the engine gives {computed[place]!r}, the oracle "
                f"{self.exact[place]!r} within {self.tolerance[place]:.1e}"
            )
