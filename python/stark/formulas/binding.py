"""Energies on points with values: which points, frames and numbers the arguments of a formula got."""

from __future__ import annotations

import functools
import inspect
import threading
from collections.abc import Callable, Hashable, Sequence
from typing import Any, Self

from stark._core import InvalidArgument
from stark.body_kinds import has_pose
from stark.formulas import tracing
from stark.formulas.arguments import Argument, FrameArgument, PointArgument
from stark.formulas.captured import captured
from stark.formulas.frames import KINDS
from stark.formulas.kinematics import Point
from stark.formulas.parameters import Declaration, Parameter, Value, numbers_of, read_value
from stark.formulas.statistics import FormulaStatistics
from stark.handle import BodyHandle
from stark.joined_points import JoinedPoints
from stark.selections import FrameHandle, Points, Stencils, rigid_frame, world_points
from stark.symbolic.errors import definition_of
from stark.symbolic.graph import ExpressionGraph


class RecordedEnergy:
    """An energy as a formula: a function that is recorded when it is first bound."""

    is_read: bool = False
    """Whether it comes from a file, without a function."""

    def __init__(
        self,
        function: Callable[..., object],
        signature: inspect.Signature,
        arguments: Sequence[Argument],
        translation_invariant: bool | None,
    ) -> None:
        self.name: str = function.__name__
        self.doc: str = inspect.getdoc(function) or self.name
        self.arguments: tuple[Argument, ...] = tuple(arguments)
        self.function = function
        self._declared_invariant = translation_invariant
        self._traces: dict[tuple[tuple[str, ...], tuple[str, ...]], tracing.Trace] = {}
        self._captured: dict[str, Hashable] = {}
        self._lock = threading.Lock()
        functools.update_wrapper(self, function)  # type: ignore[arg-type]
        self.__signature__: inspect.Signature = _call_signature(signature, self.arguments)

    def trace(self, frames: Sequence[str] = (), spanning: Sequence[str] = ()) -> tracing.Trace:
        """The recorded formula; recorded once for each combination of kinds of frames, and of stencil
        arguments whose points belong to several bodies, and again where a number has changed that the
        function takes from around it."""
        kinds = tuple(frames) or ("sites",) * sum(isinstance(a, FrameArgument) for a in self.arguments)
        key = kinds, tuple(spanning)
        with self._lock:
            if (now := captured(self.function)) != self._captured:
                self._traces, self._captured = {}, now
            if key not in self._traces:
                self._traces[key] = tracing.trace(self.name, self.function, self.arguments, *key)
            return self._traces[key]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters in the order of the arguments."""
        return tuple(a for a in self.arguments if isinstance(a, Parameter))

    def graph(self) -> ExpressionGraph:
        """The recorded operations; print it for a listing of the formula."""
        return self.trace().graph

    @property
    def statistics(self) -> FormulaStatistics:
        """Counts of operations and instructions by order, back end, how the Hessian was formed."""
        return FormulaStatistics.of(self.trace().formula)

    @property
    def location(self) -> str:
        """Where the function is defined."""
        return definition_of(self.function)


class BoundEnergy:
    """An energy on points with values."""

    def __init__(self, energy: RecordedEnergy, given: dict[str, Any]) -> None:
        self.energy = energy
        self.frames: tuple[str, ...] = ()
        self.constants: dict[str, Any] = {}  # of patch frames
        columns: list[Any] = []
        spanning: list[str] = []  # stencils whose points belong to several bodies
        for argument in energy.arguments:
            if isinstance(argument, PointArgument):
                found = self._point_columns(argument, given[argument.name])
                spanning += [argument.name] if _spans(found) else []
                columns += found
            elif isinstance(argument, FrameArgument):
                columns += self._frame_columns(argument, given[argument.name])
        self.element_count: int = self._count(columns)
        self.trace: tracing.Trace = energy.trace(self.frames, spanning)
        self.columns: list[Any] = [columns[p] for p in self.trace.kept]
        """A selection of points for each point of the formula."""
        self.values: dict[str, Value] = {p.name: self._value(p, given) for p in energy.parameters}
        self._check_outside_totals()

    def copy(self) -> Self:
        """The same with values of its own."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other.values = {name: Value(v.array.copy(), v.per_element) for name, v in self.values.items()}
        return other

    @property
    def name(self) -> str:
        return self.energy.name

    @property
    def bodies(self) -> list[BodyHandle]:
        """Bodies it acts on, each once."""
        return list(dict.fromkeys(body for column in self.columns for body in column.bodies))

    def core_values(self) -> dict[str, tuple[Any, bool]]:
        """All values as the core reads them: name -> (numbers, per_element)."""
        values = {name: (value.numbers, value.per_element) for name, value in self.values.items()}
        values |= {name: (numbers, False) for name, numbers in self.constants.items()}
        return {name: value for name, value in values.items() if name in self.trace.parameters}

    @property
    def translation_invariant(self) -> bool:
        """Whether forces on the points sum to zero: as declared, else if the formula proves it."""
        declared = self.energy._declared_invariant
        # The reduced projection exists for two to four points.
        possible = 2 <= len(self.columns) <= 4
        return possible and (self.trace.translation_invariant if declared is None else declared)

    def _point_columns(self, argument: PointArgument, given: Any) -> list[Any]:
        owner = f"{self.name}: argument '{argument.name}'"
        wanted = argument.kind.point_count
        if isinstance(given, BodyHandle):
            raise InvalidArgument(
                f"{owner} is the body '{given.name}': must be {argument.noun}; choose some of its points, "
                f"for instance {_example(argument)}"
            )
        if isinstance(given, (Points, JoinedPoints, Stencils)):
            columns = list(given.columns) if isinstance(given, Stencils) else [given]
        elif argument.kind is Point:
            columns = [self._world_points(argument, given)]
        elif isinstance(given, (tuple, list)):
            columns = [c for item in given for c in self._single(argument, item)]
        else:
            raise InvalidArgument(
                f"{owner} = {given!r}: must be {argument.noun}, such as {_example(argument)}"
            )
        if len(columns) != wanted:
            raise InvalidArgument(
                f"{owner} is {given!r}: has {counted(len(columns), 'point')} in a stencil, must be "
                f"{argument.noun}"
            )
        return columns

    def _single(self, argument: PointArgument, given: Any) -> list[Any]:
        if isinstance(given, Stencils):
            return list(given.columns)
        return [given if isinstance(given, (Points, JoinedPoints)) else self._world_points(argument, given)]

    def _world_points(self, argument: PointArgument, given: Any) -> Any:
        point = Parameter(argument.name, (3,), Declaration(None, "m", None, None, None, None, ""))
        return world_points(numbers_of(self.name, point, given))

    def _frame_columns(self, argument: FrameArgument, given: Any) -> list[Any]:
        handle = rigid_frame(given, (0.0, 0.0, 0.0), None) if _is_rigid(given) else given
        if not isinstance(handle, FrameHandle):
            raise InvalidArgument(
                f"{self.name}: argument '{argument.name}' = {given!r}: must be a frame, such as box.frame(), "
                f"cloth.frame(vertices) or stark.world_frame()"
            )
        self.frames += (handle.kind,)
        self.constants |= {f"{argument.name}.{key}": value for key, value in handle.constants.items()}
        assert len(handle.columns) == KINDS[handle.kind].point_count
        return list(handle.columns)

    def _count(self, columns: Sequence[Any]) -> int:
        counts = {len(c) for c in columns}
        if 0 in counts:
            empty = next(c for c in columns if len(c) == 0)
            raise InvalidArgument(f"{self.name}: {empty!r}: must have at least one; check the selection")
        if len(counts - {1}) > 1:
            sizes = " and ".join(repr(c) for c in columns if len(c) != 1)
            raise InvalidArgument(f"{self.name}: acts on {sizes}: must all be equally many, or one")
        return max(counts)

    def _check_outside_totals(self) -> None:
        totals = self.trace.totals
        for name, value in self.values.items():
            if totals is not None and value.per_element and name in totals.outside:
                raise InvalidArgument(
                    f"{self.name}: '{name}' has a value for each of {self.element_count} elements, but "
                    f"occurs outside of stark.total(...): must be one value for all of them"
                )

    def _value(self, parameter: Parameter, given: dict[str, Any]) -> Value:
        value = given.get(parameter.name, parameter.declaration.default)
        if value is None:
            rule = parameter.declaration.rule
            raise InvalidArgument(
                f"{self.name}: {parameter.describe()} has no value: must be given"
                + (f", {rule}" if rule else "")
                + (f"; {parameter.declaration.doc}" if parameter.declaration.doc else "")
            )
        if callable(value):
            raise InvalidArgument(
                f"{self.name}: {parameter.describe()} = {value!r}: must be its value at time 0; assign the "
                f"function of the time to what scene.add returns: energy.{parameter.name} = ..."
            )
        return read_value(self.name, parameter, value, self.element_count)


