"""Parameters of formulas: declarations, ranges, values that are shared or by element, messages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _scenes import sheet

import stark
from stark.formulas.parameters import Parameter, check_range, numbers_of, parameter, read_value


@pytest.mark.parametrize(
    ("bounds", "rule", "inside", "outside"),
    [
        ({}, "", [-1e300, 0.0, 1e300], []),
        ({"min": 0.0}, ">= 0", [0.0, 5.0], [-1e-300]),
        ({"above": 0.0}, "> 0", [1e-300], [0.0, -1.0]),
        ({"above": 0.0, "max": 0.5}, "> 0 and <= 0.5", [0.25, 0.5], [0.0, 0.5000001]),
        ({"min": -1.0, "below": 0.5}, ">= -1 and < 0.5", [-1.0, 0.4999], [0.5, -1.01]),
    ],
)
def test_ranges_are_what_they_say(
    bounds: dict[str, float], rule: str, inside: list[float], outside: list[float]
) -> None:
    declared = parameter(1.0, unit="N/m", **bounds)
    assert declared.rule == rule
    assert not declared.refused(np.array(inside)).any() and declared.refused(np.array(outside)).all()
    low, high, low_open, high_open = declared.range
    for value in [*inside, *outside]:
        within = (value > low or (value == low and not low_open)) and (
            value < high or (value == high and not high_open)
        )
        assert within == (value in inside)


def test_the_narrowest_of_several_bounds_counts() -> None:
    assert parameter(min=0.0, above=0.0, max=2.0, below=1.0).range == (0.0, 1.0, True, True)
    assert parameter(min=1.0, above=0.0, max=1.0, below=2.0).range == (1.0, 1.0, False, False)


def test_declarations_that_are_none_are_refused() -> None:
    with pytest.raises(stark.TraceError, match="unit = 5: must be a text"):
        parameter(1.0, unit=5)  # type: ignore[arg-type]
    for bound in ("0", True, [0.0]):
        with pytest.raises(stark.TraceError, match=r"min = .*number or None"):
            parameter(1.0, min=bound)  # type: ignore[arg-type]


def test_values_are_shared_or_have_a_row_for_each_element() -> None:
    wind = Parameter("wind", (3,), parameter(unit="N"))
    shared = read_value("gust", wind, (1, 2, 3), element_count=4)
    assert not shared.per_element and shared.numbers.tolist() == [1, 2, 3]
    each = read_value("gust", wind, np.arange(12).reshape(4, 3), element_count=4)
    assert each.per_element and each.numbers.tolist() == list(range(12))
    with pytest.raises(stark.InvalidArgument, match=r"gust: 'wind' \[N\] has the shape \(2, 3\).*\(4, 3\)"):
        read_value("gust", wind, np.zeros((2, 3)), element_count=4)


def test_values_are_copies() -> None:
    given = np.array([1.0, 2.0, 3.0])
    value = read_value("gust", Parameter("wind", (3,), parameter()), given, 1)
    given[:] = 0.0
    assert value.numbers.tolist() == [1, 2, 3]


@pytest.mark.parametrize("wrong", ["strong", None, [1j], [[1.0], [1.0, 2.0]]])
def test_what_are_no_numbers_is_refused_with_name_and_unit(wrong: Any) -> None:
    stiffness = Parameter("stiffness", (), parameter(unit="N/m"))
    with pytest.raises(stark.InvalidArgument, match=r"spring: 'stiffness' \[N/m\] = .*must be a number"):
        numbers_of("spring", stiffness, wrong)


def test_the_first_number_out_of_range_is_named_with_its_element() -> None:
    stiffness = Parameter("stiffness", (), parameter(unit="N/m", min=0.0))
    with pytest.raises(stark.InvalidArgument, match=r"stiffness\[1\] of element 1 = -2 N/m: must be >= 0"):
        check_range("spring", stiffness, np.array([1.0, -2.0, -3.0]), per_element=True)
    with pytest.raises(stark.InvalidArgument, match="stiffness = nan N/m: must be finite"):
        check_range("spring", stiffness, np.array(np.nan), per_element=False)


def test_defaults_and_given_values_reach_the_energy() -> None:
    @stark.energy
    def height(p: stark.Point, weight: float = stark.parameter(2.0, unit="N", min=0.0)):
        return weight * (p.x[2] - 1.0)

    scene, cloth = sheet(1, position=(0, 0, 3))
    scene.add(height(cloth.vertices))
    scene.add(height(cloth.vertices, weight=[1.0, 2.0, 3.0, 4.0]))
    sim = stark.Simulation(scene)
    assert sim.energies[0].energies.tolist() == [4, 4, 4, 4]
    assert sim.energies[1].energies.tolist() == [2, 4, 6, 8]
