"""Formulas of users in reproducers: rows as scene documents have them, each once, by number."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from stark.actuators.definition import ActuatorFormula
from stark.document import recorded
from stark.document.errors import DocumentError
from stark.document.format import FORMULA
from stark.formulas.binding import BoundEnergy
from stark.joints.definition import JointFormula

Row = dict[str, Any]


class WrittenFormulas:
    """Formulas behind the objects of the core that a scene was given. ``rows``: those that were asked for."""

    def __init__(self, scene: Any) -> None:
        # Handles are alive, so that none of their objects has the address of another.
        self._describe: dict[int, Callable[[], Row]] = {id(core): row for core, row in _descriptions(scene)}
        self._numbers: dict[int, int] = {}
        self.rows: list[Row] = []

    def number(self, core: Any) -> int | None:
        """Of the formula behind an object of the core; None where there is none, or none that can be read."""
        if id(core) not in self._describe:
            return None
        if id(core) not in self._numbers:
            row = json.loads(json.dumps(self._describe[id(core)]()))
            try:
                FORMULA.read(row, "formula", {})
            except DocumentError:  # too long
                del self._describe[id(core)]
                return None
            self._numbers[id(core)] = len(self.rows)
            self.rows.append(row)
        return self._numbers[id(core)]


def _descriptions(scene: Any) -> Iterator[tuple[Any, Callable[[], Row]]]:
    """Objects of the core that stand for formulas of the user, and what describes these."""
    for energy in scene.energies:
        yield energy._binding.trace.formula, _energy(energy._binding)
    for material in [body._shared.get("material") for body in scene.bodies] + [
        layer.material for layer in scene.layers
    ]:
        if material is not None and material._recorded is not None:
            yield material.law, _law(material)
    for handle in [*scene.joints, *scene.actuators]:
        formula = handle.formula
        if formula.recorded is not None:
            yield formula.core, _definition(formula)


def _energy(binding: BoundEnergy) -> Callable[[], Row]:
    return lambda: recorded.of_energy(binding)


def _law(material: Any) -> Callable[[], Row]:
    function, isotropic = material._recorded
    return lambda: recorded.of_law(function, isotropic, material.law)


def _definition(formula: JointFormula | ActuatorFormula) -> Callable[[], Row]:
    if isinstance(formula, JointFormula):
        return lambda: recorded.of_joint(formula)
    return lambda: recorded.of_actuator(formula)


class ReadFormulas:
    """Formulas of a file, each made when it is first asked for."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self._rows = rows
        self._made: dict[int, Any] = {}

    def core(self, number: int) -> Any:
        """What the core has of it: a formula of an energy, a law, the definition of a joint or actuator.
        Raises DocumentError, IndexError or TypeError for what is none."""
        if number not in self._made:
            where = f"formulas[{number}]"
            made = recorded.made(FORMULA.read(self._rows[number], where, {}), where)
            is_energy = isinstance(made, recorded.ReadFormula)
            self._made[number] = made.trace().formula if is_energy else made.core
        return self._made[number]
