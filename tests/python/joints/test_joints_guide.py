"""The code of docs/joints.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stark

GUIDE = Path(__file__).resolve().parents[3] / "docs/joints.md"


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 2
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block.replace("until=0.5", "until=0.05"), str(GUIDE), "exec"), names)
    assert len(capsys.readouterr().out.splitlines()) == 5
    assert names["hinge"].angle > 0.0  # type: ignore[attr-defined]
    assert isinstance(names["joint"], stark.Joint)


def test_the_guide_names_every_built_in_joint() -> None:
    text = GUIDE.read_text()
    for name in stark._core.joint_names():
        assert f"add_{name}" in text or f'"{name}"' in text, name
