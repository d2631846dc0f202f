"""Arguments of formulas, read from the annotations of the user's function."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, get_args, get_origin

from stark._core import TraceError
from stark.formulas.frames import Frame
from stark.formulas.kinematics import Point, Stencil
from stark.formulas.parameters import Declaration, Parameter
from stark.formulas.parameters import parameter as declare
from stark.symbolic.errors import formula_error
from stark.symbolic.signature import ArgumentType, evaluated_signature
from stark.symbolic.tensor import Scalar

if TYPE_CHECKING:
    # What the arguments are while a formula is recorded.
    Time: TypeAlias = Scalar
    TimeStep: TypeAlias = Scalar
else:

    class Time:
        """Annotation of an argument that is the time at the end of the step [s]."""

    class TimeStep:
        """Annotation of an argument that is the length of the step [s]."""


@dataclass(frozen=True)
class PointArgument:
    """A point or a stencil of points."""

    name: str
    kind: type[Point] | type[Stencil]

    @property
    def noun(self) -> str:
        """'a point', 'an edge of 2 points'."""
        if self.kind is Point:
            return "a point"
        name = self.kind.__name__.lower()
        article = "an" if name[0] in "aeiou" else "a"
        return f"{article} {name} of {self.kind.point_count} points"


@dataclass(frozen=True)
class FrameArgument:
    """A frame of a body, a patch or the world."""

    name: str


@dataclass(frozen=True)
class ClockArgument:
    """Time or time step."""

    name: str
    quantity: str  # "time" or "time_step"


Argument = PointArgument | FrameArgument | ClockArgument | Parameter

_CLOCKS = {Time: "time", TimeStep: "time_step"}
_CHOICES = (
    "stark.Point, stark.Edge, stark.Triangle, stark.Tetrahedron, stark.Hinge, stark.Stencil[k], stark.Frame, "
    "float, stark.Vec3, stark.Mat3, stark.Time or stark.TimeStep"
)


def _stencil_of_annotated(annotation: Any) -> Any:
    """Stencil[k] of Annotated[Stencil, k], which type checkers understand; everything else as it is."""
    if get_origin(annotation) is not Annotated or get_args(annotation)[0] is not Stencil:
        return annotation
    sizes = get_args(annotation)[1:]
    return Stencil.__class_getitem__(*sizes) if len(sizes) == 1 else annotation


def signature_of(
    function: Callable[..., object], formula: str, outer: Mapping[str, object]
) -> inspect.Signature:
    """Signature with evaluated annotations. `outer` has the names that annotations may use besides
    globals."""
    try:
        signature = evaluated_signature(function, outer, _stencil_of_annotated)
    except TraceError as error:
        raise formula_error(formula, str(error), function) from None
    except NameError as error:
        raise formula_error(formula, f"an annotation could not be read, {error}", function) from None
    for name, parameter in signature.parameters.items():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            raise formula_error(
                formula, f"*{name}: the number of arguments must be fixed; use stark.Stencil[k]", function
            )
    return signature


def read_clock(parameter: inspect.Parameter) -> ClockArgument | None:
    """The argument if it is annotated stark.Time or stark.TimeStep."""
    kind = parameter.annotation
    return (
        ClockArgument(parameter.name, _CLOCKS[kind]) if isinstance(kind, type) and kind in _CLOCKS else None
    )


def read_parameter(
    parameter: inspect.Parameter, formula: str, function: Callable[..., object], choices: str
) -> Parameter:
    """A parameter with its default; its annotation says the shape, a missing one is refused."""
    kind, name = parameter.annotation, parameter.name
    is_whole = kind is int
    if kind in (float, int, Scalar):
        kind = ArgumentType(())
    if not isinstance(kind, ArgumentType):
        given = "no annotation" if kind is parameter.empty else f"the annotation {kind!r}"
        raise formula_error(formula, f"argument '{name}' has {given}: must be {choices}", function)
    default = None if parameter.default is parameter.empty else parameter.default
    declaration = default if isinstance(default, Declaration) else declare(default)
    return Parameter(name, kind.shape, declaration, is_whole)


def read_arguments(
    function: Callable[..., object], formula: str, outer: Mapping[str, object], taken: frozenset[str]
) -> tuple[inspect.Signature, list[Argument]]:
    """Signature and arguments of an energy. `taken`: names that parameters must not have."""
    signature = signature_of(function, formula, outer)
    arguments: list[Argument] = []
    for name, parameter in signature.parameters.items():
        kind = parameter.annotation
        clock = read_clock(parameter)
        if clock is not None:
            arguments.append(clock)
        elif kind is Stencil:
            raise formula_error(formula, f"argument '{name}': write stark.Stencil[k], k points", function)
        elif isinstance(kind, type) and issubclass(kind, (Point, Stencil)):
            arguments.append(PointArgument(name, kind))
        elif kind is Frame:
            arguments.append(FrameArgument(name))
        else:
            read = read_parameter(parameter, formula, function, _CHOICES)
            if name in taken:
                raise formula_error(
                    formula,
                    f"a parameter must not be called '{name}', a name that is taken; "
                    f"choose another name"
                    + (f", or annotate it stark.{_clock_name(name)}" if name in _CLOCKS.values() else ""),
                    function,
                )
            arguments.append(read)
    if not any(isinstance(a, (PointArgument, FrameArgument)) for a in arguments):
        raise formula_error(
            formula, "no argument is a point, a stencil or a frame; an energy acts on at least one", function
        )
    return signature, arguments


def _clock_name(name: str) -> str:
    return next(kind.__name__ for kind, quantity in _CLOCKS.items() if quantity == name)
