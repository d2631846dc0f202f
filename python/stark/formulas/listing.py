"""Recorded formulas as data and back: the operations, in an order in which they can be done."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from stark import _core
from stark._core import FormulaBuilder
from stark.formulas.internal import Internal
from stark.symbolic import functions as f
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Scalar

#: Inputs that are positions of points [m]: at the end of the step, at its start, at rest, at time 0.
POSITIONS = ("x", "x_prev", "X", "x_initial")
CLOCKS = ("time", "time_step")

#: Operations by name, and how many operands they have.
OPERATIONS: dict[str, tuple[int, Callable[..., Any]]] = {
    "neg": (1, lambda a: -a),
    "not": (1, lambda a: ~a),
    "abs": (1, f.abs),
    "sqrt": (1, f.sqrt),
    "exp": (1, f.exp),
    "log": (1, f.log),
    "sin": (1, f.sin),
    "cos": (1, f.cos),
    "tan": (1, f.tan),
    "asin": (1, f.asin),
    "acos": (1, f.acos),
    "atan": (1, f.atan),
    "tanh": (1, f.tanh),
    "held": (1, f.held),
    "+": (2, lambda a, b: a + b),
    "-": (2, lambda a, b: a - b),
    "*": (2, lambda a, b: a * b),
    "/": (2, lambda a, b: a / b),
    "<": (2, lambda a, b: a < b),
    "<=": (2, lambda a, b: a <= b),
    "&&": (2, lambda a, b: a & b),
    "||": (2, lambda a, b: a | b),
    "min": (2, f.minimum),
    "max": (2, f.maximum),
    "pow": (2, f.pow),
    "atan2": (2, f.atan2),
    "fma": (3, f.fma),
    "select": (3, f.where),
}

#: An input of a formula: name, how many numbers, unit, meaning, range, whether each element has its own.
Input = tuple[str, int, str, str, tuple[float, float, bool, bool], bool]


def listed(
    graph: ExpressionGraph, sources: Mapping[int, tuple[str, int, int]]
) -> tuple[list[list[Any]], list[int]]:
    """Nodes and numbers of those that are outputs.

    Nodes are ["constant", value], ["input", source, point, component] or [operation, operands...], where
    operands are numbers of nodes before. Sources are those of ``POSITIONS`` and ``CLOCKS``, or the name of
    a parameter; "unknown" where ``sources`` has none."""
    place = {key: k for k, key in enumerate(graph.nodes)}
    nodes: list[list[Any]] = []
    for key, node in graph.nodes.items():
        if node.operation == "input":
            nodes.append(["input", *sources.get(key, ("unknown", 0, 0))])
        elif node.operation == "constant":
            nodes.append(["constant", float(node)])
        else:
            nodes.append([node.operation, *(place[operand.id] for operand in node.operands)])
    outputs = []
    numbers = {_bits(node[1]): k for k, node in enumerate(nodes) if node[0] == "constant"}
    for output in graph.outputs:
        if output.graph is not None:
            outputs.append(place[output.id])
            continue
        number = float(output)  # a plain number
        if _bits(number) not in numbers:
            numbers[_bits(number)] = len(nodes)
            nodes.append(["constant", number])
        outputs.append(numbers[_bits(number)])
    return nodes, outputs


def stages_of(graph: ExpressionGraph) -> list[int]:
    """Numbers, as ``listed`` counts, of the nodes that derivatives may go through."""
    place = {key: k for k, key in enumerate(graph.nodes)}
    source = next((output.graph for output in graph.outputs if output.graph is not None), None)
    return [] if source is None else sorted({place[key] for key in source.stages if key in place})


def _bits(number: float) -> bytes:
    return struct.pack("<d", number)


def replayed(
    points: int,
    inputs: Sequence[Input],
    nodes: Sequence[Sequence[Any]],
    outputs: Sequence[int],
    internals: Sequence[Internal] = (),
    stages: Sequence[int] = (),
) -> tuple[_core.Formula, ExpressionGraph, dict[int, tuple[str, int, int]]]:
    """The formula of nodes as ``listed`` gives them, its graph and what the inputs of that are. Nodes must
    have operands before them; raises TraceError for operations on what they are not for, and KeyError or
    IndexError for inputs that there are not."""
    builder = FormulaBuilder(points)
    # Made where they first occur: the bits of the formula depend on the order of its inputs and constants.
    waiting = {row[0]: row for row in inputs}
    coming = list(internals)
    known: dict[str, Any] = {}
    sources: dict[int, tuple[str, int, int]] = {}
    values: list[Any] = []
    for operation, *operands in nodes:
        if operation == "constant":
            values.append(builder.constant(float(operands[0])))
        elif operation == "input":
            if operands[0] in waiting:
                name, width, unit, doc, limits, is_data = waiting.pop(operands[0])
                known[name] = (
                    builder.data(name, width, unit, doc)
                    if is_data
                    else builder.parameter(name, width, unit, doc, limits)
                )
            while operands[0] in [variable.name for variable in coming]:
                # Those that nothing depends on keep their place among the updates.
                variable = coming.pop(0)
                known[variable.name] = variable.entries(builder)
            value = _input(builder, points, known, *operands)
            sources[value.id] = (operands[0], operands[1], operands[2])
            values.append(value)
        else:
            values.append(OPERATIONS[operation][1](*(values[k] for k in operands)))
    for variable in coming:
        variable.entries(builder)
    for k in stages:
        if values[k].graph is not None:
            values[k].graph.mark_stage(values[k])
    results: list[Scalar] = [values[k] for k in outputs]
    return builder.finish(results), ExpressionGraph("formula", results), sources


def _input(
    builder: FormulaBuilder, points: int, known: Mapping[str, Any], source: str, point: int, component: int
) -> Any:
    if source in POSITIONS:
        if not 0 <= point < points or not 0 <= component < 3:
            raise IndexError(f"{source}: point {point}, component {component}")
        value = getattr(builder, source)(point)[component]
        builder.set_name(value, f"p[{point}].{source}[{component}]")
        return value
    if source in CLOCKS:
        value = getattr(builder, source)()
        builder.set_name(value, source)
        return value
    entries = known[source]
    if not 0 <= component < len(entries):
        raise IndexError(f"'{source}': component {component}")
    builder.set_name(entries[component], source if len(entries) == 1 else f"{source}[{component}]")
    return entries[component]
