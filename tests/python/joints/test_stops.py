"""Stops that are no stops."""

from __future__ import annotations

import math

import pytest

import stark
from stark import InvalidArgument, StarkWarning
from stark.joints.stops import checked_stops


def test_stops_at_infinity_are_to_be_left_out() -> None:
    """They were called degrees, and then not finite."""
    with pytest.raises(InvalidArgument, match=r"hinge: add_limit: upper = inf: .* joint\.add_limit\(lower="):
        checked_stops("hinge", -1.0, math.inf, True)
    with pytest.raises(InvalidArgument, match=r"lower = -inf: must be finite; .* joint\.add_limit\(upper="):
        checked_stops("hinge", -math.inf, math.inf, True)
    with pytest.raises(InvalidArgument, match="lower = nan: must be finite"):
        checked_stops("hinge", math.nan, 1.0, True)
    assert checked_stops("hinge", -1.0, None, True) == {"lower": -1.0}


def test_degrees_are_said_of_angles_alone() -> None:
    with pytest.warns(StarkWarning, match="lower = -90 rad, upper = 90 rad: angles are in radians"):
        checked_stops("hinge", -90, 90, True)
    assert checked_stops("slider", -90, 90, False) == {"lower": -90, "upper": 90}


def test_a_tilt_has_no_limit_below_zero() -> None:
    """It was off by 1 rad at time 0, said the simulation."""
    scene = stark.Scene()
    pole = scene.add_box(0.1, mass=1.0)
    with pytest.raises(stark.InvalidArgument, match=r"add_tilt: limit = -1\.0 rad: must be >= 0"):
        scene.add_tilt(None, pole, anchor=(0, 0, 0), axis="z", limit=-1.0)
    assert not scene.joints and not scene.actuators
    with pytest.warns(StarkWarning, match="add_limit: upper = 90 rad: angles are in radians"):
        scene.add_tilt(None, pole, anchor=(0, 0, 0), axis="z", limit=90)
