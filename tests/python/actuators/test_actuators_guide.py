"""The code of docs/actuators.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stark

GUIDE = Path(__file__).resolve().parents[3] / "docs/actuators.md"


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 7
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block.replace("until=0.5", "until=0.05"), str(GUIDE), "exec"), names)
    assert len(capsys.readouterr().out.splitlines()) == 5
    scene = names["scene"]
    assert isinstance(scene, stark.Scene)
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in range(50):
        report = sim.step()
        assert report.status == "accepted", report.message
    left, right, grip = names["left"], names["right"], names["grip"]
    assert left.displacement > 1e-3  # type: ignore[attr-defined]
    assert right.displacement == pytest.approx(-left.displacement, abs=2e-6)  # type: ignore[attr-defined]
    assert abs(grip.force) <= 5.0 * (1.0 + 1e-9)  # type: ignore[attr-defined]
    assert names["cone"].angle <= 0.4 + 1e-5  # type: ignore[attr-defined]
    assert names["rope"].joint.distance <= 0.5 + 1e-6  # type: ignore[attr-defined]


def test_the_guide_and_the_reference_name_every_built_in_actuator() -> None:
    reference = (GUIDE.parent / "reference.md").read_text()
    for name in stark._core.actuator_names():
        assert f"| `{name}` |" in reference, name
    for method in dir(stark.joints.Joint):
        if method.startswith("add_"):
            assert method in GUIDE.read_text(), method
