"""examples/rover.py, with fewer stones and a shorter way: wheels carry the weight and roll."""

from __future__ import annotations

from pathlib import Path

import pytest

from stark import scenes
from stark.recording import Recording

pytest.importorskip("mujoco")
EXAMPLE = Path(__file__).parents[3] / "examples/rover.py"


@pytest.mark.slow
def test_the_rover_drives_over_stones(tmp_path: Path) -> None:
    scene = scenes.load(EXAMPLE, {"rocks": "12"})
    result = scenes.run(scene, out=tmp_path / "run", until=1.2, replay=False, picture=False)
    assert (result.status, result.rejected_steps) == ("complete", 0), result.message
    recording = Recording(tmp_path / "run")
    for value, reference, tolerance in scene.module.results(recording).values():
        assert abs(value - reference) <= tolerance
    assert scene.module.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 6
