"""What an actuator is: the energy of a time step as a function of a coordinate of a joint, its rate and
values.

    @stark.actuator
    def hardening_spring(c: stark.Coordinate, stiffness: float = stark.parameter(unit="N m/rad^3", min=0.0)):
        return 0.25 * stiffness * c.q**4

The function runs once on symbols. The effort is minus the derivative of the energy by the coordinate.
Built-in actuators (src/stark/models/actuators) are definitions like these."""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from stark import _core
from stark._core import TraceError
from stark.formulas.arguments import ClockArgument, read_clock, read_parameter, signature_of
from stark.formulas.captured import captured, warn_of_changes
from stark.formulas.kinematics import Inputs
from stark.formulas.parameters import Parameter
from stark.formulas.pickling import PickledByName
from stark.formulas.tracing import clock_symbol, parameter_symbols, scalar_result
from stark.symbolic.errors import definition_of, formula_error, recording
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Scalar, Tensor, convert

MAX_COORDINATES = 3
# Attributes of Actuator, which values cannot be.
RESERVED = frozenset(
    {
        *("name", "kind", "formula", "joint", "coordinates", "parameters", "units"),
        *("effort", "torque", "force", "power", "enabled"),
    }
)
_CHOICES = "stark.Coordinate, stark.Memory, float, stark.Time or stark.TimeStep"


class Coordinate:
    """A coordinate of a joint inside the formula of an actuator [rad, m]. Angles count full turns; within a
    step they are taken to change by half a turn at most."""

    def __init__(self, inputs: Inputs, index: int, label: str) -> None:
        self._inputs, self._index, self._label = inputs, index, label

    @property
    def q(self) -> Scalar:
        """At the end of the time step; what is solved for."""
        return self.q_start + self.dq

    @property
    def q_start(self) -> Scalar:
        """At the start of the time step."""
        return self._data("coordinate", "q_start", "coordinate at the start of the step")

    @property
    def dq(self) -> Scalar:
        """Change within the time step."""
        value: Scalar = self._inputs.builder.x(0)[self._index]
        self._inputs.builder.set_name(value, f"{self._label}.dq")
        self._inputs.sources[value.id] = ("x", 0, self._index)
        self._inputs.point_of[value.id] = self._index
        return value

    @property
    def rate(self) -> Scalar:
        """Rate of the time step, dq / h [rad/s, m/s]."""
        h = self._inputs.time_step
        self._inputs.builder.set_name(h, "time_step")
        return self.dq / h

    @property
    def rate_start(self) -> Scalar:
        """Rate of the step before; at time 0 that of the initial velocities."""
        return self._data("rate", "rate_start", "rate of the coordinate in the step before")

    def _data(self, kind: str, shown: str, doc: str) -> Scalar:
        value: Scalar = self._inputs.builder.data(f"{kind}.{self._index}", 1, "", doc)[0]
        self._inputs.builder.set_name(value, f"{self._label}.{shown}")
        self._inputs.note([value], f"{kind}.{self._index}")
        self._inputs.point_of[value.id] = self._index
        return value

    def __repr__(self) -> str:
        return f"<stark.Coordinate {self._label}>"


if TYPE_CHECKING:
    Memory: TypeAlias = Scalar  # what the argument is while a formula is recorded
else:

    class Memory:
        """Annotation of an argument that is a number kept from step to step, zero at first; ``stark.act(...,
        remember={"name": value})`` says what it becomes at the end of a step."""


@dataclass(frozen=True)
class Actuation:
    """What ``stark.act`` returns."""

    energy: Any
    hold: tuple[Any, ...]
    limit: tuple[Any, ...]
    remember: Mapping[str, Any]


def act(
    energy: Any = 0.0, *, hold: Any = (), limit: Any = (), remember: Mapping[str, Any] | None = None
) -> Actuation:
    """Result of a function with ``@stark.actuator`` that does more than return an energy [J].

    hold: residuals that are held at zero; limit: residuals that are kept at or below zero; each one number or
    a list, in the unit of the first coordinate, within the tolerances of joints. remember: what the arguments
    that are ``stark.Memory`` become at the end of the step."""
    return Actuation(energy, _listed(hold), _listed(limit), dict(remember or {}))


def _listed(given: Any) -> tuple[Any, ...]:
    return tuple(given) if isinstance(given, (list, tuple)) else (given,)


