"""Inspection of formulas: a readable listing with shared parts named, counts of operations, DOT text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from stark._core import TraceError
from stark.symbolic.tensor import Scalar, listed

# How tightly operators bind in Python: listings are valid Python.
_PRECEDENCE = {"<": 1, "<=": 1, "||": 2, "&&": 3, "+": 4, "-": 4, "*": 5, "/": 5}
_SIGN, _POWER, _ATOM = 6, 7, 8
_WORDS = {"&&": "&", "||": "|", "select": "where", "min": "minimum", "max": "maximum"}
_LONGEST = 72  # characters of an expression before it gets a name of its own


class ExpressionGraph:
    """The operations behind some outputs, each once. str() of it is a listing."""

    def __init__(self, title: str, outputs: Sequence[Scalar]) -> None:
        self.title = title
        self.outputs: list[Scalar] = listed(outputs, "ExpressionGraph: outputs")
        for output in self.outputs:
            if not isinstance(output, Scalar):
                raise TraceError(f"ExpressionGraph: output {output!r}: must be a scalar of a formula")
        self.nodes: dict[int, Scalar] = _reachable(self.outputs)

    @property
    def counts(self) -> dict[str, int]:
        """Number of operations by kind, most frequent first."""
        kinds = Counter(node.operation for node in self.nodes.values())
        return {kind: n for kind, n in kinds.most_common() if kind not in ("input", "constant")}

    @property
    def operation_count(self) -> int:
        """How many operations one evaluation takes."""
        return sum(self.counts.values())

    def __str__(self) -> str:
        lines: list[str] = []
        texts: dict[int, Any] = {}
        names: dict[int, Any] = {}
        uses = Counter(operand.id for node in self.nodes.values() for operand in node.operands)
        uses.update(y.id for y in self.outputs)
        for key, node in self.nodes.items():
            text, precedence = _expression(node, texts)
            is_operation = node.operation not in ("input", "constant")
            if is_operation and (uses[key] > 1 or len(text) > _LONGEST):
                names[key] = f"t{len(names) + 1}"
                lines.append(f"  {names[key]} = {text}")
                text, precedence = names[key], _ATOM
            texts[key] = (text, precedence)
        results = [texts[y.id][0] if y.graph else _number(y) for y in self.outputs]
        width = sum(map(len, results)) > _LONGEST
        result = ",\n          ".join(results) if width else ", ".join(results)
        lines.append("  return " + (f"[{result}]" if len(results) > 1 else result))
        return "\n".join([f"{self.title}:", *lines])

    def dot(self) -> str:
        """Text in the DOT language, for Graphviz."""
        lines = [f'digraph "{self.title}" {{', "  rankdir=BT;"]
        for key, node in self.nodes.items():
            is_operation = node.operation not in ("input", "constant")
            label = _WORDS.get(node.operation, node.operation) if is_operation else _leaf(node)
            lines.append(f'  n{key} [label="{label}", shape={"ellipse" if is_operation else "box"}];')
            lines += [f"  n{operand.id} -> n{key};" for operand in node.operands]
        for i, y in enumerate(self.outputs):
            lines.append(f'  out{i} [label="output {i}", shape=plaintext];')
            if y.graph:
                lines.append(f"  n{y.id} -> out{i};")
        return "\n".join([*lines, "}"])

    def __repr__(self) -> str:
        return f"<ExpressionGraph of {self.title}: {self.operation_count} operations>"


def _reachable(outputs: Sequence[Scalar]) -> dict[int, Scalar]:
    """Nodes by number, operands before users."""
    found: dict[int, Scalar] = {}
    stack = [y for y in outputs if y.graph is not None]
    while stack:
        node = stack.pop()
        if node.id not in found:
            found[node.id] = node
            stack.extend(node.operands)
    return dict(sorted(found.items()))


def _number(node: Scalar) -> str:
    return repr(node)[len("Scalar(") : -1]


def _leaf(node: Scalar) -> str:
    return node.name or _number(node)


def _expression(node: Scalar, texts: dict[int, tuple[str, int]]) -> tuple[str, int]:
    """Text of a node from those of its operands, and how tightly it binds."""
    operation, operands = node.operation, node.operands
    if not operands:
        text = _leaf(node)
        return text, _SIGN if text.startswith("-") else _ATOM

    def wrapped(place: int, least: int) -> str:
        text, precedence = texts[operands[place].id]
        return text if precedence >= least else f"({text})"

    if operation == "*" and operands[0].id == operands[1].id:
        return f"{wrapped(0, _ATOM)}**2", _POWER
    if operation in _PRECEDENCE:
        level = _PRECEDENCE[operation]
        right = level if operation in ("+", "*", "&&", "||") else level + 1
        return f"{wrapped(0, level)} {_WORDS.get(operation, operation)} {wrapped(1, right)}", level
    if operation in ("neg", "not"):
        return ("-" if operation == "neg" else "~") + wrapped(0, _SIGN), _SIGN
    inside = ", ".join(wrapped(k, 0) for k in range(len(operands)))
    return f"{_WORDS.get(operation, operation)}({inside})", _ATOM
