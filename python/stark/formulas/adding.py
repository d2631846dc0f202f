"""``scene.add``: checks of an energy where it starts, and its way into the core."""

from __future__ import annotations

from typing import Any

import numpy as np

from stark._core import InvalidArgument
from stark.arguments import given_name
from stark.caller import warn
from stark.formulas.binding import counted
from stark.formulas.diagnosis import culprit
from stark.formulas.energy import Binding, EnergyFormula
from stark.formulas.handle import Energy
from stark.formulas.inspection import sample_inputs, stacked
from stark.formulas.numbering import dependence, numbering_text
from stark.handle import SceneLink
from stark.selections import Points

_SAME_PLACE = 1e-9  # [m]
_CHUNK = 16384  # elements evaluated together, to bound the memory


def add_energy(scene: SceneLink, binding: Any, name: str | None) -> Energy:
    """Adds an energy to a scene; InvalidArgument says what is wrong with it."""
    if isinstance(binding, EnergyFormula):
        raise InvalidArgument(
            f"scene.add: {binding.name} is not bound to points; call it: "
            f"scene.add({binding.name}{binding.__signature__})"
        )
    if not isinstance(binding, Binding):
        raise InvalidArgument(
            f"scene.add: got {binding!r}: must be an energy on points, made by a function with "
            f"@stark.energy; bodies are added by add_cloth, add_solid and add_rigid"
        )
    binding._is_used()
    for body in binding.bodies:
        if body._scene is not scene:
            raise InvalidArgument(
                f"{binding.name}: '{body.name}' belongs to another scene: must be a body of this one; "
                f"add it here"
            )
    _require_moving(scene, binding)
    binding = binding.copy()
    check_start(binding)
    if label := dependence(binding)[0]:
        warn(f"energy '{binding.name}': {numbering_text(label)}")
    index = scene._core.add_energy(
        {
            "name": given_name(name),
            "formula_name": binding.name,
            "doc": binding.energy.doc,
            "formula": binding.trace.formula,
            "translation_invariant": binding.translation_invariant,
            "points": [column._description() for column in binding.columns],
            "values": binding.core_values(),
        }
    )
    return Energy(scene, index, binding)


def _require_moving(scene: SceneLink, binding: Binding) -> None:
    """Raises InvalidArgument for an energy on points of the world alone: nothing would move by it."""
    if binding.bodies:
        return
    labels = dict.fromkeys(label.split("[")[0].split(".")[0] for label in binding.trace.labels)
    x, y, z = binding.columns[0].positions[0]
    arguments = " and ".join(f"'{label}'" for label in labels)
    what = "fixed points" if len(binding.columns) > 1 else counted(len(binding.columns[0]), "fixed point")
    what += f" of the world, such as ({x:g}, {y:g}, {z:g}) m"
    raise InvalidArgument(
        f"{binding.name}: {arguments} got {'a fixed frame of the world' if binding.frames else what}, which "
        f"nothing moves: one argument at least must be points or a frame of a body; "
        f"{_remedy(scene, binding)}"
    )


def _remedy(scene: SceneLink, binding: Binding) -> str:
    """Names the body whose vertices were given as an array of positions."""
    given = binding.columns[0].positions
    for index in range(scene._core.body_count):
        name = scene._core.name(index)
        vertices: Points = scene[name].vertices
        for known in (vertices.rest_positions, vertices.positions):
            if known.shape == given.shape and np.allclose(known, given, rtol=0.0, atol=_SAME_PLACE):
                return f"they are where '{name}' has its vertices, whose points are scene['{name}'].vertices"
    return (
        "points of a body are cloth.vertices or box.points(...), not arrays of positions as mesh.vertices is"
    )


def check_start(binding: Binding) -> None:
    """Raises InvalidArgument when energy, gradient or Hessian of an element are not finite where the
    simulation starts, or at rest."""
    for begin in range(0, binding.element_count, _CHUNK):
        rows = np.arange(begin, min(begin + _CHUNK, binding.element_count))
        x = stacked(binding, "positions", rows)
        sample = binding.trace.formula.sample(sample_inputs(binding, x, x, rows))
        _require_finite(binding, sample.evaluate(2), x, x, rows, "at time 0")
        if any(body._rest_placement is not None for body in binding.bodies):
            rest = stacked(binding, "placed_rest_positions", rows)
            sample.set_positions(np.ascontiguousarray(rest).reshape(-1, 3))
            _require_finite(binding, sample.evaluate(2), rest, x, rows, "at rest")


def _require_finite(
    binding: Binding, flat: np.ndarray, x: np.ndarray, x_prev: np.ndarray, rows: np.ndarray, when: str
) -> None:
    """x, x_prev (elements, points, 3) are where the outputs `flat` were evaluated; rows: their numbers."""
    values = flat.reshape(len(rows), -1)
    wrong = ~np.isfinite(values)
    if not wrong.any():
        return
    element = int(np.flatnonzero(wrong.any(axis=1))[0])
    output = int(np.flatnonzero(wrong[element])[0])
    forces = 3 * len(binding.columns)
    what = "energy" if output == 0 else "force" if output <= forces else "stiffness (second derivative)"
    places = "; ".join(
        f"{label} = ({', '.join(f'{c:g}' for c in point)})"
        for label, point in zip(binding.trace.labels, x[element], strict=True)
    )
    others = int(wrong.any(axis=1).sum()) - 1
    one = slice(element, element + 1)
    found = culprit(binding, sample_inputs(binding, x[one], x_prev[one], rows[one]))
    cause = f"it comes from {found}" if found else "look for a division by zero, or a root or norm of zero"
    raise InvalidArgument(
        f"{binding.name}: the {what} of element {rows[element]} is {values[element, output]} {when}"
        + (f", and {others} more elements are not finite" if others else "")
        + f", with its points at {places} m: must be finite; guard it with stark.where, or add a small "
        f"offset; {cause}" + ("" if "File" in found else f"\n{binding.energy.location}")
    )
