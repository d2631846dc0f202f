"""NumPy's functions on traced values: np.sqrt(s), array * vec, np.dot(a, b) record the same operations as
those of stark.symbolic; everything that is not part of formulas raises TraceError."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from stark._core import TraceError
from stark.symbolic import functions, linear_algebra, tensor

_UFUNCS: dict[np.ufunc, Callable[..., object]] = {
    np.add: operator.add,
    np.subtract: operator.sub,
    np.multiply: operator.mul,
    np.true_divide: operator.truediv,
    np.power: operator.pow,
    np.float_power: operator.pow,
    np.matmul: tensor.matmul,
    np.negative: operator.neg,
    np.positive: operator.pos,
    np.absolute: functions.abs,
    np.fabs: functions.abs,
    np.less: operator.lt,
    np.less_equal: operator.le,
    np.greater: operator.gt,
    np.greater_equal: operator.ge,
    np.logical_and: operator.and_,
    np.logical_or: operator.or_,
    np.logical_not: operator.invert,
    np.bitwise_and: operator.and_,
    np.bitwise_or: operator.or_,
    np.invert: operator.invert,
    np.minimum: functions.minimum,
    np.maximum: functions.maximum,
    np.arctan2: functions.atan2,
    np.arcsin: functions.asin,
    np.arccos: functions.acos,
    np.arctan: functions.atan,
    np.hypot: lambda a, b: functions.sqrt(a * a + b * b),
    np.equal: operator.eq,
    np.not_equal: operator.ne,
}
_UFUNCS |= {
    getattr(np, name): getattr(functions, name)
    for name in ("sqrt", "square", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh")
}

_FUNCTIONS: dict[Callable[..., object], Callable[..., object]] = {
    np.dot: lambda a, b: _dot(a, b),
    np.inner: linear_algebra.dot,
    np.vdot: linear_algebra.dot,
    np.cross: linear_algebra.cross,
    np.outer: linear_algebra.outer,
    np.trace: linear_algebra.trace,
    np.transpose: lambda a: a.T,
    np.diag: tensor.diag,
    np.where: functions.where,
    np.clip: functions.clip,
    np.sum: lambda a: a.sum(),
    np.max: lambda a: a.max(),
    np.min: lambda a: a.min(),
    np.all: lambda a: a.all(),
    np.any: lambda a: a.any(),
    np.linalg.norm: linear_algebra.norm,
    np.linalg.det: linear_algebra.determinant,
    np.linalg.inv: linear_algebra.inverse,
    np.stack: tensor.mat,
    np.vstack: tensor.mat,
    np.column_stack: lambda parts: tensor.columns(*parts),
    np.concatenate: lambda parts: _concatenated(parts),
    np.shape: lambda a: getattr(a, "shape", ()),
    np.ndim: lambda a: len(getattr(a, "shape", ())),
    np.size: lambda a: getattr(a, "size", 1),
}


def _dot(a: Any, b: Any) -> object:
    a, b = tensor.convert(a, "dot"), tensor.convert(b, "dot")
    both = isinstance(a, tensor.Tensor) and isinstance(b, tensor.Tensor)
    return tensor.matmul(a, b) if both else a * b


def _concatenated(parts: Any) -> object:
    entries: list[object] = []
    for part in parts:
        vector: Any = tensor.convert(part, "concatenate")
        entries.extend(vector)
    return tensor.Vec(entries)


def array_ufunc(self: object, ufunc: np.ufunc, method: str, *inputs: object, **options: object) -> object:
    """NumPy's hook for universal functions."""
    function = _UFUNCS.get(ufunc)
    if function is None:
        raise TraceError(f"np.{ufunc.__name__} is not part of formulas; the functions of stark.symbolic are")
    if method != "__call__" or options:
        raise TraceError(
            f"np.{ufunc.__name__}: only plain calls work on traced values, not {method} or keywords"
        )
    return function(*(tensor.convert(x, f"np.{ufunc.__name__}") for x in inputs))


def array_function(
    self: object,
    function: Callable[..., object],
    types: object,
    args: tuple[Any, ...],
    kwargs: dict[Any, Any],
) -> object:
    """NumPy's hook for its other functions."""
    name = getattr(function, "__name__", str(function))
    traced = _FUNCTIONS.get(function)
    if traced is None:
        raise TraceError(f"np.{name} does not work on traced values; the functions of stark.symbolic do")
    try:
        return traced(*args, **kwargs)
    except TypeError as error:
        raise TraceError(f"np.{name}: only its plain form works on traced values ({error})") from None


_types: tuple[Any, ...] = (tensor.Scalar, tensor.Tensor)
for _type in _types:
    _type.__array_ufunc__ = array_ufunc
    _type.__array_function__ = array_function
