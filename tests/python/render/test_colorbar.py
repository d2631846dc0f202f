"""The scale beside a picture: its numbers are the limits, its colours those of the map."""

from __future__ import annotations

import numpy as np
import pytest
from fake_simulation import FakeSimulation

from stark.render import render
from stark.render.colorbar import draw_colorbar, limits_of, numbers, title
from stark.render.colormaps import Colormap
from stark.render.overlay import Overlay


@pytest.mark.parametrize(
    ("limits", "unit", "texts", "shown"),
    [
        ((0.0, 2500.0), "Pa", ["0", "0.625", "1.25", "1.88", "2.5"], "kPa"),
        ((0.0, 1.0), "N", ["0", "0.25", "0.5", "0.75", "1"], "N"),
        ((-4e-7, 4e-7), "N", ["-400", "-200", "0", "200", "400"], "nN"),
        ((0.0, 4e9), "Pa", ["0", "1", "2", "3", "4"], "GPa"),
        ((0.0, 0.02), "m/s", ["0", "5", "10", "15", "20"], "mm/s"),
        ((0.0, 8000.0), "m/s", ["0", "2e3", "4e3", "6e3", "8e3"], "m/s"),
        ((0.0, 0.1), "", ["0", "0.025", "0.05", "0.075", "0.1"], ""),
        ((293.0, 293.4), "K", ["293", "293.1", "293.2", "293.3", "293.4"], "K"),
        ((0.0, 1000.0), "Pa", ["0", "0.25", "0.5", "0.75", "1"], "kPa"),
    ],
)
def test_numbers(limits, unit: str, texts, shown: str) -> None:
    assert numbers(limits, unit) == (texts, shown)


def test_numbers_at_the_ends_are_the_limits() -> None:
    random = np.random.default_rng(7)
    for _ in range(200):
        limits = tuple(sorted(random.normal(size=2) * 10.0 ** random.integers(-9, 12)))
        texts, shown = numbers(limits, "Pa")
        power = "pnum kMGT".index(shown.removesuffix("Pa") or " ") - 4
        read = [float(text) * 1000.0**power for text in texts]
        assert read == pytest.approx(np.linspace(*limits, 5), abs=5.1e-3 * max(map(abs, limits)))
        assert len(set(texts)) == 5


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
