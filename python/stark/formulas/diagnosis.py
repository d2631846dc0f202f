"""Where a formula stops being finite: the line of the user's function, found by evaluating its operations one
after another for one element. Used after the fact, for messages only."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from types import CodeType, FrameType
from typing import Any

import numpy as np

from stark._core import symbolic as core
from stark.formulas.binding import BoundEnergy
from stark.formulas.kinematics import Inputs
from stark.formulas.tracing import record
from stark.symbolic.errors import location_text
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Scalar

_WORDS = {
    "/": "a division by zero",
    "sqrt": "the square root of {0:g}",
    "log": "the logarithm of {0:g}",
    "pow": "{0:g} to the power {1:g}",
    "acos": "the arc cosine of {0:g}",
    "asin": "the arc sine of {0:g}",
    "atan2": "the angle of the direction (0, 0)",
    "exp": "exp({0:g})",
}


class Lines:
    """Records on which line of a function the nodes of a graph appear."""

    def __init__(self, function: Callable[..., object], size: Callable[[], int]) -> None:
        self._code: CodeType | None = getattr(function, "__code__", None)
        self._size = size
        self._line = 0
        self._marks: list[tuple[int, int]] = []  # (size of the graph, line from then on)

    def run(self, call: Callable[[], Any]) -> Any:
        """The result of the call, with the lines of the function watched."""
        before = sys.gettrace()
        sys.settrace(self._called)
        try:
            return call()
        finally:
            sys.settrace(before)

    def of(self, node: int) -> str | None:
        """Where a node was made, as tracebacks show it."""
        line = 0
        for size, number in self._marks:
            if size > node:
                break
            line = number
        if self._code is None or line == 0:
            return None
        return location_text(self._code.co_filename, line, self._code.co_name)

    def _called(self, frame: FrameType, event: str, argument: Any) -> Any:
        return self._stepped if frame.f_code is self._code else None

    def _stepped(self, frame: FrameType, event: str, argument: Any) -> Any:
        if event == "line":
            self._marks.append((self._size(), frame.f_lineno))
        return self._stepped


def culprit(binding: BoundEnergy, sample: Mapping[str, Any]) -> str:
    """Words and line for an element that is not finite, "" if the operation was not found. `sample`: inputs
    of this one element as for Formula.sample."""
    energy = binding.energy
    if energy.is_read:  # there is no function to look into
        return ""
    inputs = Inputs(binding.trace.kept)
    graph = inputs.builder.time().graph
    lines = Lines(energy.function, lambda: len(graph))
    output = lines.run(lambda: record(energy.name, energy.function, energy.arguments, binding.frames, inputs))
    found = first_not_finite(output, _values(inputs, sample))
    if found is None:
        return ""
    node, words = found
    place = lines.of(node)
    return f"{words}" + (f", on this line:\n{place}" if place else "")


def _values(inputs: Inputs, sample: Mapping[str, Any]) -> dict[int, float]:
    """Value of every input of the graph for one element."""
    values = {}
    for node, (source, point, k) in inputs.sources.items():
        if source in ("time", "time_step"):
            values[node] = float(sample[source])
        elif source in ("x", "X", "x_prev", "x_initial"):
            values[node] = float(sample[source][point, k])
        elif source in sample["values"]:
            values[node] = float(sample["values"][source][k])
    return values


def first_not_finite(
    output: Scalar, inputs: Mapping[int, float], slopes: bool = True
) -> tuple[int, str] | None:
    """(node, words) of the first operation whose value, or slope, is not finite. `inputs`: values by node."""
    nodes = ExpressionGraph("", [output]).nodes
    leaves = [key for key, node in nodes.items() if node.operation == "input"]
    inner = [key for key, node in nodes.items() if node.operands and not node.is_condition]
    if not inner or any(key not in inputs for key in leaves):
        return None
    arguments = [(f"v{key}", [nodes[key]], False) for key in leaves]
    compiled = core.compile_arrays([nodes[key] for key in inner], arguments, "interpreter")
    arrays = [np.array(float(inputs[key])) for key in leaves]
    numbers, _, _ = compiled.evaluate(0, True, False, arrays, [[] for _ in arrays], [])
    known = {**inputs, **dict(zip(inner, numbers.reshape(-1).tolist(), strict=True))}

    def value(node: Scalar) -> float:
        return float(node) if node.is_constant else known[node.id]

    for key in sorted(_taken(output, value)):
        node = nodes[key]
        if key not in known or not node.operands:
            continue
        operands = [value(operand) for operand in node.operands if not operand.is_condition]
        if not np.isfinite(known[key]) or (slopes and _is_singular(node.operation, operands)):
            words = _WORDS.get(node.operation, f"'{node.operation}' of {{0:g}}")
            return key, words.format(*operands, 0.0)
    return None


def _taken(output: Scalar, value: Callable[[Scalar], float]) -> set[int]:
    """Nodes behind the output, without the branches of where that are not taken."""
    found: set[int] = set()
    stack = [output]
    while stack:
        node = stack.pop()
        if node.id in found or node.is_constant:
            continue
        found.add(node.id)
        operands = list(node.operands)
        if node.operation == "select":
            operands = [operands[0], operands[1 if _holds(operands[0], value) else 2]]
        stack += operands
    return found


def _holds(condition: Scalar, value: Callable[[Scalar], float]) -> bool:
    a, *rest = condition.operands
    if condition.operation == "!":
        return not _holds(a, value)
    if condition.operation in ("&&", "||"):
        both = _holds(a, value), _holds(rest[0], value)
        return all(both) if condition.operation == "&&" else any(both)
    return value(a) < value(rest[0]) or (condition.operation == "<=" and value(a) == value(rest[0]))


def _is_singular(operation: str, operands: list[float]) -> bool:
    """Whether the slope of an operation is not finite where its value is."""
    if operation == "sqrt":
        return operands[0] == 0.0
    if operation in ("acos", "asin"):
        return abs(operands[0]) == 1.0
    if operation == "pow":
        return operands[0] == 0.0 and operands[1] < 2.0
    return operation == "atan2" and operands[0] == operands[1] == 0.0
