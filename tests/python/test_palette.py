"""Colours of bodies: palettes first, then colours that differ."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from stark import palette
from stark.palette import FIXED, _oklab, body_colors


def bodies(count: int, kind: str = "rigid", motion: str = "dynamic", color=None) -> list[SimpleNamespace]:
    return [SimpleNamespace(kind=kind, motion=motion, color=color) for _ in range(count)]


def test_own_colours_fixed_bodies_and_kinds() -> None:
    scene = [*bodies(1, color=(1.0, 0.0, 0.5)), *bodies(2, motion="fixed"), *bodies(1, "cloth")]
    assert body_colors(scene) == [(1.0, 0.0, 0.5), FIXED, FIXED, (0.87, 0.44, 0.34)]


def test_hundreds_of_bodies_differ_from_their_neighbours() -> None:
    colors = body_colors(bodies(300))
    assert len(set(colors)) == 300
    seen = _oklab(colors)
    apart = np.linalg.norm(seen[:, None] - seen[None], axis=2) + 9.0 * np.eye(300)
    assert apart[:40, :40].min() > 0.05  # about twice what the eye tells apart side by side
    assert apart.min() > 0.005


def test_kinds_that_share_a_palette_do_not_share_colours() -> None:
    scene = [*bodies(4), *bodies(4, "rod"), *bodies(6, "cloth"), *bodies(2, color=(0.33, 0.45, 0.66))]
    assert len(set(body_colors(scene)[:14])) == 14


def test_colours_stay_when_bodies_are_added() -> None:
    assert body_colors(bodies(50))[:20] == body_colors(bodies(20))


def test_oklab_of_known_colours() -> None:
    """White, and red from the table of its author."""
    expected = [[1.0, 0.0, 0.0], [0.628, 0.225, 0.126]]
    assert np.abs(_oklab([(1, 1, 1), (1, 0, 0)]) - expected).max() < 1e-3


def test_many_bodies_compare_candidates_as_seen_once(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []
    see = palette._oklab
    monkeypatch.setattr(palette, "_oklab", lambda colors: sizes.append(len(colors)) or see(colors))
    palette._seen_candidates.cache_clear()
    assert len(set(body_colors(bodies(200)))) == 200
    assert sum(sizes) < 2 * len(palette._candidates()) + 200
