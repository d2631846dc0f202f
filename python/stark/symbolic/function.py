"""Compiled functions: a formula recorded once, evaluated over arrays of any batch shape, with derivatives."""

from __future__ import annotations

import functools
import inspect
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from stark._core import InvalidArgument, TraceError
from stark._core import symbolic as core
from stark.arguments import given_choice, shown_value
from stark.overloads import overload
from stark.symbolic.arrays import batch_of
from stark.symbolic.errors import formula_error, recording
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.signature import Argument, new_symbols, read_signature
from stark.symbolic.statistics import Statistics
from stark.symbolic.tensor import Mat, Scalar, Tensor, Vec, convert, describe, from_shape

Wrt = str | Sequence[str] | None
_SYMBOLS = (Scalar, Tensor)
BACKENDS = ("automatic", "avx512", "avx2", "neon", "interpreter")
_ORDERS = ("value", "gradient", "hessian")


class Formula:
    """Arguments and result of a recorded function; its code, by the arguments that are differentiated."""

    def __init__(
        self,
        name: str,
        arguments: Sequence[Argument],
        result: Scalar | Vec | Mat,
        backend: str,
        function: Callable[..., object] | None = None,
    ) -> None:
        self.name = name
        self.arguments: tuple[Argument, ...] = tuple(arguments)
        self.result = result
        self.shape: tuple[int, ...] = getattr(result, "shape", ())
        self.outputs: list[Scalar] = list(result.entries) if isinstance(result, Tensor) else [result]
        self.backend = backend
        self.own_shapes: list[tuple[int, ...]] = [a.shape for a in self.arguments]
        self._compiled: dict[tuple[int, ...], core.ArrayFunction] = {}
        self._lock = threading.Lock()
        self._check(function)

    def compiled(self, wrt: tuple[int, ...]) -> core.ArrayFunction:
        """Code that differentiates the arguments with these numbers."""
        found = self._compiled.get(wrt)
        if found is not None:
            return found
        with self._lock:
            if wrt not in self._compiled:
                # Derivatives come in the order of the arguments; blocks() puts them in the order of wrt.
                arguments = [(a.name, a.entries, i in wrt) for i, a in enumerate(self.arguments)]
                self._compiled[wrt] = core.compile_arrays(self.outputs, arguments, self.backend)
            return self._compiled[wrt]

    def blocks(self, wrt: tuple[int, ...]) -> list[slice]:
        """Where each argument of wrt is among all variables."""
        places, begin = {}, 0
        for i in sorted(wrt):
            size = len(self.arguments[i].entries)
            places[i] = slice(begin, begin + size)
            begin += size
        return [places[i] for i in wrt]

    def _check(self, function: Callable[..., object] | None) -> None:
        compiled = self.compiled((0,))
        unused = [a.name for i, a in enumerate(self.arguments) if not compiled.uses(i)]
        if unused:
            names = ", ".join(f"'{name}'" for name in unused)
            raise formula_error(
                self.name,
                f"the result does not depend on {names}; use every argument, or remove it from the signature",
                function,
            )


