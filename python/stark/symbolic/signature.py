"""Arguments of formulas: names and shapes from the annotations of a function, and their symbols."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from stark._core import TraceError
from stark._core import symbolic as core
from stark.symbolic.errors import formula_error
from stark.symbolic.tensor import Mat, Scalar, Vec, from_shape


@dataclass(frozen=True)
class ArgumentType:
    """Shape of an argument, made by Vector[n] and Matrix[r, c]; () for Real."""

    shape: tuple[int, ...]

    def __str__(self) -> str:
        return (
            "Real"
            if not self.shape
            else ("Vector" if len(self.shape) == 1 else "Matrix") + str(list(self.shape))
        )

    __repr__ = __str__  # in signatures of functions


def _checked(kind: str, shape: tuple[Any, ...], dimensions: int) -> ArgumentType:
    if len(shape) != dimensions or not all(isinstance(n, (int, np.integer)) and n > 0 for n in shape):
        need = "Vector[n]" if dimensions == 1 else "Matrix[rows, columns]"
        raise TraceError(f"{kind}{list(shape)}: need {need} with positive integers")
    return ArgumentType(tuple(int(n) for n in shape))


class Vector:
    """Annotation of an argument that is a vector: Vector[n]."""

    def __class_getitem__(cls, n: int) -> ArgumentType:
        return _checked("Vector", n if isinstance(n, tuple) else (n,), 1)


class Matrix:
    """Annotation of an argument that is a matrix: Matrix[rows, columns]."""

    def __class_getitem__(cls, shape: tuple[int, int]) -> ArgumentType:
        return _checked("Matrix", shape if isinstance(shape, tuple) else (shape,), 2)


Real = float


@dataclass(frozen=True)
class Argument:
    """One argument of a formula."""

    name: str
    shape: tuple[int, ...]
    value: Scalar | Vec | Mat  # its symbols

    @property
    def entries(self) -> list[Scalar]:
        return list(self.value.entries) if isinstance(self.value, (Vec, Mat)) else [self.value]


def new_symbols(graph: core.Graph, name: str, shape: tuple[int, ...]) -> Scalar | Vec | Mat:
    """New inputs of a graph in the shape of an argument, named x, x[0] or x[0,1]."""
    if not shape:
        return graph.input("element", name)
    entries = [graph.input("element", f"{name}[{','.join(map(str, i))}]") for i in np.ndindex(*shape)]
    return from_shape(entries, shape)


def symbols(text: str, graph: core.Graph | None = None) -> object:
    """Symbols of one new formula, or of the formula of `graph`: symbols("a b x[3] F[2,2]") gives scalars, a
    vector and a matrix. One symbol is returned as it is, several as a tuple."""
    graph = core.Graph() if graph is None else graph
    parts = re.findall(r"[^\s,\[\]]+(?:\[[^\]]*\])?", text)
    result = []
    for part in parts:
        match = re.fullmatch(r"([^\W\d]\w*)(?:\[\s*([1-9]\d*)\s*(?:,\s*([1-9]\d*)\s*)?\])?", part)
        if match is None:
            raise TraceError(f"symbols: {part!r} is not a name such as a, x[3] or F[2,2]")
        result.append(new_symbols(graph, match[1], tuple(int(n) for n in match.groups()[1:] if n)))
    if not result:
        raise TraceError("symbols: no names were given")
    return result[0] if len(result) == 1 else tuple(result)


def read_signature(
    function: Callable[..., object], formula: str, outer: dict[str, object]
) -> tuple[inspect.Signature, dict[str, tuple[int, ...]]]:
    """The signature of a function and the shape of every argument. `outer` has the names that annotations may
    use besides globals."""
    try:
        signature = inspect.signature(function, eval_str=True, locals=outer)
    except TraceError as error:
        raise formula_error(formula, str(error), function) from None
    except NameError as error:
        raise formula_error(formula, f"an annotation could not be read, {error}", function) from None
    shapes = {}
    for name, parameter in signature.parameters.items():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            raise formula_error(formula, f"*{name}: the number of arguments must be fixed", function)
        if name in ("wrt", "self"):
            raise formula_error(formula, f"an argument must not be called '{name}'", function)
        kind = parameter.annotation
        if kind in (float, int):
            kind = ArgumentType(())
        if not isinstance(kind, ArgumentType):
            given = "no annotation" if kind is parameter.empty else f"the annotation {kind!r}"
            raise formula_error(
                formula,
                f"argument '{name}' has {given}; need float, sym.Vector[n] or sym.Matrix[rows, columns]",
                function,
            )
        shapes[name] = kind.shape
    if not shapes:
        raise formula_error(formula, "there are no arguments; a formula needs at least one", function)
    return signature, shapes
