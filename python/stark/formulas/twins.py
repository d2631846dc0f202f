"""Energies that are in a scene twice, as when a cell of a notebook ran a second time: their forces are then
twice as large, which nothing else shows."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Container, Hashable, Iterable
from typing import Any

import numpy as np

from stark.formulas.binding import BoundEnergy
from stark.formulas.handle import Energy


def twin_warnings(energies: Iterable[Energy], followed: Container[tuple[str, int, str]]) -> list[str]:
    """One for each energy of the same formula, points and values as one before it. Not of those that were
    given a name of their own, whose values are zero until they are set, or follow functions of time."""
    candidates = [energy for energy in energies if _may_be_twin(energy, followed)]
    alike = Counter(map(_kind, candidates))
    found: list[str] = []
    first: dict[Hashable, Energy] = {}
    for energy in candidates:
        if alike[_kind(energy)] == 1:
            continue
        twin = first.setdefault((_kind(energy), _given(energy._binding)), energy)
        if twin is not energy:
            found.append(
                f"energy '{energy.name}' is '{twin.name}' once more, with the same points and values: "
                f"both act, and their forces add up: leave one out, or give it a name= if this is meant"
            )
    return found


def _may_be_twin(energy: Energy, followed: Container[tuple[str, int, str]]) -> bool:
    binding = energy._binding
    is_named = not re.fullmatch(rf"{re.escape(binding.name)}(_\d+)?", energy.name)
    values = binding.values
    is_off = bool(values) and not any(value.array.any() for value in values.values())
    return not (is_named or is_off or any(("energy", energy._index, name) in followed for name in values))


def _kind(energy: Energy) -> Hashable:
    return energy._binding.name, energy._binding.element_count, energy._binding.frames


def _given(binding: BoundEnergy) -> Hashable:
    """What an energy was bound to, with its present values."""
    values = {name: value.array for name, value in binding.values.items()}
    return _key([values, binding.constants, [column._description() for column in binding.columns]])


def _key(given: Any) -> Hashable:
    if isinstance(given, dict):
        return tuple((name, _key(part)) for name, part in sorted(given.items()))
    if isinstance(given, (list, tuple)):
        return tuple(map(_key, given))
    array = np.asarray(given)
    return given if array.dtype == object else (array.shape, array.dtype.str, array.tobytes())
