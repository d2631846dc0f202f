"""Two environments for learning, with policies written by hand: a cloth to a target, a ball in a gripper.

    python examples/learning.py [--pictures]

Any learner for Gymnasium takes the place of the policies. --pictures draws four moments of an episode of
each into out/, the pictures of docs/learning.md."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from gymnasium import Env
from pictures import OUT, WIDTH, fitted_camera, snapshot

from stark import gym, render

Floats = np.ndarray
Moment = list[SimpleNamespace]
HEIGHT = 360  # of pictures [px]


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
    env: Env[Floats, Floats], policy: Callable[[Floats], Floats], seed: int, keep: bool
) -> tuple[bool, int, list[Moment]]:
    """Whether the goal was reached, control steps, the bodies after each of them if they are to be kept."""
    observation, _ = env.reset(seed=seed)
    moments: list[Moment] = []
    count, ended, terminated, info = 0, False, False, dict[str, Any]()
    while not ended:
        observation, _, terminated, truncated, info = env.step(policy(observation))
        count, ended = count + 1, terminated or truncated
        if keep:
            moments.append(moment(env))
    print(f"  seed {seed}: {'goal' if terminated else info['reason']} after {count} actions")
    return terminated, count, moments


def moment(env: Env[Floats, Floats]) -> Moment:
    """The bodies as they are now, without the table."""
    assert isinstance(env, gym.SceneEnv)
    return [snapshot(body) for body in env.sim.bodies if body.name != "table"]


def draw(moments: list[Moment], name: str, apart: float, azimuth: float, elevation: float) -> None:
    """Four moments of an episode side by side, ``apart`` [m] from each other. Targets shine through cloth."""
    angle = np.radians(azimuth)
    right = apart * np.array([-np.sin(angle), np.cos(angle), 0.0])
    bodies = []
    for k in range(4):
        for body in moments[round(k * (len(moments) - 1) / 3)]:
            body.positions = body.positions + k * right
            bodies.append(body)
    seen = {"cloth": 0.75} if any(body.name == "cloth" for body in bodies) else None
    points = np.concatenate([body.positions for body in bodies])
    camera = fitted_camera(points, angle, np.radians(elevation), WIDTH / HEIGHT)
    picture = render.render(SimpleNamespace(bodies=bodies), WIDTH, HEIGHT, camera=camera, opacity=seen)
    OUT.mkdir(exist_ok=True)
    render.write_png(OUT / f"{name}.png", picture)
    print(f"  {OUT / name}.png")


def main() -> None:
    pictures = "--pictures" in sys.argv
    for make, policy, first, name, apart, azimuth, elevation in (
        (gym.DragCloth, drag, 10, "learning_cloth", 0.42, -90.0, 50.0),
        (gym.GraspBall, grasp, 7, "learning_ball", 0.25, -70.0, 15.0),
    ):
        print(make.__name__)
        env = make()
        begin, steps = time.process_time(), 0
        moments: list[Moment] = []
        for seed in range(first, first + (1 if pictures else 5)):
            reached, count, moments = episode(env, policy, seed, pictures)
            steps += count
            assert reached, "the policy has to reach the goal"
        if pictures:
            draw(moments, name, apart, azimuth, elevation)
        else:
            print(f"  {steps / (time.process_time() - begin):.0f} actions a second of one core")
        env.close()


if __name__ == "__main__":
    main()
