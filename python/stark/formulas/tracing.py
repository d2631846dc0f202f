"""Recording: the user's function runs once on symbols and becomes a formula of the core."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from stark import _core
from stark._core import TraceError
from stark.formulas.arguments import Argument, ClockArgument, FrameArgument, PointArgument
from stark.formulas.frames import KINDS
from stark.formulas.kinematics import Inputs, Point, Stencil
from stark.formulas.parameters import Parameter
from stark.formulas.totals import Totals, totals_of
from stark.symbolic.errors import formula_error, recording
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Scalar, Tensor, convert, describe, from_shape

MAX_POINTS = 8  # of a stencil: the largest element Hessian that the solver makes definite is 24 x 24


@dataclass(frozen=True)
class Trace:
    """A recorded formula. Its points are those of the arguments in order, without those that do not occur."""

    formula: _core.Formula
    graph: ExpressionGraph
    kept: tuple[int, ...]  # of all points of the arguments, those that occur
    parameters: tuple[str, ...]  # inputs that occur, constants of patch frames among them
    translation_invariant: bool
    labels: tuple[str, ...]  # of the kept points, for messages
    sources: Mapping[int, tuple[str, int, int]] = field(default_factory=dict)
    """What the inputs of the graph are, by number: of what, which kept point, which component."""
    totals: Totals | None = None
    """Of an energy of totals."""
    local_axes: frozenset[str] = frozenset()
    """Triangles whose strain is along their own first edge."""


def trace(
    name: str,
    function: Callable[..., object],
    arguments: Sequence[Argument],
    frames: Sequence[str],
    spanning: Sequence[str] = (),
) -> Trace:
    """Records the function. `frames`: kind of each frame argument, a key of frames.KINDS; `spanning`: stencil
    arguments whose points belong to several bodies."""
    count = sum(point_counts(arguments, frames))
    if count > 4 * MAX_POINTS:  # frames may leave some out
        raise formula_error(name, _too_many(count), function)
    inputs = Inputs(list(range(count)))
    output = record(name, function, arguments, frames, inputs, spanning)
    used = _check_use(name, function, arguments, frames, inputs, output)
    if len(used) < count:
        inputs = Inputs(sorted(used))
        output = record(name, function, arguments, frames, inputs, spanning)
    if len(used) > MAX_POINTS:
        raise formula_error(name, _too_many(len(used)), function)
    formula = inputs.builder.finish([output], is_energy=True)
    fields = tuple(row["name"] for row in formula.fields)
    for argument in arguments:
        if isinstance(argument, Parameter) and argument.name not in fields:
            raise formula_error(name, unused_text(argument.name), function)
    try:
        totals = totals_of(output, inputs.sources)
    except TraceError as error:
        raise formula_error(name, str(error), function) from None
    title = f"{name}({', '.join(argument.name for argument in arguments)})"
    labels = _labels(arguments, frames)
    return Trace(
        formula,
        ExpressionGraph(title, [output]),
        tuple(sorted(used)),
        fields,
        is_translation_invariant(output, inputs.unknowns),
        tuple(labels[p] for p in sorted(used)),
        inputs.sources,
        totals,
        frozenset(inputs.local_axes),
    )


def point_counts(arguments: Sequence[Argument], frames: Sequence[str]) -> list[int]:
    """Number of points of each argument."""
    kinds = iter(frames)
    return [
        argument.kind.point_count
        if isinstance(argument, PointArgument)
        else KINDS[next(kinds)].point_count
        if isinstance(argument, FrameArgument)
        else 0
        for argument in arguments
    ]


def record(
    name: str,
    function: Callable[..., object],
    arguments: Sequence[Argument],
    frames: Sequence[str],
    inputs: Inputs,
    spanning: Sequence[str] = (),
) -> Scalar:
    """The energy as an expression of the inputs."""
    values: list[object] = []
    kinds, point = iter(frames), 0
    for argument, count in zip(arguments, point_counts(arguments, frames), strict=True):
        if isinstance(argument, PointArgument):
            symbol = argument.kind(inputs, point, argument.name)
            if argument.name in spanning and isinstance(symbol, Stencil):
                symbol.rest_as_at_start()
            values.append(symbol)
        elif isinstance(argument, FrameArgument):
            values.append(KINDS[next(kinds)](inputs, point, argument.name))
        elif isinstance(argument, ClockArgument):
            values.append(clock_symbol(inputs, argument))
        else:
            values.append(parameter_symbols(inputs, argument))
        point += count
    with recording(name):
        result = function(*values)
    return scalar_result(name, result, function)


def parameter_symbols(inputs: Inputs, parameter: Parameter) -> object:
    """The parameter as a Scalar, Vec or Mat of named inputs."""
    declaration = parameter.declaration
    entries = inputs.builder.parameter(
        parameter.name, parameter.width, parameter.unit, declaration.doc or parameter.name, declaration.range
    )
    inputs.note(entries, parameter.name)
    value = from_shape(entries, parameter.shape)
    if not parameter.shape:
        inputs.builder.set_name(entries[0], parameter.name)
        return value
    columns = parameter.shape[-1]
    for k, entry in enumerate(entries):
        place = f"{k}" if len(parameter.shape) == 1 else f"{k // columns},{k % columns}"
        inputs.builder.set_name(entry, f"{parameter.name}[{place}]")
    return value


def scalar_result(name: str, value: object, function: Callable[..., object]) -> Scalar:
    """The returned value as a scalar; TraceError in the user's terms otherwise."""
    if value is None:
        raise formula_error(name, "it returns None; return the energy [J]", function)
    try:
        result = convert(value, "the result")
    except TraceError as error:
        raise formula_error(name, str(error), function) from None
    if isinstance(result, Tensor):
        raise formula_error(
            name, f"it returns {describe(result)}: must be a scalar; sum it, or take dot or norm", function
        )
    if result.is_condition:
        raise formula_error(
            name, "it returns a condition: must be a number; return stark.where(condition, a, b)", function
        )
    return result


