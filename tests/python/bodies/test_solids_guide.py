"""The finger of docs/solids.md lifts its load."""

from __future__ import annotations

from pathlib import Path

import pytest

from stark import scenes
from stark.recording import Recording

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.slow
def test_the_muscle_lifts_the_load(tmp_path: Path) -> None:
    path = ROOT / "examples/muscle.py"
    assert len(path.read_text().splitlines()) < 80
    result = scenes.run(scenes.load(path), out=tmp_path / "run", replay=False, picture=False)
    assert (result.status, result.rejected_steps) == ("complete", 0), result.message
    telemetry = Recording(tmp_path / "run").telemetry
    assert telemetry["measured.load"][-1] == pytest.approx(-0.021, abs=0.004)
    assert telemetry["measured.volume"].min() > 0.995
