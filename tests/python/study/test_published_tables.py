"""Tables of studies that the documentation shows belong to the scenes of this version."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from stark.study.plan import Plan
from stark.study.task import tasks

ROOT = Path(__file__).parents[3]


def _rows(name: str) -> list[dict[str, str]]:
    with (ROOT / f"benchmarks/results/{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("name", ["cup", "robot_towel", "robot_towel_full"])
def test_keys_are_those_of_the_plan(name: str, tmp_path: Path) -> None:
    rows = _rows(name)
    planned = tasks(Plan.read(ROOT / f"examples/{name}.toml"), tmp_path)
    assert [row["key"] for row in rows] == [task.key for task in planned]
    assert {row["status"] for row in rows} == {"complete"}


def test_runs_of_sensitivity_are_of_their_plans(tmp_path: Path) -> None:
    """Some runs of the two plans, each beside the run of the sixteen that it changes one option of."""
    rows = _rows("robot_towel_sensitivity")
    planned = {
        (name, task.key): task.options
        for name in {row["plan"] for row in rows}
        for task in tasks(Plan.read(ROOT / f"examples/{name}.toml"), tmp_path)
    }
    names = ("towel", "floor", "cells")
    unchanged = {tuple(row[f"option.{name}"] for name in names) for row in _rows("robot_towel")}
    for row in rows:
        options = planned[row["plan"], row["key"]]
        assert float(row["factor"]) == options[row["changed"]]
        assert tuple(row[name] for name in names) in unchanged
        assert (row["status"] == "complete") == (row["outcome"] in {"over", "pushed", "stuck"})
