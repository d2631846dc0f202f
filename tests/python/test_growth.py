"""Tables of growth: benchmarks/growth.py."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from benchmarks import growth, growth_page  # noqa: E402


def rows_of(kind: str, power: float, bytes_each: float) -> list[dict[str, Any]]:
    """Rows whose time of an iteration grows with a power of the unknowns."""
    found = []
    for cells in growth.SIZES[kind]:
        dofs = growth.unknowns(kind, cells)
        row: dict[str, Any] = {"kind": kind, "cells": cells, "dofs": dofs, "steps": 2, "failure": None}
        row |= {"newton_iterations": 20, "linear_iterations": 1000, "factorizations": 3}
        row |= {"cpu_s": 20 * 1e-6 * dofs**power}
        row |= {"bytes": bytes_each * dofs, "phases": dict.fromkeys(growth.PHASES, 1.0)}
        found.append(row)
    return found


def test_sizes_are_those_of_the_bars() -> None:
    assert growth.unknowns("solids", 40) == 398_763
    assert growth.unknowns("cloth", 576) == 998_787
    for kind, sizes in growth.SIZES.items():
        assert 8e3 < growth.unknowns(kind, sizes[0]) < 1.1e4
        assert growth.unknowns(kind, sizes[-1]) > 0.95e6


def test_slopes_and_bars(tmp_path: Path) -> None:
    rows = rows_of("solids", 1.1, 2000.0) + rows_of("cloth", 1.4, 3000.0)
    assert growth.slope(rows[:5], "all") == pytest.approx(1.1)
    text = growth_page.page(rows, {"flops": 1e11, "bytes": 1e10})
    assert "power 1.10. The bar of 1.15 is **met**" in text
    assert "power 1.40. The bar of 1.3 is **not met**" in text
    assert text.count("the bar of 2.5 kB is **met**") == 1  # of solids; cloth has none
    assert "the bar of 2.5 kB is **not met**" in growth_page.page(
        rows_of("solids", 1.1, 3000.0) + rows[5:], {"flops": 1e11, "bytes": 1e10}
    )
    growth_page.plot(rows, tmp_path / "growth.svg")
    root = ElementTree.parse(tmp_path / "growth.svg").getroot()
    assert len(root.findall("{*}circle")) == 2 * len(rows)


def test_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    row = growth.measure_row("cloth", 20)
    assert row["dofs"] == growth.unknowns("cloth", 20) and row["failure"] is None
    assert row["bytes"] >= 0 and growth.per_iteration(row)["all"] > 0.0
