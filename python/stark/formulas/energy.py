"""``@stark.energy``: energies written in Python.

    @stark.energy
    def spring(e: stark.Edge, stiffness: float = stark.parameter(10.0, unit="N/m", min=0.0)):
        return 0.5 * stiffness * (e.length - e.rest_length) ** 2

    springs = scene.add(spring(cloth.edges, stiffness=20.0))

The function runs once on symbols, when it is first bound; the core differentiates and compiles it."""

from __future__ import annotations

import functools
import inspect
import sys
import threading
from collections.abc import Callable, Sequence
from typing import Any

from stark._core import InvalidArgument
from stark.bodies import Body, RigidBody
from stark.formulas import tracing
from stark.formulas.arguments import Argument, FrameArgument, PointArgument, read_arguments
from stark.formulas.frames import KINDS, Frame
from stark.formulas.handle import RESERVED
from stark.formulas.inspection import FormulaStatistics
from stark.formulas.kinematics import Point, Stencil
from stark.formulas.parameters import Declaration, Parameter, Value, numbers_of, read_value
from stark.formulas.points import FrameHandle, Points, Stencils, rigid_frame, world_points
from stark.symbolic.errors import definition_of
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Scalar, Tensor


class EnergyFormula:
    """An energy as a formula: what ``@stark.energy`` makes of a function. Calling it with points and values
    binds it; ``scene.add`` takes the result."""

    def __init__(
        self,
        function: Callable[..., object],
        signature: inspect.Signature,
        arguments: Sequence[Argument],
        translation_invariant: bool | None,
    ) -> None:
        self.name = function.__name__
        self.doc = inspect.getdoc(function) or self.name
        self.arguments = tuple(arguments)
        self.function = function
        self._declared_invariant = translation_invariant
        self._traces: dict[tuple[str, ...], tracing.Trace] = {}
        self._lock = threading.Lock()
        functools.update_wrapper(self, function)
        self.__signature__ = _call_signature(signature, self.arguments)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """The energy on points with values. Inside another formula: the expression of it."""
        if any(isinstance(a, (Scalar, Tensor, Point, Stencil, Frame)) for a in (*args, *kwargs.values())):
            return self.function(*args, **kwargs)
        try:
            bound = self.__signature__.bind(*args, **kwargs)
        except TypeError as error:
            raise InvalidArgument(f"{self.name}{self.__signature__}: {error}") from None
        return Binding(self, bound.arguments)

    def trace(self, frames: Sequence[str] = ()) -> tracing.Trace:
        """The recorded formula; recorded once for each combination of kinds of frames."""
        key = tuple(frames) or ("sites",) * sum(isinstance(a, FrameArgument) for a in self.arguments)
        with self._lock:
            if key not in self._traces:
                self._traces[key] = tracing.trace(self.name, self.function, self.arguments, key)
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

    def check(self, *args: Any, **kwargs: Any) -> Any:
        """Tests the formula on points and values, given as in a call: derivatives against finite differences,
        invariance, definiteness, finite values near the start. Returns a report; print it."""
        from stark.formulas.checks import check

        binding = args[0] if len(args) == 1 and isinstance(args[0], Binding) else self(*args, **kwargs)
        return check(binding)

    def benchmark(self, *args: Any, **kwargs: Any) -> dict[str, float]:
        """Nanoseconds per element for "value", "gradient" and "hessian" on one thread, measured on the points
        and values given as in a call."""
        from stark.formulas.inspection import benchmark

        binding = args[0] if len(args) == 1 and isinstance(args[0], Binding) else self(*args, **kwargs)
        return benchmark(binding)

    @property
    def location(self) -> str:
        """Where the function is defined."""
        return definition_of(self.function)

    def __repr__(self) -> str:
        return f"<stark.energy {self.name}{self.__signature__}>"


_ATTRIBUTES = frozenset({"energy", "frames", "constants", "element_count", "trace", "columns", "values"})


