"""The guide runs as it is written, its listing is what is printed, and the example passes its own check."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
GUIDE = (ROOT / "docs/symbolic.md").read_text()


def test_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    fenced = re.findall(r"^```(\w*)\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)
    blocks = [text for language, text in fenced if language == "python"]
    (listing,) = [text for language, text in fenced if language == ""]
    names: dict[str, object] = {"__name__": "guide"}
    for block in blocks:
        exec(compile(block, "docs/symbolic.md", "exec"), names)
    assert names["by_t"].shape == (50, 2, 3)
    assert listing in capsys.readouterr().out


def test_the_example_checks_itself(capsys: pytest.CaptureFixture[str]) -> None:
    main = runpy.run_path(str(ROOT / "examples/fit_ellipse.py"))["main"]
    assert main() == 0
    assert "check: passed" in capsys.readouterr().out
