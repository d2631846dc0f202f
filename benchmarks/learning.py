"""Steps per second of the environments for learning, on one core: `python benchmarks/learning.py`.

Random actions, new episodes where one ends; time of the process, the best of three rounds, because other
programs on the machine only take away."""

from __future__ import annotations

import time

import numpy as np

from stark.gym import DragCloth, GraspBall, SceneEnv

SECONDS, ROUNDS, RESETS = 8.0, 3, 100


def rates(env: SceneEnv, seed: int) -> tuple[float, float]:
    """Actions and steps of the simulation per second."""
    random = np.random.default_rng(seed)
    env.reset(seed=seed)
    actions = steps = 0
    begin = time.process_time()
    while (seconds := time.process_time() - begin) < SECONDS:
        before = env.sim.time
        _, _, terminated, truncated, info = env.step(random.uniform(-1.0, 1.0, env.action_space.shape))
        assert info.get("reason", "time") == "time", info
        actions, steps = actions + 1, steps + round((env.sim.time - before) / env.sim.time_step)
        if terminated or truncated:
            env.reset()
    return actions / seconds, steps / seconds


def reset_seconds(env: SceneEnv) -> float:
    begin = time.process_time()
    for seed in range(RESETS):
        env.reset(seed=seed)
    return (time.process_time() - begin) / RESETS


def main() -> None:
    for make in (DragCloth, GraspBall):
        env = make()
        found = [rates(env, seed) for seed in range(ROUNDS)]
        actions, steps = max(found)
        print(
            f"{make.__name__}: {actions:.0f} actions a second, {steps:.0f} steps of the simulation a second, "
            f"{1e3 * reset_seconds(env):.2f} ms a reset"
        )


if __name__ == "__main__":
    main()
