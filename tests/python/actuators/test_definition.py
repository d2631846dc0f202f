"""What definitions of actuators know of their handles."""

from __future__ import annotations

import stark
from stark.actuators.definition import RESERVED


def test_reserved_names_are_the_attributes_of_actuators() -> None:
    """A value of such a name would hide the attribute."""
    assert {name for name in vars(stark.Actuator) if not name.startswith("_")} == RESERVED