class Function:
    """A compiled function. Calling it evaluates it; gradient, jacobian and hessian are its derivatives.

    Arguments are numbers or arrays: own dimensions last, any leading batch dimensions, which broadcast as in
    NumPy. Derivatives are with respect to the first argument, or to those that `wrt` names: one name gives
    one array, a tuple of names a tuple of arrays."""

    def __init__(self, name: str, signature: inspect.Signature, record: Callable[[], Formula]) -> None:
        self.__name__ = self.__qualname__ = name
        self.__signature__ = signature
        parameters = signature.parameters.values()
        self._all_positional = all(p.kind is not p.KEYWORD_ONLY for p in parameters)
        self._defaults = tuple(p.default for p in parameters)
        self._record = record
        self._formula: Formula | None = None
        self._recording = False
        self._lock = threading.RLock()

    @property
    def formula(self) -> Formula:
        """The recorded formula; recorded at first use."""
        if self._formula is None:
            with self._lock:
                if self._recording:
                    raise TraceError(f"{self.__name__} calls itself; a formula is recorded without recursion")
                self._recording = True
                try:
                    self._formula = self._formula or self._record()
                finally:
                    self._recording = False
        return self._formula

    def __call__(self, *args: object, **kwargs: object) -> Any:
        """Values, shape batch + shape of the result. Symbols as arguments give the formula of them."""
        if _any_symbols(args, kwargs):
            return self._of_symbols(self.formula.outputs, self.formula.shape, args, kwargs)
        formula = self.formula
        arrays, batch = self._arrays(args, kwargs)
        values, _, _ = self._run(0, True, False, (0,), arrays, batch)
        return values.reshape(batch + formula.shape)[()]

    def gradient(self, *args: object, wrt: Wrt = None, **kwargs: object) -> Any:
        """First derivatives of a scalar function: batch + shape of the argument."""
        return self._first("gradient", args, kwargs, wrt, False)[1]

    def jacobian(self, *args: object, wrt: Wrt = None, **kwargs: object) -> Any:
        """First derivatives: batch + shape of the result + shape of the argument."""
        return self._first("jacobian", args, kwargs, wrt, False)[1]

    def value_and_gradient(self, *args: object, wrt: Wrt = None, **kwargs: object) -> tuple[Any, Any]:
        """(values, gradient) of one evaluation."""
        return self._first("gradient", args, kwargs, wrt, True)

    def value_and_jacobian(self, *args: object, wrt: Wrt = None, **kwargs: object) -> tuple[Any, Any]:
        """(values, jacobian) of one evaluation."""
        return self._first("jacobian", args, kwargs, wrt, True)

    def hessian(self, *args: object, wrt: Wrt = None, **kwargs: object) -> Any:
        """Second derivatives of a scalar function: batch + shape of the argument, twice; for several
        arguments a tuple of rows of blocks."""
        return self._second(args, kwargs, wrt, False)[2]

    def value_gradient_hessian(self, *args: object, wrt: Wrt = None, **kwargs: object) -> tuple[Any, ...]:
        """(values, gradient, hessian) of one evaluation."""
        return self._second(args, kwargs, wrt, True)

    def graph(self) -> ExpressionGraph:
        """The recorded operations; print it for a listing."""
        arguments = ", ".join(
            a.name + (str(list(a.shape)).replace(" ", "") if a.shape else "") for a in self.formula.arguments
        )
        return ExpressionGraph(f"{self.__name__}({arguments})", self.formula.outputs)

    @property
    def statistics(self) -> Statistics:
        """Counts for values and derivatives with respect to the first argument; builds what is missing."""
        compiled = self.formula.compiled((0,))
        orders = _ORDERS if len(self.formula.outputs) == 1 else ("value", "jacobian")
        return Statistics.of(
            compiled.backend, {name: compiled.statistics(k) for k, name in enumerate(orders)}
        )

    def __reduce__(self) -> str:
        # Pickled by name, as functions are.
        return self.__qualname__

    def __repr__(self) -> str:
        return f"<stark.symbolic.Function {self.__name__}{self.__signature__}>"

    def _of_symbols(
        self, outputs: list[Any], shape: tuple[Any, ...], args: tuple[Any, ...], kwargs: dict[Any, Any]
    ) -> Scalar | Vec | Mat:
        """Expressions of the formula with the given symbols or expressions as arguments."""
        bound = self._bind(args, kwargs)
        values: list[Scalar] = []
        for argument in self.formula.arguments:
            value = convert(bound[argument.name], f"{self.__name__}: argument '{argument.name}'")
            if getattr(value, "shape", ()) != argument.shape:
                raise TraceError(
                    f"{self.__name__}: argument '{argument.name}' is {describe(value)}: must "
                    f"be {describe(argument.value)}"
                )
            values += value.entries if isinstance(value, Tensor) else [value]
        if len(shape) > 2:
            raise TraceError(
                f"{self.__name__}: this derivative has {len(shape)} dimensions: must have at most 2"
            )
        symbols = [entry for argument in self.formula.arguments for entry in argument.entries]
        return from_shape(core.substitute(outputs, symbols, values), shape)

    def _derivatives_of_symbols(
        self, order: int, args: tuple[Any, ...], kwargs: dict[Any, Any], wrt: Wrt
    ) -> Any:
        """Derivatives as expressions, for formulas that use this one."""
        formula, which = self.formula, self._wrt(wrt)
        blocks = []
        for i in which:
            argument = formula.arguments[i]
            if order == 1:
                rows = core.jacobian(formula.outputs, argument.entries)
            elif len(which) > 1:
                raise TraceError(f"{self.__name__}: inside of a formula, wrt of a hessian is one argument")
            else:
                rows = core.hessian(formula.outputs[0], argument.entries)
            shape = (formula.shape if order == 1 else argument.shape) + argument.shape
            blocks.append(self._of_symbols([y for row in rows for y in row], shape, args, kwargs))
        return _single(tuple(blocks), wrt)

    def _bind(self, args: tuple[Any, ...], kwargs: dict[Any, Any]) -> dict[str, object]:
        try:
            bound = self.__signature__.bind(*args, **kwargs)
        except TypeError as error:
            raise TypeError(f"{self.__name__}{self.__signature__}: {error}") from None
        bound.apply_defaults()
        return bound.arguments

    def _arrays(
        self, args: tuple[Any, ...], kwargs: dict[Any, Any]
    ) -> tuple[list[np.ndarray], tuple[int, ...]]:
        arguments = self.formula.arguments
        given, defaults = len(args), self._defaults
        # Signature.bind is slow and needed only for keywords and for mistakes.
        plain = not kwargs and self._all_positional and given <= len(defaults)
        if plain and inspect.Parameter.empty not in defaults[given:]:
            args += defaults[given:]
        else:
            bound = self._bind(args, kwargs)
            args = tuple(bound[a.name] for a in arguments)
        return batch_of(self.__name__, arguments, args)

    def _wrt(self, wrt: Wrt) -> tuple[int, ...]:
        if wrt is None:
            return (0,)
        names = [a.name for a in self.formula.arguments]
        if not isinstance(wrt, (str, list, tuple)):
            raise InvalidArgument(
                f"{self.__name__}: wrt={shown_value(wrt)}: must be the name of an argument, or several"
            )
        wanted = (wrt,) if isinstance(wrt, str) else tuple(wrt)
        for name in wanted:
            if name not in names:
                raise InvalidArgument(
                    f"{self.__name__}: wrt={name!r} is no argument; there are {', '.join(names)}"
                )
        if not wanted or len(set(wanted)) < len(wanted):
            raise InvalidArgument(f"{self.__name__}: wrt={wrt!r} must name at least one argument, each once")
        return tuple(names.index(name) for name in wanted)

    def _run(
        self,
        order: int,
        values: bool,
        first: bool,
        wrt: tuple[int, ...],
        arrays: list[Any],
        batch: tuple[Any, ...],
    ) -> tuple[Any, ...]:
        formula = self.formula
        return formula.compiled(wrt).evaluate(order, values, first, arrays, formula.own_shapes, batch)

    def _require_scalar(self, what: str) -> None:
        if len(self.formula.outputs) > 1 or self.formula.shape:
            raise InvalidArgument(
                f"{self.__name__}: {what} needs a scalar result, this function returns "
                f"{describe(self.formula.result)}; use jacobian"
            )

    def _first(
        self, what: str, args: tuple[Any, ...], kwargs: dict[Any, Any], wrt: Wrt, with_values: bool
    ) -> tuple[Any, ...]:
        if what == "gradient":
            self._require_scalar(what)
        if _any_symbols(args, kwargs):
            value = self(*args, **kwargs) if with_values else None
            return value, self._derivatives_of_symbols(1, args, kwargs, wrt)
        formula, which = self.formula, self._wrt(wrt)
        arrays, batch = self._arrays(args, kwargs)
        values, first, _ = self._run(1, with_values, True, which, arrays, batch)
        blocks = tuple(
            np.ascontiguousarray(first[..., place]).reshape(
                batch + formula.shape + formula.arguments[i].shape
            )[()]
            for i, place in zip(which, formula.blocks(which), strict=True)
        )
        if with_values:
            values = values.reshape(batch + formula.shape)[()]
        return values, _single(blocks, wrt)

    def _second(
        self, args: tuple[Any, ...], kwargs: dict[Any, Any], wrt: Wrt, with_lower: bool
    ) -> tuple[Any, ...]:
        self._require_scalar("hessian")
        if _any_symbols(args, kwargs):
            lower = self._first("gradient", args, kwargs, wrt, True) if with_lower else (None, None)
            return (*lower, self._derivatives_of_symbols(2, args, kwargs, wrt))
        formula, which = self.formula, self._wrt(wrt)
        arrays, batch = self._arrays(args, kwargs)
        values, first, second = self._run(2, with_lower, with_lower, which, arrays, batch)
        shapes = [formula.arguments[i].shape for i in which]
        places = formula.blocks(which)
        rows = tuple(
            _single(
                tuple(
                    np.ascontiguousarray(second[..., p, q]).reshape(batch + a + b)[()]
                    for q, b in zip(places, shapes, strict=True)
                ),
                wrt,
            )
            for p, a in zip(places, shapes, strict=True)
        )
        if not with_lower:
            return None, None, _single(rows, wrt)
        slopes = tuple(
            np.ascontiguousarray(first[..., 0, p]).reshape(batch + a)[()]
            for p, a in zip(places, shapes, strict=True)
        )
        return values.reshape(batch)[()], _single(slopes, wrt), _single(rows, wrt)


