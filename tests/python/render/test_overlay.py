"""Lines, shapes and letters: what they cover, what they leave."""

from __future__ import annotations

import numpy as np
import pytest

from stark.render.overlay import INK, Overlay, rectangle


def blank(width: int = 60, height: int = 40) -> Overlay:
    return Overlay(np.full((height, width, 3), 255, dtype=np.uint8))


def covered(overlay: Overlay, ink: float = 0.0) -> float:
    """Area that is covered by black [px^2]."""
    return float((255.0 - overlay.picture[..., 0]).sum() / 255.0)


def test_a_line_covers_its_length_times_its_width() -> None:
    overlay = blank()
    overlay.lines([np.array([(10.0, 12.0), (40.0, 30.0)])], 3.0, (0, 0, 0))
    length = np.hypot(30.0, 18.0)
    assert covered(overlay) == pytest.approx(3.0 * length + 2.25 * np.pi, rel=0.02)


def test_lines_that_cross_cover_once_and_dots_are_round() -> None:
    overlay = blank()
    rows = [np.array([(5.0, 20.0), (55.0, 20.0)]), np.array([(30.0, 5.0), (30.0, 35.0)])]
    overlay.lines(rows, 4.0, (0, 0, 0))
    assert covered(overlay) == pytest.approx(4.0 * 80.0 + 8.0 * np.pi - 16.0, rel=0.02)
    dot = blank()
    dot.lines([np.array([(30.0, 20.0)])], 16.0, (0, 0, 0))
    assert covered(dot) == pytest.approx(64.0 * np.pi, rel=0.02)


@pytest.mark.parametrize("order", [1, -1])
def test_polygons_have_their_area_either_way_round(order: int) -> None:
    overlay = blank()
    overlay.polygon([(5.3, 5.1), (44.7, 12.2), (20.1, 36.4)][::order], (0, 0, 0))
    area = 0.5 * abs((44.7 - 5.3) * (36.4 - 5.1) - (20.1 - 5.3) * (12.2 - 5.1))
    assert covered(overlay) == pytest.approx(area, rel=0.03)
    half = blank()
    half.polygon(rectangle(10, 10, 30, 20), (0, 0, 0), 0.5)
    assert covered(half) == pytest.approx(100.0, rel=0.02)


def test_what_is_outside_is_cut_off() -> None:
    overlay = blank()
    overlay.lines([np.array([(-50.0, 10.0), (-20.0, 10.0)]), np.array([(np.nan, 1.0), (2.0, 2.0)])], 3.0)
    overlay.polygon([(100, 100), (110, 100), (110, 110)], INK)
    overlay.polygon([(np.inf, 0), (1, 1), (2, 0)], INK)
    overlay.image((70, 3), np.zeros((4, 4, 3)))
    assert covered(overlay) == 0.0
    overlay.image((-2, 38), np.zeros((4, 4, 3)))
    assert covered(overlay) == 4.0
    overlay.lines([np.array([(-50.0, 10.0), (110.0, 10.0)])], 2.0, (0, 0, 0))
    assert covered(overlay) == pytest.approx(124.0, rel=0.01)


def test_a_halo_is_paper_around_ink() -> None:
    overlay = Overlay(np.zeros((40, 60, 3), dtype=np.uint8))
    overlay.lines([np.array([(10.0, 20.0), (50.0, 20.0)])], 4.0, (1.0, 0.0, 0.0), halo=3.0)
    picture = overlay.picture.astype(int)
    assert tuple(picture[20, 30]) == (255, 0, 0)
    assert picture[24, 30].min() > 150 and picture[30, 30].max() == 0


def test_text_stands_where_it_is_put() -> None:
    overlay = blank(200, 60)
    width = overlay.text((20.0, 40.0), "1.25 kPa", 12.0)
    rows, columns = np.nonzero(overlay.picture[..., 0] < 128)
    assert columns.min() == pytest.approx(20, abs=2) and columns.max() == pytest.approx(20 + width, abs=2)
    assert rows.min() == pytest.approx(28, abs=1) and rows.max() == pytest.approx(40, abs=1)
