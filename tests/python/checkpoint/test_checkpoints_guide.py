"""The code of docs/checkpoints.md runs, with the checks it makes, and its memory is that of a scene file."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[3] / "docs/checkpoints.md"


def test_guide_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    first, scene_file, loop = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
    names: dict = {}
    exec(compile(first, str(GUIDE), "exec"), names)
    exec(compile(scene_file, str(GUIDE), "exec"), names)
    names["drive"](names["sim"])
    assert names["memory"]["integral"] == pytest.approx(0.5 * 9.81 * 0.01, rel=0.05)  # it rests
    exec(compile(loop, str(GUIDE), "exec"), names)  # of a loop that goes on
