"""The table of a study as CSV and Parquet."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import pytest

from stark.study.table import columns, row, with_result, write_csv, write_parquet

RESULT = {
    "status": "complete", "message": 'a, "b"', "observables": {"y": 0.1, "x": math.nan},
    "measured": {"z": 3.0},
    "simulated": 1.0, "steps": 2, "rejected_steps": 0, "newton_iterations": 4, "max_contacts": 5,
    "state_hash": "ab", "wall": 0.3, "cpu": 0.2, "host": "here",
}  # fmt: skip
ROWS = [
    row(0, "k0", 0, {"angle": 0.1, "name": "a"}, "waiting"),
    with_result(row(1, "k1", 0, {"angle": 2, "name": "b"}, "waiting"), RESULT, 1),
]


def test_columns_have_one_order() -> None:
    assert columns(ROWS) == columns(ROWS[::-1]) == [
        "run", "key", "option.angle", "option.name", "repetition", "status", "message", "observables.x",
        "observables.y", "measured.z", "simulated", "steps", "rejected_steps", "newton_iterations",
        "max_contacts", "state_hash", "cost.wall", "cost.cpu", "cost.attempts", "cost.host",
    ]  # fmt: skip


def test_csv_gives_back_what_went_in(tmp_path: Path) -> None:
    write_csv(tmp_path / "table.csv", ROWS)
    with (tmp_path / "table.csv").open(newline="") as file:
        first, second = csv.DictReader(file)
    assert first["status"] == "waiting" and first["observables.y"] == "" and first["option.angle"] == "0.1"
    assert second["message"] == 'a, "b"' and float(second["observables.y"]) == 0.1
    assert math.isnan(float(second["observables.x"]))


def test_parquet_gives_back_what_went_in(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    write_parquet(tmp_path / "table.parquet", ROWS)
    table = parquet.read_table(tmp_path / "table.parquet").to_pydict()
    assert list(table) == columns(ROWS)
    assert table["option.angle"] == [0.1, 2.0] and table["steps"] == [None, 2]
    assert table["observables.y"] == [None, 0.1] and table["state_hash"] == [None, "ab"]
