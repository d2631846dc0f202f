"""The code of docs/attachments.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stark

GUIDE = Path(__file__).resolve().parents[3] / "docs/attachments.md"


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 10
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block.replace("until=0.3", "until=0.05"), str(GUIDE), "exec"), names)
    assert len(capsys.readouterr().out.splitlines()) == 5
    assert names["pull"] == pytest.approx(0.5 * 9.81, rel=1e-3)  # lifted at constant speed
    ends = [names[side].positions[names["sides"]] for side in ("front", "back")]  # type: ignore[attr-defined, index]
    assert abs(ends[0] - ends[1]).max() < 1e-6
    assert names["worn"].caveats == [] and abs(names["seams"].forces).max() > 0.0  # type: ignore[attr-defined]
    assert names["seam"].held.all()  # type: ignore[attr-defined]
    assert 4 <= len(names["lifted"]) < 20 and names["lifted"].max() < 0.06  # type: ignore[arg-type, attr-defined]
    falling = names["run"]
    falling.run_until(0.7)  # type: ignore[attr-defined]
    assert names["box"].velocity[2] < -0.5  # type: ignore[attr-defined]
    assert not names["tape"].broken.any()  # type: ignore[attr-defined]
    sim = stark.Simulation(names["scene"], time_step=0.01, contact_distance=1e-4)  # type: ignore[arg-type]
    for _ in range(3):
        report = sim.step()
        assert not report.failed, report.message