def _any_symbols(args: tuple[Any, ...], kwargs: dict[Any, Any]) -> bool:
    return any(isinstance(x, _SYMBOLS) for x in args) or any(isinstance(x, _SYMBOLS) for x in kwargs.values())


def _single(blocks: tuple[Any, ...], wrt: Wrt) -> Any:
    return blocks[0] if wrt is None or isinstance(wrt, str) else blocks


def _result(name: str, value: object, function: Callable[..., object] | None) -> Scalar | Vec | Mat:
    if value is None:
        raise formula_error(name, "it returns None; return a number, vec(...) or mat(...)", function)
    try:
        result = convert(value, "the result")
    except TraceError as error:
        raise formula_error(name, str(error), function) from None
    entries = result.entries if isinstance(result, Tensor) else [result]
    if any(entry.is_condition for entry in entries):
        raise formula_error(
            name, "it returns a condition, not a number; return stark.where(condition, a, b)", function
        )
    return result


@overload
def function(f: Callable[..., object], /, *, backend: str = "automatic") -> Function: ...


@overload
def function(*, backend: str = "automatic") -> Callable[[Callable[..., object]], Function]: ...


def function(
    f: Callable[..., object] | None = None, /, *, backend: str = "automatic"
) -> Function | Callable[[Callable[..., object]], Function]:
    """Decorator: makes a compiled function of a Python function whose arguments are annotated with float,
    Vec3 or Annotated[Vec, n], Mat3 or Annotated[Mat, r, c]. It runs once with symbols, at first use; numbers
    from outside are fixed then.

    backend: "automatic" (machine code where possible), "avx512", "avx2", "neon" or "interpreter"; same
    bits."""
    given_choice(backend, BACKENDS, "backend")
    if f is None:
        return functools.partial(function, backend=backend)
    name = getattr(f, "__name__", "function")
    outer = dict(sys._getframe(1).f_locals)
    signature, shapes = read_signature(f, name, outer)

    def run(values: Sequence[object]) -> Any:
        given = dict(zip(shapes, values, strict=True))
        keyword_only = {p.name for p in signature.parameters.values() if p.kind is p.KEYWORD_ONLY}
        positional = [given[n] for n in shapes if n not in keyword_only]
        return f(*positional, **{n: given[n] for n in keyword_only})

    def record() -> Formula:
        graph = core.Graph()
        arguments = [Argument(n, shape, new_symbols(graph, n, shape)) for n, shape in shapes.items()]
        with recording(name):
            value = run([a.value for a in arguments])
        result = _result(name, value, f)
        with recording(name):
            return Formula(name, arguments, result, backend, f)

    compiled = Function(name, signature, record)
    functools.update_wrapper(compiled, f)
    return compiled


