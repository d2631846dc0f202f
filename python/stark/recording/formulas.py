"""Formulas of joints as data: the operations, in an order in which they can be done."""

from __future__ import annotations

from typing import Any

from ..joints.definition import JointFormula


def described_formula(formula: JointFormula) -> dict[str, Any] | None:
    """The formula of a joint that is not built in, as JSON; None for built-in ones.

    ``nodes`` are ["constant", value], ["input", source, point, component] or [operation, operands...], where
    operands are numbers of nodes before. Sources are "x", "x_prev" and "x_initial" of eight points (origin
    and axes of frame a, then of frame b), "time", "time_step" or the name of a parameter. ``outputs`` are
    residuals, in ``groups`` of (unit, how many), then coordinates. ``uses_motion``: whether there has to be a
    step."""
    if formula.residuals is None:
        return None
    graph = formula.residuals
    place = {key: k for k, key in enumerate(graph.nodes)}
    nodes: list[list[Any]] = []
    for key, node in graph.nodes.items():
        if node.operation == "input":
            nodes.append(["input", *formula.sources.get(key, ("unknown", 0, 0))])
        elif node.operation == "constant":
            nodes.append(["constant", float(node)])
        else:
            nodes.append([node.operation, *(place[operand.id] for operand in node.operands)])
    outputs = []
    for output in graph.outputs:
        if output.graph is None:  # a plain number
            nodes.append(["constant", float(output)])
        outputs.append(len(nodes) - 1 if output.graph is None else place[output.id])
    uses_motion = any(node[:2] in (["input", "x_prev"], ["input", "time_step"]) for node in nodes)
    return {
        "nodes": nodes,
        "outputs": outputs,
        "groups": [list(group) for group in formula.groups],
        "uses_motion": uses_motion,
    }