@dataclass(frozen=True)
class ActuatorFormula(PickledByName):
    """An actuator as a formula: what ``@stark.actuator`` makes of a function, or a built-in one.
    ``joint.add_actuator`` takes it."""

    KIND: ClassVar[str] = "actuator"

    name: str
    doc: str
    core: _core.ActuatorDefinition
    outputs: ExpressionGraph | None = field(default=None, compare=False)
    location: str = field(default="", compare=False)
    row_count: int = 0
    """Values that it holds or limits; not of built-in actuators."""
    one_sided: tuple[bool, ...] = field(default=(), compare=False)
    """Which of them it limits."""
    memories: tuple[str, ...] = field(default=(), compare=False)
    parameters: tuple[Parameter, ...] = field(default=(), compare=False)
    sources: Mapping[int, tuple[str, int, int]] = field(default_factory=dict, compare=False)
    """What the inputs of the graph are, by number: of what, 0, which component."""
    recorded: _core.Formula | None = field(default=None, compare=False)
    """The formula as it was recorded; not of built-in actuators."""
    function: Callable[..., Any] | None = field(default=None, compare=False, repr=False)
    """That it was made of, by whose name it is pickled; not of built-in actuators and those of documents."""
    numbers: Mapping[str, Hashable] = field(default_factory=dict, compare=False, repr=False)
    """What the function took from around it when it was recorded."""

    def warn_of_changes(self) -> None:
        """Of numbers around its function that are not what they were when it was recorded."""
        if self.function is not None:
            warn_of_changes(self.name, "actuator", self.function, self.numbers, self.location)

    def _finder(self) -> Callable[[str], ActuatorFormula]:
        return built_in

    @property
    def coordinate_count(self) -> int:
        """How many coordinates it acts on."""
        return self.core.coordinate_count

    def graph(self) -> ExpressionGraph:
        """The recorded energy, residuals and memories; print it for a listing. Not of built-in actuators."""
        if self.outputs is None:
            raise TraceError(
                f"actuator '{self.name}' is built in: its formula is in src/stark/models/actuators"
            )
        return self.outputs

    def __repr__(self) -> str:
        return f"<stark.actuator {self.name}>"


def actuator(function: Callable[..., Any]) -> ActuatorFormula:
    """Decorator: makes an actuator of a function of coordinates (``stark.Coordinate``), values, clocks and
    memories that returns the energy of a time step [J] or ``stark.act(...)``."""
    name = getattr(function, "__name__", "actuator")
    arguments = _read_arguments(function, name, dict(sys._getframe(1).f_locals))
    inputs = Inputs([0])
    with recording(name):
        result = function(*_symbols(inputs, arguments))
    acted = result if isinstance(result, Actuation) else Actuation(result, (), (), {})
    memories = [a.name for a in arguments if isinstance(a, _Kept)]
    energy = scalar_result(name, acted.energy, function)
    _check_memories(name, function, memories, acted.remember)
    rows = [("hold", value) for value in acted.hold] + [("limit", value) for value in acted.limit]
    outputs = [energy, *(_scalar(name, function, what, value) for what, value in rows)]
    _check_motion(name, function, arguments, inputs, outputs)
    outputs += [_scalar(name, function, f"remember '{m}'", acted.remember[m]) for m in memories]
    _check_use(name, function, arguments, inputs, outputs)
    formula = inputs.builder.finish(outputs)
    parameters = tuple(a for a in arguments if isinstance(a, Parameter))
    one_sided = tuple(what == "limit" for what, _ in rows)
    core = _core.make_actuator(
        name,
        inspect.getdoc(function) or name,
        formula,
        sum(isinstance(a, _Moving) for a in arguments),
        list(one_sided),
        memories,
        {a.name: a.declaration.default for a in parameters},
    )
    title = f"{name}({', '.join(argument.name for argument in arguments)})"
    return ActuatorFormula(
        name,
        core.doc,
        core,
        ExpressionGraph(title, outputs),
        definition_of(function),
        len(rows),
        one_sided,
        tuple(memories),
        parameters,
        inputs.sources,
        formula,
        function,
        captured(function),
    )


def built_in(name: str) -> ActuatorFormula:
    """A built-in actuator by name; InvalidArgument for unknown names, with the nearest one as a hint."""
    return _built_in(name)


@functools.cache
def _built_in(name: str) -> ActuatorFormula:
    core = _core.find_actuator(name)
    return ActuatorFormula(core.name, core.doc, core)


# --- details ---


@dataclass(frozen=True)
class _Moving:
    """An argument that is a coordinate."""

    name: str


