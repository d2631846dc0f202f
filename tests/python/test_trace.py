"""The table of Newton iterations: benchmarks/trace.py."""

from __future__ import annotations

import csv
import itertools
import math
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_every_iteration_has_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    import benchmarks.trace as tool

    rows = tool.trace("stack", {}, 0.2, None)
    steps = {row["step"] for row in rows}
    assert len(steps) >= 6
    for step in steps:
        numbers = [row["iteration"] for row in rows if row["step"] == step]
        assert numbers == sorted(numbers)
    assert all(0.0 < row["bound"] <= 1.0 or row["length"] > 1.0 for row in rows)
    assert all(math.isfinite(row["motion"]) and row["residual"] >= 0.0 for row in rows)
    # Where a full step ends a minimisation, the quadratic model was right. That of friction is none of its
    # energy (theory, eq. 20d).
    rows = tool.trace("stack", {"contact.friction": False}, 0.3, None)
    ends = [a for a, b in itertools.pairwise(rows) if a["step"] != b["step"] and a["motion"] > 1e-6]
    assert len(ends) >= 4
    assert all(row["gain"] == pytest.approx(1.0, abs=0.05) for row in ends if row["length"] == 1.0)

    path = tmp_path / "rows.csv"
    monkeypatch.setattr(sys, "argv", ["trace", "stack", "--until", "0.05", "--csv", str(path)])
    assert tool.main() == 0
    with path.open(newline="") as file:
        assert next(csv.reader(file)) == [*tool.COLUMNS, "cause"]


def test_larger_scenes_go_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """They had to be given as paths."""
    monkeypatch.syspath_prepend(str(ROOT))
    import benchmarks.trace as tool

    asked = []

    def load(scene: object) -> None:
        asked.append(scene)
        raise RuntimeError("not built")

    monkeypatch.setattr(tool, "load", load)
    for name in ("rigid_pile_500", "stack", "some/file.py"):
        with pytest.raises(RuntimeError, match="not built"):
            tool.trace(name, {}, 0.1, None)
    folder = ROOT / "benchmarks" / "scenes"
    assert asked == [folder / "rigid_pile_500.py", "stack", "some/file.py"]
    assert set(tool.RULES) == {p.stem for p in folder.glob("*.py")} - {"__init__", "__main__"}