def _spans(columns: Sequence[Any]) -> bool:
    """Whether points of any of the stencils belong to different bodies."""
    if len(columns) < 2 or 0 in map(len, columns):
        return False
    owners = [column.owners for column in columns]
    lengths = {len(each) for each in owners} - {1}
    if len(lengths) > 1:
        return False  # refused when the elements are counted
    return any((each != owners[0]).any() for each in owners[1:])


def _is_rigid(given: Any) -> bool:
    return isinstance(given, BodyHandle) and has_pose(given)


def _call_signature(signature: inspect.Signature, arguments: Sequence[Argument]) -> inspect.Signature:
    """What a call has to give: points and frames, parameters as keywords or in order, no clocks."""
    shown = []
    for argument in arguments:
        if isinstance(argument, (PointArgument, FrameArgument)):
            shown.append(signature.parameters[argument.name].replace(default=inspect.Parameter.empty))
        elif isinstance(argument, Parameter):
            # Required ones get None, so that the message can name unit and range.
            shown.append(
                inspect.Parameter(
                    argument.name, inspect.Parameter.KEYWORD_ONLY, default=argument.declaration.default
                )
            )
    positional = [p for p in shown if p.kind is not inspect.Parameter.KEYWORD_ONLY]
    keywords = [p for p in shown if p.kind is inspect.Parameter.KEYWORD_ONLY]
    return inspect.Signature([*positional, *keywords])


def _example(argument: PointArgument) -> str:
    return {
        "Point": "cloth.vertices",
        "Edge": "cloth.edges",
        "Triangle": "cloth.faces",
        "Tetrahedron": "solid.tetrahedra",
        "Hinge": "cloth.hinges",
    }.get(argument.kind.__name__, "stark.stencils(body, indices)")


def counted(n: int, what: str) -> str:
    """ "1 point", "2 points"."""
    return f"{n} {what}{'' if n == 1 else 's'}"
