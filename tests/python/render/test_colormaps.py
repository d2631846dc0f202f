"""Colours of numbers."""

from __future__ import annotations

import numpy as np
import pytest

from stark.render.colormaps import COLORMAPS, Colormap, linear, srgb_bytes


def test_viridis_is_viridis() -> None:
    """Colours at 0, 0.25, 0.5, 0.75 and 1 from the table of its authors."""
    table = [
        (0.267004, 0.004874, 0.329415),
        (0.229739, 0.322361, 0.545706),
        (0.127568, 0.566949, 0.550556),
        (0.369214, 0.788888, 0.382914),
        (0.993248, 0.906157, 0.143936),
    ]
    assert Colormap("viridis")(np.linspace(0.0, 1.0, 5)) == pytest.approx(np.array(table), abs=0.01)


@pytest.mark.parametrize("name", ["viridis", "magma"])
def test_lightness_grows(name: str) -> None:
    luminance = linear(Colormap(name)(np.linspace(0.0, 1.0, 50))) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(luminance) > 0.0).all()


def test_beyond_the_limits_and_own_colours() -> None:
    for name in COLORMAPS:
        ends = Colormap(name)([-1.0, 0.0, 1.0, 7.0])
        assert np.array_equal(ends[0], ends[1]) and np.array_equal(ends[2], ends[3])
    own = Colormap([(0, 0, 0), (1, 0, 0), (1, 1, 1)])
    assert own([0.25, 0.75]) == pytest.approx(np.array([[0.5, 0, 0], [1, 0.5, 0.5]]))
    assert own(np.zeros((4, 5))).shape == (4, 5, 3)


def test_light_and_bytes_are_inverse() -> None:
    levels = np.arange(256)
    assert np.array_equal(srgb_bytes(linear(levels / 255.0)), levels)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ("jet", "colormap 'jet' is unknown; choose one of viridis, magma, coolwarm"),
        ([(0, 0, 0)], "at least two colours"),
        ([(0, 0, 0), (1, 2, 0)], r"each number in \[0, 1\]"),
        ([(0, 0, 0), (1, np.nan, 0)], r"each number in \[0, 1\]"),
        (3, "must be a name"),
    ],
)
def test_maps_that_are_none(points, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Colormap(points)
