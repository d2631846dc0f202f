"""Energies of totals: what the sums over elements are called, and what occurs outside of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stark._core import TraceError
from stark.formulas.listing import POSITIONS
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Scalar


@dataclass(frozen=True)
class Totals:
    """The totals of an energy."""

    names: tuple[str, ...]
    """In the order in which the formula makes them; "" for those without a name."""
    outside: frozenset[str]
    """Inputs that occur outside of them, which all elements must share."""


def totals_of(output: Scalar, sources: Mapping[int, tuple[str, int, int]]) -> Totals | None:
    """None for an energy that is a sum over elements. TraceError where a position occurs outside of totals,
    or a total within another."""
    above = _above_totals(output)
    totals = [node for node in above.values() if node.operation == "total"]
    if not totals:
        return None
    for node in totals:
        inner = ExpressionGraph("", list(node.operands)).nodes.values()
        if any(other.operation == "total" for other in inner):
            raise TraceError(
                "a total is within another: must be a sum over elements of what one element has; "
                "multiply with the inner one outside"
            )
    outside = set()
    for key, node in above.items():
        source = sources.get(key, ("", 0, 0))[0]
        if source in POSITIONS:
            raise TraceError(
                f"{node.name or 'a position'} occurs outside of stark.total(...): an energy with totals "
                f"depends on its elements by them alone; add the rest as an energy of its own, or take the "
                f"total of it, too"
            )
        outside.add(source)
    names = tuple(node.name for node in sorted(totals, key=lambda node: node.id))
    _check_names(names)
    return Totals(names, frozenset(outside - {""}))


def _check_names(names: tuple[str, ...]) -> None:
    given = [name for name in names if name]
    for name in given:
        if given.count(name) > 1:
            raise TraceError(f"two totals have the name '{name}': must differ")


def _above_totals(output: Scalar) -> dict[int, Scalar]:
    """Nodes by number, without those that are summed."""
    found: dict[int, Scalar] = {}
    stack = [output] if output.graph is not None else []
    while stack:
        node = stack.pop()
        if node.id in found:
            continue
        found[node.id] = node
        if node.operation != "total":
            stack.extend(node.operands)
    return found
