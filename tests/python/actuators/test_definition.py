"""What definitions of actuators know of their handles."""

from __future__ import annotations

import copy
import pickle

import stark
from stark.actuators.definition import RESERVED, built_in


@stark.actuator
def detent(c: stark.Coordinate, depth: float = stark.parameter(unit="N m", min=0.0)):
    """Notches."""
    return -depth / 12.0 * stark.cos(12.0 * c.q)


def test_reserved_names_are_the_attributes_of_actuators() -> None:
    """A value of such a name would hide the attribute."""
    assert {name for name in vars(stark.Actuator) if not name.startswith("_")} == RESERVED


def test_actuators_are_pickled_by_name() -> None:
    for formula in (detent, built_in("velocity_motor")):
        for again in (pickle.loads(pickle.dumps(formula)), copy.copy(formula), copy.deepcopy(formula)):
            assert again is formula
