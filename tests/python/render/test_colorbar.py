"""The scale beside a picture: its numbers are round, its colours those of the map."""

from __future__ import annotations

import numpy as np
import pytest
from fake_simulation import FakeSimulation

from stark.render import render
from stark.render.colorbar import draw_colorbar, limits_of, numbers, ticks, title
from stark.render.colormaps import Colormap
from stark.render.overlay import Overlay


@pytest.mark.parametrize(
    ("limits", "unit", "texts", "shown"),
    [
        ((0.0, 2500.0), "Pa", ["0", "0.5", "1", "1.5", "2", "2.5"], "kPa"),
        ((0.0, 1.0), "N", ["0", "0.2", "0.4", "0.6", "0.8", "1"], "N"),
        ((-4e-7, 4e-7), "N", ["-400", "-200", "0", "200", "400"], "nN"),
        ((0.0, 4e9), "Pa", ["0", "1", "2", "3", "4"], "GPa"),
        ((0.0, 0.02), "m/s", ["0", "5", "10", "15", "20"], "mm/s"),
        ((0.0, 8000.0), "m/s", ["0", "2e3", "4e3", "6e3", "8e3"], "m/s"),
        ((0.0, 0.1), "", ["0", "0.02", "0.04", "0.06", "0.08", "0.1"], ""),
        ((293.0, 293.4), "K", ["293", "293.1", "293.2", "293.3", "293.4"], "K"),
        ((0.0, 1000.0), "Pa", ["0", "0.2", "0.4", "0.6", "0.8", "1"], "kPa"),
        ((0.0, 1873.21), "Pa", ["0", "0.5", "1", "1.5"], "kPa"),
        ((1003.7, 1021.3), "", ["1005", "1010", "1015", "1020"], ""),
    ],
)
def test_numbers(limits, unit: str, texts, shown: str) -> None:
    assert numbers(limits, unit) == (texts, shown)


def test_numbers_are_round_and_between_the_limits() -> None:
    random = np.random.default_rng(7)
    for _ in range(200):
        limits = tuple(sorted(random.normal(size=2) * 10.0 ** random.integers(-9, 12)))
        texts, shown = numbers(limits, "Pa")
        power = "pnum kMGT".index(shown.removesuffix("Pa") or " ") - 4
        read = np.array([float(text) * 1000.0**power for text in texts])
        assert read == pytest.approx(ticks(limits), rel=1e-12, abs=1e-12 * max(map(abs, limits)))
        assert 2 <= len(read) <= 6 and limits[0] <= read.min() and read.max() <= limits[1]
        step = (read[-1] - read[0]) / (len(read) - 1)
        assert np.diff(read) == pytest.approx(step, rel=1e-6)
        assert f"{step:.3e}"[0] in "125" and f"{step:.3e}"[1:5] == ".000"
        assert read / step == pytest.approx(np.round(read / step), abs=1e-6)
        assert max(read[0] - limits[0], limits[1] - read[-1]) < step


@pytest.mark.parametrize("limits", [(1.0, np.nextafter(1.0, 2.0)), (0.0, 5e-324), (-1.7e308, 1.7e308)])
def test_limits_at_the_edge_of_double_precision_have_numbers(limits) -> None:
    assert len(numbers(limits, "")[0]) >= 2


def test_titles() -> None:
    assert title("contact force", "mN") == "contact force [mN]" and title("strain", "") == "strain"


@pytest.mark.parametrize(
    ("values", "limits"),
    [
        ([0.0, 3.0], (0.0, 3.0)),
        ([1.0, 3.0], (0.0, 3.0)),
        ([290.0, 300.0], (290.0, 300.0)),
        ([-1.0, 3.0], (-1.0, 3.0)),
        ([0.0, 0.0], (0.0, 1.0)),
        ([5.0, 5.0], (5.0, 6.0)),
        ([], (0.0, 1.0)),
    ],
)
def test_limits_that_are_not_given(values, limits) -> None:
    assert limits_of([np.array(values)]) == limits


def test_colours_of_the_bar() -> None:
    """The bar has half of the height; its middle column goes through the map from below."""
    overlay = Overlay(np.full((400, 600, 3), 120, dtype=np.uint8))
    draw_colorbar(overlay, Colormap([(1, 0, 0), (0, 0, 1)]), (0.0, 1.0), "x", "")
    picture = overlay.picture.astype(int)
    pure = (picture[..., 1] == 0) & (picture[..., 0] + picture[..., 2] > 250)
    column = int(np.median(np.nonzero(pure)[1]))
    rows = np.nonzero(pure[:, column])[0]
    assert rows.min() == pytest.approx(100, abs=2) and rows.max() == pytest.approx(299, abs=2)
    assert picture[rows, column, 0] == pytest.approx(255 * (rows - 99.5) / 200, abs=2)
    assert (picture[:, :300] == 120).all()


def test_limits_are_those_of_the_colours_in_the_picture() -> None:
    """With limits far above the values all is the first colour, far below the last one."""
    sim = FakeSimulation()
    x = sim.bodies[0].positions[:, 0]
    own = [(0.1, 0.1, 0.9), (0.9, 0.1, 0.1)]
    for limits, red in (((1.0, 2.0), False), ((-2.0, -1.0), True)):
        picture = render(
            sim, 160, 90, field={"cloth": x}, limits=limits, colormap=own, quality="draft", target="cloth"
        ).astype(int)
        left = picture[:, :120]
        reddish, bluish = left[..., 0] > left[..., 2] + 60, left[..., 2] > left[..., 0] + 60
        assert (reddish.mean() > 0.1) == red and (bluish.mean() > 0.1) == (not red)


@pytest.mark.parametrize("limits", [(1, 1), (2, 1), (0, np.inf), (0, 1, 2), "all"])
def test_limits_that_are_wrong(limits) -> None:
    sim = FakeSimulation()
    with pytest.raises(ValueError, match="limits = "):
        render(sim, 16, 16, field={"cloth": sim.bodies[0].positions[:, 0]}, limits=limits)
