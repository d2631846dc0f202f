"""What a joint is: residuals between two frames that are held at zero, and coordinates of the motion that is
left.

    @stark.joint
    def cylindrical(a: stark.Frame, b: stark.Frame):
        d = b.origin - a.origin
        return stark.hold(
            length=[a.x @ d, a.y @ d], direction=a.z - b.z, displacement={"displacement": a.z @ d}
        )

The function runs once on symbols. Built-in joints (src/stark/models/joints) are definitions like these."""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from stark import _core
from stark._core import TraceError
from stark.formulas.arguments import Argument, ClockArgument, FrameArgument, read_arguments
from stark.formulas.captured import captured, warn_of_changes
from stark.formulas.frames import SiteFrame
from stark.formulas.kinematics import Inputs
from stark.formulas.parameters import Declaration, Parameter
from stark.formulas.pickling import PickledByName
from stark.formulas.tracing import clock_symbol, parameter_symbols, unused_text
from stark.symbolic.errors import definition_of, formula_error, recording
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Scalar, Tensor, convert

_POINTS = 8  # origin and three axes of two frames
# Arguments of scene.add_joint, which parameters cannot be, and attributes of Joint, which coordinates cannot.
_ARGUMENTS = frozenset({"kind", "a", "b", "anchor", "axis", "rotation", "name", "contact", "enabled"})
_ATTRIBUTES = frozenset({"name", "kind", "formula", "coordinates", "rates", "residuals", "reaction"}) | {
    "enabled",
    "pull_together",
    "hold_here",
}


@dataclass(frozen=True)
class Held:
    """What ``stark.hold`` returns: groups of residuals by unit, coordinates by name."""

    groups: tuple[tuple[str, tuple[Scalar, ...]], ...]  # ("m" or "rad", residuals)
    coordinates: tuple[tuple[str, str, Scalar], ...]  # (name, unit, value)


def hold(
    *,
    length: Any = (),
    direction: Any = (),
    displacement: Mapping[str, Any] | None = None,
    angle: Mapping[str, Any] | None = None,
) -> Held:
    """What a joint holds at zero and what its coordinates are; the result of a function with
    ``@stark.joint``.

    length: residuals [m], a scalar, a vector or a list of them; the norm of each list entry is held within
    ``joints.length_tolerance``. direction: differences of unit vectors, or angles [rad], held within
    ``joints.angle_tolerance``. displacement: coordinates [m] by name; angle: coordinates [rad] by name, which
    may jump by full turns and are counted over them."""
    groups = [("m", entries) for entries in _groups("length", length)]
    groups += [("rad", entries) for entries in _groups("direction", direction)]
    coordinates = [(name, "m", value) for name, value in _coordinates("displacement", displacement)]
    coordinates += [(name, "rad", value) for name, value in _coordinates("angle", angle)]
    if not groups and not coordinates:
        raise TraceError("stark.hold() of nothing: give length=, direction=, displacement= or angle=")
    return Held(tuple(groups), tuple(coordinates))


def _groups(what: str, given: Any) -> list[tuple[Scalar, ...]]:
    rows = given if isinstance(given, (list, tuple)) else [given]
    groups = []
    for row in rows:
        value = convert(row, f"hold: {what}")
        groups.append(tuple(value.entries) if isinstance(value, Tensor) else (value,))
    return groups


def _coordinates(what: str, given: Any) -> list[tuple[str, Scalar]]:
    if given is not None and not isinstance(given, Mapping):
        raise TraceError(
            f"hold: {what}= names coordinates, that are free to move: must be a mapping such as "
            f'{{"{what}": value}}; what is held at zero goes into length= or direction='
        )
    return [(name, _scalar(name, value)) for name, value in (given or {}).items()]


def _scalar(name: str, value: Any) -> Scalar:
    result = convert(value, f"hold: coordinate '{name}'")
    if isinstance(result, Tensor):
        raise TraceError(f"hold: coordinate '{name}' has the shape {result.shape}: must be one number")
    if name in _ATTRIBUTES:
        raise TraceError(f"hold: coordinate '{name}': joints have another attribute of that name; rename it")
    if not name.isidentifier():
        raise TraceError(
            f"hold: coordinate '{name}': its name must be an identifier, it becomes an attribute"
        )
    return result