def is_translation_invariant(output: Scalar, unknowns: dict[int, int]) -> bool:
    """Whether moving all unknown points by the same vector provably leaves the value as it is: every node is
    followed as value + (weights . translation), or as unknown (None)."""
    still = (0.0, 0.0, 0.0)
    weights: dict[int, tuple[float, ...] | None] = {}
    for key, node in ExpressionGraph("", [output]).nodes.items():
        operands = node.operands
        known = [weights[operand.id] for operand in operands]
        if key in unknowns:
            weights[key] = tuple(1.0 if c == unknowns[key] else 0.0 for c in range(3))
        elif all(w == still for w in known):
            weights[key] = still
        else:
            moving = [w for w in known if w is not None]
            all_known = len(moving) == len(known)
            weights[key] = _combined(node.operation, operands, moving) if all_known else None
    return output.graph is not None and weights[output.id] == still


def _combined(
    operation: str, operands: Sequence[Scalar], w: Sequence[tuple[float, ...]]
) -> tuple[float, ...] | None:
    """Weights of an operation on values of which at least one moves."""
    if operation in ("+", "-"):
        if len(w) == 1:
            return tuple(-a for a in w[0])
        sign = 1.0 if operation == "+" else -1.0
        total = tuple(a + sign * b for a, b in zip(*w, strict=True))
        return tuple(0.0 if abs(t) < 1e-14 else t for t in total)  # weights such as 1/3 sum with rounding
    if operation in ("*", "/") and operands[1].is_constant:
        factor = float(operands[1])
        if operation == "/" and factor == 0.0:
            return None
        return tuple(a * factor if operation == "*" else a / factor for a in w[0])
    if operation == "*" and operands[0].is_constant:
        return tuple(float(operands[0]) * a for a in w[1])
    return None


def clock_symbol(inputs: Inputs, argument: ClockArgument) -> Scalar:
    """Time or time step as a named input."""
    value: Scalar = getattr(inputs.builder, argument.quantity)()
    inputs.builder.set_name(value, argument.name)
    inputs.clocks[argument.name] = value.id
    inputs.note([value], argument.quantity)
    return value


def _check_use(
    name: str,
    function: Callable[..., object],
    arguments: Sequence[Argument],
    frames: Sequence[str],
    inputs: Inputs,
    output: Scalar,
) -> set[int]:
    """The points that occur. Every argument has to, and every point of a stencil; frames may leave axes
    out."""
    nodes = ExpressionGraph("", [output]).nodes
    if not any(node in nodes for node in inputs.unknowns):
        raise formula_error(
            name, "the energy does not depend on any position .x, so it has no forces; use p.x", function
        )
    used = {point for node, point in inputs.point_of.items() if node in nodes}
    labels, first = _labels(arguments, frames), 0
    for argument, count in zip(arguments, point_counts(arguments, frames), strict=True):
        mine = range(first, first + count)
        if isinstance(argument, FrameArgument) and not used.intersection(mine):
            raise formula_error(name, unused_text(argument.name), function)
        if isinstance(argument, PointArgument):
            for p in mine:
                if p not in used:
                    raise formula_error(name, unused_text(labels[p]), function)
        if isinstance(argument, ClockArgument) and inputs.clocks[argument.name] not in nodes:
            raise formula_error(name, unused_text(argument.name), function)
        first += count
    return used


def _labels(arguments: Sequence[Argument], frames: Sequence[str]) -> list[str]:
    labels: list[str] = []
    for argument, count in zip(arguments, point_counts(arguments, frames), strict=True):
        if isinstance(argument, PointArgument) and argument.kind is Point:
            labels.append(argument.name)
        elif isinstance(argument, FrameArgument) and count == 4:
            labels += [f"{argument.name}.{part}" for part in ("origin", "x", "y", "z")]
        else:
            labels += [f"{argument.name}[{i}]" for i in range(count)]
    return labels


def unused_text(argument: str) -> str:
    """Message of an argument that does not occur."""
    return (
        f"the formula does not depend on '{argument}'; use every argument, or remove it from the signature "
        f"(a value that drops out, such as 0 * {argument}, does not count)"
    )


def _too_many(count: int) -> str:
    return f"it acts on {count} points at once: at most {MAX_POINTS} are possible; split it into several"
