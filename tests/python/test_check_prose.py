"""The lint of prose finds planted riddles and misspellings, and nothing in this repository."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import check_prose  # noqa: E402


def test_riddles_are_found_across_lines_and_comments(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "src").mkdir()
    (tmp_path / "docs/a.md").write_text("A good sentence.\n\nThe limit by the clock on\nthe wall.\n")
    (tmp_path / "src/a.h").write_text("// Full steps on the word\n// of the gradient, a switch\n// of all.\n")
    errors = check_prose.riddles(tmp_path)
    assert [error.split(": ")[0] for error in errors] == ["docs/a.md:3", "src/a.h:2", "src/a.h:1"]
    assert "'clock on the wall': write 'wall-clock time'" in errors[0]


def test_misspellings_are_found(tmp_path: Path) -> None:
    pytest.importorskip("codespell_lib")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    (tmp_path / "README.md").write_text("The stif" + "ness of a spring, by statics.\n")
    assert ["stif" + "ness" in line for line in check_prose.misspelled(tmp_path)] == [True]