@dataclass(frozen=True)
class JointFormula(PickledByName):
    """A joint as a formula: what ``@stark.joint`` makes of a function, or a built-in joint.
    ``scene.add_joint``
    takes it."""

    KIND: ClassVar[str] = "joint"

    name: str
    doc: str
    parameters: tuple[Parameter, ...]
    core: _core.JointDefinition
    residuals: ExpressionGraph | None = field(default=None, compare=False)
    sources: Mapping[int, tuple[str, int, int]] = field(default_factory=dict, compare=False)
    """What the inputs of the graph are, by number: of what, which point, which component."""
    groups: tuple[tuple[str, int], ...] = ()
    """Unit and number of residuals of each group; not of built-in joints."""
    location: str = field(default="", compare=False)
    recorded: _core.Formula | None = field(default=None, compare=False)
    """The formula as it was recorded; not of built-in joints."""
    function: Callable[..., Any] | None = field(default=None, compare=False, repr=False)
    """That it was made of, by whose name it is pickled; not of built-in joints and those of documents."""
    numbers: Mapping[str, Hashable] = field(default_factory=dict, compare=False, repr=False)
    """What the function took from around it when it was recorded."""

    def warn_of_changes(self) -> None:
        """Of numbers around its function that are not what they were when it was recorded."""
        if self.function is not None:
            warn_of_changes(self.name, "joint", self.function, self.numbers, self.location)

    def _finder(self) -> Callable[[str], JointFormula]:
        return built_in

    @property
    def coordinates(self) -> tuple[tuple[str, str], ...]:
        """(name, unit) of each coordinate."""
        return tuple(self.core.coordinates)

    def graph(self) -> ExpressionGraph:
        """The recorded residuals and coordinates; print it for a listing. Not of built-in joints."""
        if self.residuals is None:
            raise TraceError(f"joint '{self.name}' is built in: its formula is in src/stark/models/joints")
        return self.residuals

    def __repr__(self) -> str:
        names = ", ".join(name for name, _ in self.coordinates)
        return f"<stark.joint {self.name}{f' with {names}' if names else ''}>"


def joint(function: Callable[..., Any]) -> JointFormula:
    """Decorator: makes a joint of a function of two frames (``stark.Frame``), parameters and clocks that
    returns ``stark.hold(...)``."""
    name = getattr(function, "__name__", "joint")
    outer = dict(sys._getframe(1).f_locals)
    _, arguments = read_arguments(function, name, outer, _ARGUMENTS)
    return _record(name, function, arguments)


def _record(name: str, function: Callable[..., Any], arguments: Sequence[Argument]) -> JointFormula:
    _require_two_frames(name, function, arguments)
    inputs = Inputs(list(range(_POINTS)))
    values: list[Any] = []
    frames = 0
    for argument in arguments:
        if isinstance(argument, FrameArgument):
            values.append(SiteFrame(inputs, 4 * frames, argument.name))
            frames += 1
        elif isinstance(argument, ClockArgument):
            values.append(clock_symbol(inputs, argument))
        else:
            assert isinstance(argument, Parameter)
            values.append(parameter_symbols(inputs, argument))
    with recording(name):
        held = function(*values)
    if not isinstance(held, Held):
        raise formula_error(
            name, f"it returns {held!r}: must be stark.hold(length=..., direction=...)", function
        )
    outputs = [r for _, group in held.groups for r in group] + [value for _, _, value in held.coordinates]
    _check_use(name, function, arguments, inputs, outputs)
    formula = inputs.builder.finish(outputs)
    core = _core.make_joint(
        name,
        inspect.getdoc(function) or name,
        formula,
        [(unit, len(group)) for unit, group in held.groups],
        [(coordinate, unit) for coordinate, unit, _ in held.coordinates],
    )
    parameters = tuple(a for a in arguments if isinstance(a, Parameter))
    title = f"{name}({', '.join(argument.name for argument in arguments)})"
    graph = ExpressionGraph(title, outputs)
    groups = tuple((unit, len(group)) for unit, group in held.groups)
    place = definition_of(function)
    return JointFormula(
        name,
        core.doc,
        parameters,
        core,
        graph,
        inputs.sources,
        groups,
        place,
        formula,
        function,
        captured(function),
    )


def _require_two_frames(name: str, function: Callable[..., Any], arguments: Sequence[Argument]) -> None:
    frames = [a for a in arguments if isinstance(a, FrameArgument)]
    others = [a for a in arguments if not isinstance(a, (FrameArgument, ClockArgument, Parameter))]
    if len(frames) != 2 or others:
        raise formula_error(
            name,
            f"it has {len(frames)} arguments annotated stark.Frame and {len(others)} points or stencils: a "
            f"joint "
            f"is a function of two frames and parameters; for points write an energy with @stark.energy",
            function,
        )


def _check_use(
    name: str,
    function: Callable[..., Any],
    arguments: Sequence[Argument],
    inputs: Inputs,
    outputs: Sequence[Scalar],
) -> None:
    nodes = ExpressionGraph("", list(outputs)).nodes
    used = {point // 4 for node, point in inputs.point_of.items() if node in nodes}
    frames = [a.name for a in arguments if isinstance(a, FrameArgument)]
    for k, frame in enumerate(frames):
        if k not in used:
            raise formula_error(name, unused_text(frame), function)
    fields = {row["name"] for row in inputs.builder.finish(list(outputs)).fields}
    for argument in arguments:
        if isinstance(argument, Parameter) and argument.name not in fields:
            raise formula_error(name, unused_text(argument.name), function)


def built_in(name: str) -> JointFormula:
    """A built-in joint by name; InvalidArgument for unknown names, with the nearest one as a hint."""
    return _built_in(name)


@functools.cache
def _built_in(name: str) -> JointFormula:
    core = _core.find_joint(name)
    parameters = tuple(
        Parameter(row["name"], (), Declaration(None, row["unit"], None, None, None, None, row["doc"]))
        for row in core.parameters
    )
    return JointFormula(core.name, core.doc, parameters, core)