def compile(
    inputs: Mapping[str, object] | Sequence[object],
    outputs: object,
    *,
    name: str = "function",
    backend: str = "automatic",
) -> Function:
    """Compiled function of expressions that are made of symbols.

        x, a = sym.symbols("x[2] a")
        f = sym.compile([x, a], a * (x @ x))

    inputs: symbols in the order of the arguments, or a mapping from names to symbols."""
    given_choice(backend, BACKENDS, "backend")
    if not isinstance(name, str) or not name:
        raise InvalidArgument(f"compile: name = {name!r}: must be a non-empty text")
    if not isinstance(inputs, (Mapping, Sequence)) or isinstance(inputs, (str, bytes)):
        raise InvalidArgument(
            f"{name}: inputs = {shown_value(inputs)}: must be a list of symbols, or a mapping from names to "
            f"them"
        )
    given: list[Any] = list(inputs) if isinstance(inputs, Mapping) else []
    for label in given:
        if not isinstance(label, str) or not label.isidentifier():
            raise InvalidArgument(f"{name}: the input name {label!r}: must be one that an argument can have")
    named = inputs.items() if isinstance(inputs, Mapping) else [(None, value) for value in inputs]
    arguments: list[Argument] = []
    for key, value in named:
        symbol = convert(value, f"{name}: input {len(arguments)}")
        first = symbol.entries[0] if isinstance(symbol, Tensor) else symbol
        label = key or first.name.split("[")[0] or f"x{len(arguments)}"
        arguments.append(Argument(label, getattr(symbol, "shape", ()), symbol))
    if not arguments:
        raise TraceError(f"{name}: there are no inputs; a function needs at least one")
    if len({a.name for a in arguments}) < len(arguments):
        raise TraceError(f"{name}: two inputs have the same name; give a mapping from names to symbols")
    parameters = [inspect.Parameter(a.name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for a in arguments]
    with recording(name):
        formula = Formula(name, arguments, _result(name, outputs, None), backend)
    return Function(name, inspect.Signature(parameters), lambda: formula)
