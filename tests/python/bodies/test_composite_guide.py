"""The code of docs/composite.md runs as it stands, and the example keeps its promises."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from stark import scenes
from stark.recording import Recording

ROOT = Path(__file__).resolve().parents[3]
GUIDE = ROOT / "docs/composite.md"


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 3
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block.replace("until=0.2", "until=0.05"), str(GUIDE), "exec"), names)
    assert len(capsys.readouterr().out.splitlines()) == 1 + 5 + 10


@pytest.mark.slow
def test_the_pneumatic_finger_curls(tmp_path: Path) -> None:
    path = ROOT / "examples/pneumatic_finger.py"
    assert len(path.read_text().splitlines()) < 80
    result = scenes.run(scenes.load(path), out=tmp_path / "run", replay=False, picture=False)
    assert (result.status, result.rejected_steps) == ("complete", 0), result.message
    recording = Recording(tmp_path / "run")
    assert [(b.name, b.kind) for b in recording.bodies] == [
        ("finger", "solid"), ("fabric", "skin"), ("rings", "fibres")
    ]  # fmt: skip
    said = re.search(r"curls it by (\d+) degrees", GUIDE.read_text())
    assert said is not None
    turn = np.rad2deg(recording.telemetry["measured.turn"][-1])
    assert turn == pytest.approx(float(said[1]), abs=0.6)
