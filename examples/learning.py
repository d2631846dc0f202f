"""Two environments for learning, with policies written by hand: a cloth to a target, a ball in a gripper.

    python examples/learning.py [--pictures]

Any learner for Gymnasium takes the place of the policies. --pictures draws episodes for docs/learning.md."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import Env

import stark
from stark import gym

Floats = np.ndarray
FOLDER = Path(__file__).resolve().parents[1] / "docs" / "images"


def drag(observation: Floats) -> Floats:
    """Pulls the corner to where the middle of the cloth has to go."""
    way = observation[-2:]
    return np.array([*np.clip(8.0 * way, -1.0, 1.0), 0.0])


def grasp(observation: Floats) -> Floats:
    """Above the ball, down, close, up."""
    hand, ball, forces = observation[:3], observation[3:6], observation[-2:]
    beside = np.linalg.norm((ball - hand)[:2])
    sideways = np.clip(10.0 * (ball - hand)[:2], -1.0, 1.0)
    low = hand[2] < 0.09
    if forces.min() > 1.0:  # [N]
        return np.array([0.0, 0.0, 0.5, 1.0])
    if low or observation[12:14].max() > 0.015:
        return np.array([*(0.2 * sideways), 0.0, 1.0])
    return np.array([*sideways, -1.0 if beside < 0.005 else 0.0, -1.0])


def episode(
    env: Env[Floats, Floats], policy: Callable[[Floats], Floats], seed: int
) -> tuple[bool, int, list[Floats]]:
    """Whether the goal was reached, control steps, pictures if the environment draws."""
    observation, _ = env.reset(seed=seed)
    frames: list[Floats] = []
    count, ended, terminated, info = 0, False, False, dict[str, Any]()
    while not ended:
        observation, _, terminated, truncated, info = env.step(policy(observation))
        count, ended = count + 1, terminated or truncated
        if env.render_mode is not None:
            frames.append(np.asarray(env.render()))
    print(f"  seed {seed}: {'goal' if terminated else info['reason']} after {count} actions")
    return terminated, count, frames


def draw(frames: list[Floats], name: str) -> None:
    """Four moments of an episode side by side."""
    chosen = [frames[round(k * (len(frames) - 1) / 3)] for k in range(4)]
    stark.render.write_png(FOLDER / f"{name}.png", np.concatenate(chosen, axis=1))


def main() -> None:
    pictures = "--pictures" in sys.argv
    for make, policy, name, first in (
        (gym.DragCloth, drag, "learning_cloth", 10),
        (gym.GraspBall, grasp, "learning_ball", 7),
    ):
        print(make.__name__)
        env = make(render_mode="rgb_array" if pictures else None, size=(400, 300))
        begin, steps = time.process_time(), 0
        frames: list[Floats] = []
        for seed in range(first, first + (1 if pictures else 5)):
            reached, count, frames = episode(env, policy, seed)
            steps += count
            assert reached, "the policy has to reach the goal"
        if pictures:
            draw(frames, name)
        else:
            print(f"  {steps / (time.process_time() - begin):.0f} actions a second of one core")
        env.close()


if __name__ == "__main__":
    main()
