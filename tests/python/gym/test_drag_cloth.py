"""The cloth that is dragged: the policy of the example reaches the goal, the corner stays in its space."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from stark.gym import DragCloth
from stark.gym.drag_cloth import HIGH, LOW, REACH, SPEED

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


def test_a_policy_by_hand_reaches_the_goal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))
    learning = importlib.import_module("learning")
    reached, count, _ = learning.episode(DragCloth(), learning.drag, 10, keep=False)
    assert reached and 20 < count < 80


def test_doing_nothing_does_not() -> None:
    env = DragCloth()
    observation, info = env.reset(seed=10)
    assert 0.15 <= info["distance"] <= 0.3 + 1e-9
    still, reward, terminated, *_ = env.step(np.zeros(3))
    assert not terminated and reward == pytest.approx(-info["distance"], abs=1e-3)
    assert np.abs(still - observation).max() < 2e-3


def test_the_corner_moves_at_the_speed_of_the_action_and_stays_in_its_space() -> None:
    env = DragCloth()
    start, _ = env.reset(seed=10)
    moved = env.step(np.array([1.0, 0.0, 1.0]))[0]
    assert moved[:3] - start[:3] == pytest.approx(
        [SPEED * 0.05, 0.0, SPEED * 0.05 + max(0.0, LOW - start[2])], abs=2e-3
    )
    for _ in range(12):
        moved = env.step(np.array([0.0, 0.0, 1.0]))[0]
    assert moved[2] == pytest.approx(HIGH)
    assert np.abs(moved[:2]).max() <= REACH
