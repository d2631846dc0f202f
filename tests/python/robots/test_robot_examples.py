"""Robots of examples/ that touch soft and turning things: valve, towel, ball; coarse and short."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stark import scenes
from stark.recording import Recording

EXAMPLES = Path(__file__).parents[3] / "examples"


def run(example: str, folder: Path, until: float | None = None, **options: Any) -> tuple[Any, Recording]:
    """The module of an example and the recording of its run."""
    scene = scenes.load(EXAMPLES / f"{example}.py", options)
    result = scenes.run(scene, out=folder, until=until, replay=False, picture=False)
    assert result.status == "complete", result.message
    return scene.module, Recording(folder)


@pytest.mark.slow
def test_a_hand_turns_a_valve_by_one_stroke(tmp_path: Path) -> None:
    valve, recording = run("valve", tmp_path / "run", until=1.6, time_step=0.01)
    valve.check(recording)
    assert valve.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 6


@pytest.mark.slow
def test_a_hand_slips_on_a_valve_that_is_too_stiff(tmp_path: Path) -> None:
    # Three fingertips hold at most 3 mu N r = 0.8 N m.
    valve, recording = run("valve", tmp_path / "run", until=1.6, time_step=0.02, torque=2.0)
    angle = valve.running.measured(recording)["angle"]
    assert np.abs(angle).max() < 1e-3
    with pytest.raises(AssertionError, match="angle is"):
        valve.check(recording)


@pytest.mark.slow
def test_an_arm_folds_a_towel(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    towel, recording = run("fold_by_arm", tmp_path / "run", cells=16, time_step=0.02)
    assert towel.results(recording)["overlap"][0] > 0.97
    assert towel.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 4


@pytest.mark.slow
def test_a_panda_hands_a_ball_over(tmp_path: Path) -> None:
    pytest.importorskip("cmeel", reason="needs example-robot-data")
    pytest.importorskip("yourdfpy")
    panda, recording = run("panda_ball", tmp_path / "run", subdivisions=1, time_step=0.015)
    assert panda.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 7