@dataclass(frozen=True)
class _Kept:
    """An argument that is a memory."""

    name: str


_Argument = _Moving | _Kept | ClockArgument | Parameter


def _read_arguments(function: Callable[..., Any], name: str, outer: Mapping[str, object]) -> list[_Argument]:
    arguments: list[_Argument] = []
    for parameter in signature_of(function, name, outer).parameters.values():
        clock = read_clock(parameter)
        if parameter.annotation is Coordinate:
            arguments.append(_Moving(parameter.name))
        elif parameter.annotation is Memory:
            arguments.append(_Kept(parameter.name))
        elif clock is not None:
            arguments.append(clock)
        else:
            arguments.append(_value(read_parameter(parameter, name, function, _CHOICES), name, function))
    count = sum(isinstance(a, _Moving) for a in arguments)
    if not 1 <= count <= MAX_COORDINATES:
        raise formula_error(
            name,
            f"it has {count} arguments annotated stark.Coordinate: must have one, or up to {MAX_COORDINATES}",
            function,
        )
    return arguments


def _value(parameter: Parameter, name: str, function: Callable[..., Any]) -> Parameter:
    if parameter.shape:
        raise formula_error(
            name, f"argument '{parameter.name}' has the shape {parameter.shape}: must be a number", function
        )
    if parameter.name in RESERVED:
        raise formula_error(
            name,
            f"a value must not be called '{parameter.name}', which actuators have as an attribute; choose "
            f"another name",
            function,
        )
    return parameter


def _symbols(inputs: Inputs, arguments: Sequence[_Argument]) -> list[Any]:
    values: list[Any] = []
    moving = 0
    for argument in arguments:
        if isinstance(argument, _Moving):
            values.append(Coordinate(inputs, moving, argument.name))
            moving += 1
        elif isinstance(argument, _Kept):
            value = inputs.builder.data(f"memory.{argument.name}", 1, "", "kept from step to step")[0]
            inputs.builder.set_name(value, argument.name)
            inputs.note([value], f"memory.{argument.name}")
            values.append(value)
        elif isinstance(argument, ClockArgument):
            values.append(clock_symbol(inputs, argument))
        else:
            values.append(parameter_symbols(inputs, argument))
    return values


def _scalar(name: str, function: Callable[..., Any], what: str, value: Any) -> Scalar:
    result = convert(value, what)
    if isinstance(result, Tensor) or result.is_condition:
        raise formula_error(name, f"{what}: got {value!r}: must be a number", function)
    return result


def _check_memories(
    name: str, function: Callable[..., Any], memories: Sequence[str], remembered: Mapping[str, Any]
) -> None:
    for memory in memories:
        if memory not in remembered:
            raise formula_error(
                name,
                f"'{memory}' is a stark.Memory and never changes; return "
                f"stark.act(energy, remember={{'{memory}': ...}})",
                function,
            )
    for memory in remembered:
        if memory not in memories:
            raise formula_error(
                name, f"remember '{memory}': no argument of this name is annotated stark.Memory", function
            )


def _check_motion(
    name: str,
    function: Callable[..., Any],
    arguments: Sequence[_Argument],
    inputs: Inputs,
    outputs: Sequence[Scalar],
) -> None:
    """Every coordinate moves the energy or a residual; otherwise nothing acts on it."""
    nodes = ExpressionGraph("", list(outputs)).nodes
    changes = [value.id for value in inputs.builder.x(0)]
    for k, argument in enumerate(a for a in arguments if isinstance(a, _Moving)):
        if changes[k] not in nodes:
            raise formula_error(
                name,
                f"nothing depends on the motion of '{argument.name}', so no effort acts on it; use "
                f"{argument.name}.q or {argument.name}.rate",
                function,
            )


def _check_use(
    name: str,
    function: Callable[..., Any],
    arguments: Sequence[_Argument],
    inputs: Inputs,
    outputs: Sequence[Scalar],
) -> None:
    nodes = ExpressionGraph("", list(outputs)).nodes
    fields = {row["name"] for row in inputs.builder.finish(list(outputs)).fields}
    for argument in arguments:
        unused = isinstance(argument, Parameter) and argument.name not in fields
        unused |= isinstance(argument, ClockArgument) and inputs.clocks[argument.name] not in nodes
        if unused:
            raise formula_error(
                name,
                f"nothing depends on '{argument.name}'; use every argument, or remove it from the signature",
                function,
            )
