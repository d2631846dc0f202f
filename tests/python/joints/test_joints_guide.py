"""The code of docs/joints.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stark

GUIDE = Path(__file__).resolve().parents[3] / "docs/joints.md"


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 3
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block.replace("until=0.5", "until=0.05"), str(GUIDE), "exec"), names)
    assert len(capsys.readouterr().out.splitlines()) == 5
    assert names["hinge"].angle > 0.0  # type: ignore[attr-defined]
    screw, bolt = names["joint"], names["bolt"]
    assert isinstance(screw, stark.Joint) and isinstance(bolt, stark.RigidBody)
    sim = stark.Simulation(names["scene"], time_step=0.02, gravity=(0, 0, 0))  # type: ignore[arg-type]
    sim.run_until(1.0)
    # The spin that it starts with, shared with the translation: I w / (I + m ratio^2), over a full turn.
    inertia = 1.0 * 0.1**2 / 6.0
    assert screw.angle == pytest.approx(6.0 * inertia / (inertia + 0.02**2), rel=2e-3)
    assert bolt.position[2] == pytest.approx(0.02 * screw.angle, abs=2e-6)


def test_the_guide_names_every_built_in_joint() -> None:
    text = GUIDE.read_text()
    for name in stark._core.joint_names():
        assert f"add_{name}" in text or f'"{name}"' in text, name
