"""examples/robot_arm.py: the arm carries the cube, its efforts are those of statics."""

from __future__ import annotations

from pathlib import Path

import pytest

from stark import scenes
from stark.recording import Recording

pytest.importorskip("yourdfpy")
EXAMPLE = Path(__file__).parents[3] / "examples/robot_arm.py"


@pytest.mark.slow
def test_the_arm_carries_the_cube(tmp_path: Path) -> None:
    scene = scenes.load(EXAMPLE)
    result = scenes.run(scene, out=tmp_path / "run", replay=False, picture=False)
    assert (result.status, result.rejected_steps) == ("complete", 0), result.message
    recording = Recording(tmp_path / "run")
    for value, reference, tolerance in scene.module.results(recording).values():
        assert abs(value - reference) <= tolerance
    assert scene.module.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 7
