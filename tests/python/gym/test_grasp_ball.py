"""The ball that is grasped: lifted by friction alone, not without force."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from stark.gym import GraspBall
from stark.gym.grasp_ball import RADIUS, ball_mesh

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


def test_the_ball_is_a_ball() -> None:
    mesh = ball_mesh()
    corners = mesh.vertices[mesh.tets]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    assert volumes.min() > 0.0
    assert volumes.sum() == pytest.approx(4.0 / 3.0 * np.pi * RADIUS**3, rel=0.15)  # of an icosphere


def test_a_policy_by_hand_lifts_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))
    learning = importlib.import_module("learning")
    env = GraspBall()
    reached, count, _ = learning.episode(env, learning.grasp, 7, keep=False)
    assert reached and 20 < count < 90
    forces = [env.sim.contacts.of("ball", name).forces.sum(axis=0) for name in ("left", "right")]
    weight = 9.81 * env.sim["ball"].mass
    assert sum(forces)[2] == pytest.approx(weight, rel=0.5)  # lifted, and hardly accelerated


def test_an_open_gripper_lifts_nothing() -> None:
    env = GraspBall()
    env.reset(seed=7)
    for action in [(0, 0, -1, -1)] * 8 + [(0, 0, 1, -1)] * 8:
        _, _, terminated, _, info = env.step(np.array(action, dtype=float))
    assert not terminated and abs(info["lifted"]) < 5e-3
