"""Functions of scalars, applied entry by entry to vectors and matrices. Of numbers alone they give a constant
scalar, which float() turns into a number."""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

from stark._core import TraceError
from stark._core import symbolic as core
from stark.overloads import overload
from stark.symbolic.tensor import (
    Mat,
    Scalar,
    Tensor,
    Vec,
    convert,
    describe,
    elementwise,
    from_shape,
    is_scalar_like,
)

_Tensor = TypeVar("_Tensor", bound=Tensor)


class Unary(Protocol):
    """Of a scalar or number a scalar, of a vector or matrix one of the same shape."""

    @overload
    def __call__(self, x: Scalar | float, /) -> Scalar: ...
    @overload
    def __call__(self, x: _Tensor, /) -> _Tensor: ...
    @overload
    def __call__(self, x: object, /) -> Any: ...


class Binary(Protocol):
    """Of scalars or numbers a scalar; of vectors or matrices, with scalars or numbers, one of their shape."""

    @overload
    def __call__(self, a: Scalar | float, b: Scalar | float, /) -> Scalar: ...
    @overload
    def __call__(self, a: _Tensor, b: object, /) -> _Tensor: ...
    @overload
    def __call__(self, a: Scalar | float, b: _Tensor, /) -> _Tensor: ...
    @overload
    def __call__(self, a: object, b: object, /) -> Any: ...


def _unary(name: str) -> Unary:
    compiled = getattr(core, name)

    def function(x: object) -> Any:
        return elementwise(compiled, name, x)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = compiled.__doc__.splitlines()[-1]
    return function


def _binary(name: str, doc: str) -> Binary:
    compiled = getattr(core, name)

    def function(a: object, b: object) -> Any:
        return elementwise(compiled, name, a, b)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = doc
    return function


abs: Unary = _unary("abs")
sqrt: Unary = _unary("sqrt")
square: Unary = _unary("square")
exp: Unary = _unary("exp")
log: Unary = _unary("log")
sin: Unary = _unary("sin")
cos: Unary = _unary("cos")
tan: Unary = _unary("tan")
asin: Unary = _unary("asin")
acos: Unary = _unary("acos")
atan: Unary = _unary("atan")
sinh: Unary = _unary("sinh")
cosh: Unary = _unary("cosh")
tanh: Unary = _unary("tanh")
held: Unary = _unary("held")
minimum: Binary = _binary("minimum", "The smaller of two: a < b ? a : b.")
maximum: Binary = _binary("maximum", "The larger of two: a > b ? a : b.")
atan2: Binary = _binary("atan2", "Angle [rad] of the direction (x, y); arguments y, x.")
pow: Binary = _binary("pow", "Power: products for integer exponents, else the real power of a base >= 0.")


@overload
def fma(a: Scalar | float, b: Scalar | float, c: Scalar | float) -> Scalar: ...
@overload
def fma(a: object, b: object, c: object) -> Any: ...
def fma(a: object, b: object, c: object) -> Any:
    """a b + c with one rounding."""
    return elementwise(core.fma, "fma", a, b, c)


@overload
def total(x: Scalar | float, name: str | None = None) -> Scalar: ...
@overload
def total(x: _Tensor, name: str | None = None) -> _Tensor: ...
def total(x: object, name: str | None = None) -> Any:
    """The sum of x over all elements of an energy: the volume inside a surface, the length of a cable. An
    energy of totals is a function of them: ``0.5 * k * (stark.total(e.length, "length") - rest) ** 2``. The
    handle of the energy has the sum under its name. For formulas of ``stark.energy`` alone."""
    result = elementwise(core.total, "total", x)
    if name is not None:
        if not isinstance(name, str) or not name.isidentifier() or name.startswith("_"):
            raise TraceError(f"total: the name {name!r}: must be one that an attribute can have")
        entries = result.entries if isinstance(result, Tensor) else [result]
        for k, entry in enumerate(entries):
            entry.graph.set_name(entry, name if len(entries) == 1 else f"{name}[{k}]")
    return result


