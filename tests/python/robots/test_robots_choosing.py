"""Which joints of a robot names, patterns and groups mean."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from robots._robots import ARM

import stark
from stark.robots.choosing import chosen_rows

NAMES = ("turn", "elbow", "left_slide", "right_slide")


def test_names_patterns_and_groups_in_the_order_that_they_are_given() -> None:
    assert chosen_rows("arm", None, NAMES, {}) == [0, 1, 2, 3]
    assert chosen_rows("arm", ["right*", "elbow", "*_slide"], NAMES, {}) == [3, 1, 2]
    assert chosen_rows("arm", ("all", "turn"), NAMES, {"all": ("elbow", "turn")}) == [1, 0]
    assert chosen_rows("arm", np.array(["elbow", "turn"]), NAMES, {}) == [1, 0]  # type: ignore[arg-type]
    with pytest.raises(
        stark.InvalidArgument, match=r"arm: joints = \[\]: must be at least one; leave it out"
    ):
        chosen_rows("arm", [], NAMES, {})  # a selection that found nothing would drive nothing
    with pytest.raises(stark.InvalidArgument, match=r"arm: joints = 'wheel_\*': must be the name or pattern"):
        chosen_rows("arm", "wheel_*", NAMES, {})


@pytest.mark.parametrize(
    "joints", [1.0, True, {"elbow": 400.0}, {"elbow"}, lambda name: True, np.zeros((1, 1)), np.array("turn")]
)
def test_anything_but_names_is_refused(joints: Any) -> None:
    """Errors were on iterating, and the numbers of a mapping were ignored."""
    pytest.importorskip("yourdfpy")
    robot = stark.Scene().add_robot(ARM)
    with pytest.raises(stark.InvalidArgument, match=r"'arm': joints = .*: must be the name of a joint"):
        robot.add_efforts(joints)
    assert not robot.drives