class Binding:
    """An energy on points with values, to be added to a scene."""

    def __init__(self, energy: EnergyFormula, given: dict[str, Any]) -> None:
        self.energy = energy
        self.frames: tuple[str, ...] = ()
        self.constants: dict[str, Any] = {}  # of patch frames
        columns: list[Points] = []
        for argument in energy.arguments:
            if isinstance(argument, PointArgument):
                columns += self._point_columns(argument, given[argument.name])
            elif isinstance(argument, FrameArgument):
                columns += self._frame_columns(argument, given[argument.name])
        self.element_count = self._count(columns)
        self.trace = energy.trace(self.frames)
        self.columns = [columns[p] for p in self.trace.kept]
        """A selection of points for each point of the formula."""
        self.values = {p.name: self._value(p, given) for p in energy.parameters}

    def copy(self) -> Binding:
        """The same with values of its own."""
        other = object.__new__(Binding)
        other.__dict__.update(self.__dict__)
        other.values = {name: Value(v.array.copy(), v.per_element) for name, v in self.values.items()}
        return other

    def __setattr__(self, name: str, value: Any) -> None:
        # `pull = magnet(...); pull.center = ...` without scene.add would do nothing.
        if name not in _ATTRIBUTES:
            raise AttributeError(self._not_added(name))
        super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name if name.startswith("_") else self._not_added(name))

    def _not_added(self, attribute: str) -> str:
        return (
            f"{self.name} is not in a scene yet, so it has no '{attribute}': add it, and use what "
            f"scene.add returns"
        )

    @property
    def name(self) -> str:
        return self.energy.name

    @property
    def bodies(self) -> list[Body]:
        """Bodies it acts on, each once."""
        return list(dict.fromkeys(c.body for c in self.columns if c.body is not None))

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

    def _point_columns(self, argument: PointArgument, given: Any) -> list[Points]:
        owner = f"{self.name}: argument '{argument.name}'"
        wanted = argument.kind.point_count
        if isinstance(given, Body):
            raise InvalidArgument(
                f"{owner} is the body '{given.name}': must be {argument.noun}; choose some of its points, "
                f"for instance {_example(argument)}"
            )
        if isinstance(given, (Points, Stencils)):
            columns = [given] if isinstance(given, Points) else list(given.columns)
        elif argument.kind is Point:
            columns = [world_points(_numbers(owner, given))]
        elif isinstance(given, (tuple, list)):
            columns = [c for item in given for c in self._single(owner, item)]
        else:
            raise InvalidArgument(
                f"{owner} = {given!r}: must be {argument.noun}, such as {_example(argument)}"
            )
        if len(columns) != wanted:
            raise InvalidArgument(
                f"{owner} is {given!r}: has {_counted(len(columns), 'point')} in a stencil, must be "
                f"{argument.noun}"
            )
        return columns

    def _single(self, owner: str, given: Any) -> list[Points]:
        if isinstance(given, Stencils):
            return list(given.columns)
        return [given if isinstance(given, Points) else world_points(_numbers(owner, given))]

    def _frame_columns(self, argument: FrameArgument, given: Any) -> list[Points]:
        handle = rigid_frame(given, (0.0, 0.0, 0.0), None) if isinstance(given, RigidBody) else given
        if not isinstance(handle, FrameHandle):
            raise InvalidArgument(
                f"{self.name}: argument '{argument.name}' = {given!r}: must be a frame, such as box.frame(), "
                f"cloth.frame(vertices) or stark.world_frame()"
            )
        self.frames += (handle.kind,)
        self.constants |= {f"{argument.name}.{key}": value for key, value in handle.constants.items()}
        assert len(handle.columns) == KINDS[handle.kind].point_count
        return list(handle.columns)

    def _count(self, columns: Sequence[Points]) -> int:
        counts = {len(c) for c in columns}
        if 0 in counts:
            empty = next(c for c in columns if len(c) == 0)
            raise InvalidArgument(f"{self.name}: {empty!r}: must have at least one; check the selection")
        if len(counts - {1}) > 1:
            sizes = " and ".join(repr(c) for c in columns if len(c) != 1)
            raise InvalidArgument(f"{self.name}: acts on {sizes}: must all be equally many, or one")
        return max(counts)

    def _value(self, parameter: Parameter, given: dict[str, Any]) -> Value:
        value = given.get(parameter.name, parameter.declaration.default)
        if value is None:
            rule = parameter.declaration.rule
            raise InvalidArgument(
                f"{self.name}: {parameter.describe()} has no value: must be given"
                + (f", {rule}" if rule else "")
                + (f"; {parameter.declaration.doc}" if parameter.declaration.doc else "")
            )
        return read_value(self.name, parameter, value, self.element_count)

    def check(self) -> Any:
        """As ``EnergyFormula.check``."""
        return self.energy.check(self)

    def benchmark(self) -> dict[str, float]:
        """As ``EnergyFormula.benchmark``."""
        return self.energy.benchmark(self)

    def __repr__(self) -> str:
        return f"<{self.name} on {_counted(self.element_count, 'element')}; add it with scene.add>"


def energy(
    function: Callable[..., object] | None = None, /, *, translation_invariant: bool | None = None
) -> Any:
    """Decorator: makes an energy [J] of a function of points, stencils, frames and parameters.

    The annotations say what the arguments are: stark.Point, Edge, Triangle, Tetrahedron, Hinge, Stencil[k],
    Frame for what it acts on; float, Vec3, Mat3 for parameters, whose defaults may be stark.parameter(...);
    Time and TimeStep. translation_invariant: whether moving all points alike leaves the energy as it is;
    found out from the formula if None."""
    if function is None:
        return functools.partial(energy, translation_invariant=translation_invariant)
    name = getattr(function, "__name__", "energy")
    outer = dict(sys._getframe(1).f_locals)
    signature, arguments = read_arguments(function, name, outer, RESERVED)
    return EnergyFormula(function, signature, arguments, translation_invariant)


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


def _numbers(owner: str, given: Any) -> Any:
    point = Parameter(owner, (3,), Declaration(None, "m", None, None, None, None, ""))
    return numbers_of(owner, point, given)


def _example(argument: PointArgument) -> str:
    return {
        "Point": "cloth.vertices",
        "Edge": "cloth.edges",
        "Triangle": "cloth.faces",
        "Tetrahedron": "solid.tetrahedra",
        "Hinge": "cloth.hinges",
    }.get(argument.kind.__name__, "stark.stencils(body, indices)")


def _counted(n: int, what: str) -> str:
    return f"{n} {what}{'' if n == 1 else 's'}"