@overload
def clip(x: Scalar | float, lower: Scalar | float, upper: Scalar | float) -> Scalar: ...
@overload
def clip(x: _Tensor, lower: object, upper: object) -> _Tensor: ...
@overload
def clip(x: object, lower: object, upper: object) -> Any: ...
def clip(x: object, lower: object, upper: object) -> Any:
    """x, at least `lower` and at most `upper`."""
    return minimum(maximum(x, lower), upper)


@overload
def where(condition: Scalar | bool, a: Scalar | float, b: Scalar | float) -> Scalar: ...
@overload
def where(condition: Scalar | bool, a: _Tensor, b: object) -> _Tensor: ...
@overload
def where(condition: object, a: object, b: object) -> Any: ...
def where(condition: object, a: object, b: object) -> Any:
    """a where the condition holds, else b. The branch that is not taken never contributes to value or
    derivatives, not even as NaN. One condition may choose between vectors or matrices."""
    a, b = convert(a, "where"), convert(b, "where")
    if isinstance(condition, (Tensor, list, tuple)):
        return elementwise(core.where, "where", condition, a, b)
    if not (is_scalar_like(condition) or isinstance(condition, bool)):
        raise TraceError(
            f"where: got {type(condition).__name__} as the condition: must be a comparison such as x > 0.0"
        )
    return elementwise(lambda x, y: core.where(condition, x, y), "where", a, b)


def gradient(output: object, wrt: object) -> Any:
    """Derivative of a scalar expression with respect to symbols, in their shape: the stress gradient(psi, F)
    of an argument F, say. For other values F write psi as a function of its own and call psi.gradient(F)."""
    output, variable = convert(output, "gradient"), convert(wrt, "gradient: wrt")
    if isinstance(output, Tensor):
        raise TraceError("gradient: the output is not a scalar; use jacobian")
    shape = getattr(variable, "shape", ())
    return from_shape(core.jacobian([output], _entries(variable))[0], shape)


def jacobian(output: Any, wrt: Any) -> Any:
    """Derivatives of the entries of a vector expression (rows) by those of a vector of symbols."""
    output, variable = convert(output, "jacobian"), convert(wrt, "jacobian: wrt")
    shape = getattr(output, "shape", ()) + getattr(variable, "shape", ())
    if len(shape) > 2:
        raise TraceError(
            f"jacobian: the result has {len(shape)} dimensions: must have at most 2; give scalars or vectors"
        )
    rows = core.jacobian(_entries(output), _entries(variable))
    return from_shape([entry for row in rows for entry in row], shape)


def hessian(output: object, wrt: object) -> Scalar | Mat:
    """Second derivatives of a scalar expression with respect to a symbol or a vector of symbols."""
    output, variable = convert(output, "hessian"), convert(wrt, "hessian: wrt")
    if isinstance(output, Tensor) or isinstance(variable, Mat):
        raise TraceError("hessian: the output must be a scalar, the variable a scalar or vector")
    rows = core.hessian(output, _entries(variable))
    result = from_shape([entry for row in rows for entry in row], 2 * getattr(variable, "shape", ()))
    assert not isinstance(result, Vec)
    return result


def _entries(value: Scalar | Vec | Mat) -> list[Scalar]:
    return list(value.entries) if isinstance(value, Tensor) else [value]


def mark_stage(value: Scalar | Vec | Mat) -> Any:
    """Hint for second derivatives: they may be formed through this value (points of a body, a deformation
    gradient). Never changes results. Returns the value."""
    for entry in _entries(convert(value, "mark_stage")):
        if entry.graph is not None:
            entry.graph.mark_stage(entry)
    return value


def is_same(a: Scalar | float, b: Scalar | float) -> bool:
    """Whether two expressions are the same operation on the same inputs, not whether their values are.
    Raises TraceError for anything but scalars."""
    for name, given in (("a", a), ("b", b)):
        if not is_scalar_like(given):
            raise TraceError(f"is_same: {name} is {describe(given)}: must be a scalar of a formula")
    same: bool = core.is_same(convert(a, "is_same"), convert(b, "is_same"))  # type: ignore[arg-type]
    return same
