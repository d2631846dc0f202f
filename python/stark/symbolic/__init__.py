"""Formulas: written in Python, differentiated exactly, compiled to machine code in process.

    import stark.symbolic as sym

    @sym.function
    def rosenbrock(x: sym.Vec2, a: float = 1.0, b: float = 100.0):
        return (a - x[0]) ** 2 + b * (x[1] - x[0] ** 2) ** 2

    rosenbrock(x)            # x (..., 2) -> (...)
    rosenbrock.gradient(x)   # (..., 2)
    rosenbrock.hessian(x)    # (..., 2, 2)

A formula is recorded once, by running the function on symbols, and then evaluated over arrays;
docs/symbolic.md has what is supported and what is not."""

import stark.symbolic.numpy_protocol  # noqa: F401  (installs NumPy's hooks)
from stark._core import TraceError
from stark._core.symbolic import Graph, Scalar
from stark.symbolic.function import Function, compile, function
from stark.symbolic.functions import (
    abs,
    acos,
    asin,
    atan,
    atan2,
    clip,
    cos,
    cosh,
    exp,
    fma,
    gradient,
    held,
    hessian,
    is_same,
    jacobian,
    log,
    mark_stage,
    maximum,
    minimum,
    pow,
    sin,
    sinh,
    sqrt,
    square,
    tan,
    tanh,
    total,
    where,
)
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.linear_algebra import (
    cross,
    determinant,
    dot,
    invariants,
    inverse,
    norm,
    normalized,
    outer,
    skew,
    squared_norm,
    trace,
)
from stark.symbolic.power_trace import power_trace
from stark.symbolic.signature import Mat2, Mat3, Matrix, Real, Vec2, Vec3, Vec4, Vector, symbols
from stark.symbolic.statistics import Statistics
from stark.symbolic.tensor import Mat, Vec, columns, diag, identity, mat, transpose, vec

__all__ = [
    "ExpressionGraph",
    "Function",
    "Graph",
    "Mat",
    "Mat2",
    "Mat3",
    "Matrix",
    "Real",
    "Scalar",
    "Statistics",
    "TraceError",
    "Vec",
    "Vec2",
    "Vec3",
    "Vec4",
    "Vector",
    "abs",
    "acos",
    "asin",
    "atan",
    "atan2",
    "clip",
    "columns",
    "compile",
    "cos",
    "cosh",
    "cross",
    "determinant",
    "diag",
    "dot",
    "exp",
    "fma",
    "function",
    "gradient",
    "held",
    "hessian",
    "identity",
    "invariants",
    "inverse",
    "is_same",
    "jacobian",
    "log",
    "mark_stage",
    "mat",
    "maximum",
    "minimum",
    "norm",
    "normalized",
    "outer",
    "pow",
    "power_trace",
    "sin",
    "sinh",
    "skew",
    "sqrt",
    "square",
    "squared_norm",
    "symbols",
    "tan",
    "tanh",
    "total",
    "trace",
    "transpose",
    "vec",
    "where",
]
