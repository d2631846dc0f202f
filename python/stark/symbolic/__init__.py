"""Formulas: written in Python, differentiated exactly, compiled to machine code in process.

    import stark.symbolic as sym

    @sym.function
    def rosenbrock(x: sym.Vector[2], a: float = 1.0, b: float = 100.0):
        return (a - x[0]) ** 2 + b * (x[1] - x[0] ** 2) ** 2

    rosenbrock(x)            # x (..., 2) -> (...)
    rosenbrock.gradient(x)   # (..., 2)
    rosenbrock.hessian(x)    # (..., 2, 2)

A formula is recorded once, by running the function on symbols, and then evaluated over arrays. docs/symbolic.md has
what is supported and what is not."""

from stark._core import TraceError
from stark._core.symbolic import Graph, Scalar
from stark.symbolic import numpy_protocol as _numpy_protocol  # installs NumPy's hooks
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
    where,
)
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.signature import Matrix, Real, Vector, symbols
from stark.symbolic.statistics import Statistics
from stark.symbolic.tensor import (
    Mat,
    Vec,
    columns,
    cross,
    determinant,
    diag,
    dot,
    identity,
    invariants,
    inverse,
    mat,
    norm,
    normalized,
    outer,
    skew,
    squared_norm,
    trace,
    transpose,
    vec,
)

__all__ = [
    "ExpressionGraph",
    "Function",
    "Graph",
    "Mat",
    "Matrix",
    "Real",
    "Scalar",
    "Statistics",
    "TraceError",
    "Vec",
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
    "sin",
    "sinh",
    "skew",
    "sqrt",
    "square",
    "squared_norm",
    "symbols",
    "tan",
    "tanh",
    "trace",
    "transpose",
    "vec",
    "where",
]
