"""Tables of studies that the documentation shows belong to the scenes of this version."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from stark.study.plan import Plan
from stark.study.task import tasks

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("name", ["cup", "robot_towel"])
def test_keys_are_those_of_the_plan(name: str, tmp_path: Path) -> None:
    with (ROOT / f"benchmarks/results/{name}.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    planned = tasks(Plan.read(ROOT / f"examples/{name}.toml"), tmp_path)
    assert [row["key"] for row in rows] == [task.key for task in planned]
    assert {row["status"] for row in rows} == {"complete"}
