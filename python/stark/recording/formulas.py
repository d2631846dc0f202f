"""Formulas of joints as data: the operations, in an order in which they can be done."""

from __future__ import annotations

from typing import Any

from ..formulas.listing import listed
from ..joints.definition import JointFormula


def described_formula(formula: JointFormula) -> dict[str, Any] | None:
    """The formula of a joint that is not built in, as JSON; None for built-in ones.

    ``nodes`` and ``outputs`` are those of ``formulas.listing.listed``: points are eight (origin and axes of
    frame a, then of frame b); outputs are residuals, in ``groups`` of (unit, how many), then coordinates.
    ``uses_motion``: whether there has to be a step."""
    if formula.residuals is None:
        return None
    nodes, outputs = listed(formula.residuals, formula.sources)
    uses_motion = any(node[:2] in (["input", "x_prev"], ["input", "time_step"]) for node in nodes)
    return {
        "nodes": nodes,
        "outputs": outputs,
        "groups": [list(group) for group in formula.groups],
        "uses_motion": uses_motion,
    }
