"""Arguments of formulas: names and shapes from the annotations of a function, and their symbols."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, get_args, get_origin

import numpy as np

from stark._core import InvalidArgument, TraceError
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
        raise TraceError(f"{kind}{list(shape)}: must be {need} with positive integers")
    return ArgumentType(tuple(int(n) for n in shape))


class Vector:
    """Annotation of an argument that is a vector: Vector[n]. Type checkers take no numbers in brackets;
    for them write Vec2, Vec3, Vec4 or Annotated[Vec, n], which mean the same."""

    def __class_getitem__(cls, n: int) -> ArgumentType:
        return _checked("Vector", n if isinstance(n, tuple) else (n,), 1)


class Matrix:
    """Annotation of an argument that is a matrix: Matrix[rows, columns]. For type checkers write Mat2, Mat3
    or Annotated[Mat, rows, columns], which mean the same."""

    def __class_getitem__(cls, shape: tuple[int, int]) -> ArgumentType:
        return _checked("Matrix", shape if isinstance(shape, tuple) else (shape,), 2)


Real = float

if TYPE_CHECKING:
    # What the arguments are while a formula is recorded.
    Vec2: TypeAlias = Vec
    Vec3: TypeAlias = Vec
    Vec4: TypeAlias = Vec
    Mat2: TypeAlias = Mat
    Mat3: TypeAlias = Mat
else:
    Vec2, Vec3, Vec4 = Vector[2], Vector[3], Vector[4]
    Mat2, Mat3 = Matrix[2, 2], Matrix[3, 3]


def _without_annotated(annotation: Any) -> Any:
    """Vector[n] of Annotated[Vec, n], Matrix[r, c] of Annotated[Mat, r, c], the type alone of
    Annotated[float, ...]; everything else as it is."""
    if get_origin(annotation) is not Annotated:
        return annotation
    base, *sizes = get_args(annotation)
    if base is Vec:
        return _checked("Vector", tuple(sizes), 1)
    if base is Mat:
        return _checked("Matrix", tuple(sizes), 2)
    return base if base in (float, int, Scalar) else annotation


def evaluated_signature(
    function: Callable[..., object], outer: Mapping[str, object], read: Callable[[Any], Any] = lambda a: a
) -> inspect.Signature:
    """The signature of a function with evaluated annotations. `outer` has the names that annotations may use
    besides globals; `read` is applied to annotations that are left. Raises NameError and TraceError;
    InvalidArgument if it is no function, as in @stark.energy("name")."""
    if not inspect.isroutine(function):
        raise InvalidArgument(f"got {function!r}: must be a function; write the decorator above a def")
    signature = inspect.signature(function, eval_str=True, locals=outer)
    return signature.replace(
        parameters=[
            parameter.replace(annotation=read(_without_annotated(parameter.annotation)))
            for parameter in signature.parameters.values()
        ]
    )


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


def symbols(text: str, graph: core.Graph | None = None) -> Any:
    """Symbols of one new formula, or of the formula of `graph`: symbols("a b x[3] F[2,2]") gives scalars, a
    vector and a matrix. One symbol is returned as it is, several as a tuple."""
    if not isinstance(text, str):
        raise TraceError(f"symbols: got {text!r}: must be a text such as 'a b x[3] F[2,2]'")
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
        signature = evaluated_signature(function, outer)
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
                f"argument '{name}' has {given}: must be float, sym.Vector[n] or sym.Matrix[rows, columns]",
                function,
            )
        shapes[name] = kind.shape
    if not shapes:
        raise formula_error(formula, "there are no arguments; a formula needs at least one", function)
    return signature, shapes
