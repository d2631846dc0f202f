"""Grids, draws and Latin hypercubes."""

from __future__ import annotations

import numpy as np
import pytest

from stark.study.sampling import Range, grid, latin_hypercube, one_at_a_time, random


def test_a_grid_has_all_combinations_and_the_last_option_varies_fastest() -> None:
    rows = grid({"a": [1, 2], "b": Range(0.0, 1.0, 3)})
    assert rows == [{"a": a, "b": b} for a in (1, 2) for b in (0.0, 0.5, 1.0)]
    assert [row["x"] for row in grid({"x": Range(0.01, 1.0, 3, log=True)})] == pytest.approx([0.01, 0.1, 1.0])
    assert grid({"x": Range(0.1, 0.3, 3)})[-1]["x"] == 0.3  # ends are met exactly


def test_one_at_a_time_has_each_base_and_each_change_alone() -> None:
    rows = one_at_a_time([{"k": 1}, {"k": 2}], {"a": [5.0, 6.0], "b": Range(0.0, 1.0, 2)})
    changes = [{}, {"a": 5.0}, {"a": 6.0}, {"b": 0.0}, {"b": 1.0}]
    assert rows == [{"k": k} | change for k in (1, 2) for change in changes]


def test_draws_follow_their_seed_and_stay_in_range() -> None:
    axes = {"x": Range(-1.0, 2.0), "k": Range(1, 3, whole=True), "text": ["a", "b"]}
    rows = random(axes, 300, seed=4)
    assert rows == random(axes, 300, seed=4) != random(axes, 300, seed=5)
    assert all(-1.0 <= row["x"] <= 2.0 and type(row["k"]) is int for row in rows)
    # Each of three equally likely numbers within 5 standard deviations of 100.
    assert all(abs(sum(row["k"] == k for row in rows) - 100) < 5 * 8.2 for k in (1, 2, 3))
    assert {row["text"] for row in rows} == {"a", "b"}


def test_a_latin_hypercube_has_one_draw_in_each_part_of_each_range() -> None:
    pytest.importorskip("scipy")
    rows = latin_hypercube({"x": Range(0.0, 8.0), "y": Range(1.0, 256.0, log=True)}, 8, seed=1)
    assert sorted(int(row["x"]) for row in rows) == list(range(8))
    assert sorted(int(np.log2(row["y"])) for row in rows) == list(range(8))
    assert rows == latin_hypercube({"x": Range(0.0, 8.0), "y": Range(1.0, 256.0, log=True)}, 8, seed=1)
