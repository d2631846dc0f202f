"""Energies of triangles that depend on which corner comes first: ``t.F`` has its first axis along the first
edge of each triangle, so a law with directions that is written with it differs from triangle to triangle."""

from __future__ import annotations

import numpy as np

from stark.formulas.binding import BoundEnergy
from stark.formulas.inspection import sample_inputs, stacked

_MOST_ELEMENTS = 64
_MOVE = 0.05  # random displacements, of the size of an element
_TOLERANCE = 1e-8  # of a change, relative to the change of the energy by the displacements


def dependence(binding: BoundEnergy) -> tuple[str, float]:
    """The triangle argument whose energies change when corners are counted from another one, and by how much,
    relative to the energies; empty if there is none. Values by element that are no single numbers may tell
    the triangles apart on purpose."""
    told_apart = any(v.per_element and v.array.ndim > 1 for v in binding.values.values())
    if not binding.trace.local_axes or binding.trace.totals is not None or told_apart:
        return "", 0.0
    rows = np.arange(min(binding.element_count, _MOST_ELEMENTS))
    start = stacked(binding, "positions", rows)
    size = np.linalg.norm(start - start.mean(axis=1, keepdims=True), axis=2).max()
    moves = np.random.default_rng(0).uniform(-_MOVE * size, _MOVE * size, (2, *start.shape))
    inputs = sample_inputs(binding, start + moves[0], start + 0.5 * moves[1], rows)
    found = ("", 0.0)
    for label in sorted(binding.trace.local_axes):
        change = _change(binding, inputs, label, start.shape)
        found = max(found, (label, change), key=lambda each: each[1]) if change > _TOLERANCE else found
    return found


def _change(binding: BoundEnergy, inputs: dict[str, np.ndarray], label: str, shape: tuple[int, ...]) -> float:
    """Of the energies, over the largest, when the corners of one argument are counted from the next."""
    corners = [binding.trace.labels.index(f"{label}[{k}]") for k in range(3)]
    order = np.arange(shape[1])
    order[corners] = corners[1:] + corners[:1]
    turned = dict(inputs)
    for name in ("x", "x_prev", "X", "x_initial"):
        turned[name] = np.ascontiguousarray(inputs[name].reshape(shape)[:, order]).reshape(-1, 3)
    first, second = (binding.trace.formula.sample(each).evaluate(0) for each in (inputs, turned))
    return float(np.abs(second - first).max() / max(np.abs(first).max(), np.finfo(float).tiny))


def numbering_text(label: str) -> str:
    """What is wrong, and what to write instead."""
    return (
        f"the energy of a triangle depends on which of its corners comes first, as {label}.F has its first "
        f"axis along the first edge of each triangle; for directions of the material write "
        f"{label}.F_along(direction), with a direction in the rest mesh"
    )
