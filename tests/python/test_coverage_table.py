"""The tables of docs/coverage.md: lines by layer, from the files of coverage.py and gcovr."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
import coverage_table  # noqa: E402


def test_lines_are_counted_by_layer(tmp_path: Path) -> None:
    summary = {"num_statements": 10, "covered_lines": 7}
    files = {f"python/stark/{name}": {"summary": summary} for name in ("a.py", "cli/b.py", "cli/c.py")}
    (tmp_path / "python.json").write_text(json.dumps({"files": files}))
    rows = coverage_table.table(coverage_table.of_python(tmp_path / "python.json"))
    assert rows[2:5] == [
        "| `(package)` | 1 | 10 | 70.0 % |",
        "| `cli` | 2 | 20 | 70.0 % |",
        "| all | 3 | 30 | 70.0 % |",
    ]
    assert "`a.py` (3)" in rows[-1]


def test_lines_of_templates_count_once(tmp_path: Path) -> None:
    """gcovr has an entry for each instance; a line ran if one of them did."""
    lines = [{"line_number": 4, "count": 0}, {"line_number": 4, "count": 2}, {"line_number": 5, "count": 0}]
    lines.append({"line_number": 6, "count": 0, "gcovr/noncode": True})
    (tmp_path / "cpp.json").write_text(json.dumps({"files": [{"file": "src/stark/sim/a.h", "lines": lines}]}))
    assert coverage_table.of_cpp(tmp_path / "cpp.json") == {"sim/a.h": (2, 1)}


def test_only_measured_tables_change() -> None:
    page = (ROOT / "docs/coverage.md").read_text(encoding="utf-8")
    changed = coverage_table.fill(page, "cpp", ["| new |"])
    assert "<!-- cpp -->\n| new |\n<!-- end of cpp -->" in changed
    python = page.partition("<!-- python -->")[2].partition("<!-- end of python -->")[0]
    assert python in changed
    with pytest.raises(SystemExit, match="no place for the table 'java'"):
        coverage_table.fill(page, "java", [])
