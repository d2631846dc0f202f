"""Bodies by handle, name or pattern; opacities."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from stark.render.choosing import matching, opacities

NAMES = ["finger 1", "finger 2", "cup", "cup*"]


@pytest.mark.parametrize(
    ("chosen", "expected"),
    [
        ("cup", [2]),
        ("finger*", [0, 1]),
        (["cup", "finger 2"], [1, 2]),
        (SimpleNamespace(name="cup"), [2]),
        ("cup*", [3]),  # a name comes before a pattern
        ("*", [0, 1, 2, 3]),
        ((), []),
    ],
)
def test_what_matches(chosen, expected: list[int]) -> None:
    assert matching(chosen, NAMES, "bodies") == expected


@pytest.mark.parametrize(
    ("chosen", "message"),
    [
        ("cop", "hide = 'cop': no body has such a name; did you mean 'cup'"),
        ("table*", "hide = 'table\\*': no body has such a name; there are 'finger 1', 'finger 2'"),
        (3, "hide = 3: must be bodies, their names, or patterns"),
        (["cup", None], "hide = None: must be bodies"),
    ],
)
def test_what_does_not(chosen, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        matching(chosen, NAMES, "hide")


def test_opacities() -> None:
    assert opacities(None, NAMES) == [1.0] * 4
    assert opacities({"*": 0.5, "cup": 0.0}, NAMES) == [0.5, 0.5, 0.0, 0.5]
    with pytest.raises(ValueError, match=r"opacity of 'cup' = 1.5: must be in \[0, 1\]"):
        opacities({"cup": 1.5}, NAMES)
    with pytest.raises(ValueError, match="opacity = 'cup': must be a dictionary"):
        opacities("cup", NAMES)
