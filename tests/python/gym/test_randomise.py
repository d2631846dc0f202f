"""Scenes that are another one in each episode."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.spaces import Box

import stark
from stark.gym import SceneEnv, Task, TaskError

STEP, SPEED = 0.01, 1.0  # [s], [m/s]


class Slide(Task):
    """A box slides to rest on a floor of unknown friction."""

    name = "slide"
    action_space = Box(-1.0, 1.0, (1,), np.float32)
    observation_space = Box(-5.0, 5.0, (1,), np.float64)
    control_step, until = 0.05, 1.0

    def randomise(self, random: np.random.Generator) -> None:
        self.friction, self.mass = random.uniform(0.2, 0.8), random.uniform(0.5, 2.0)

    def build(self) -> tuple[Any, dict[str, Any]]:
        scene = stark.Scene("slide")
        scene.add_floor(4.0)
        scene.add_box(0.1, mass=self.mass, position=(0, 0, 0.052), velocity=(SPEED, 0, 0), name="box")
        scene.friction["box", "floor"] = self.friction
        return scene, {"time_step": STEP}

    def act(self, sim: Any, action: Any) -> None:
        pass

    def observe(self, sim: Any) -> Any:
        return sim["box"].position[:1]

    def reward(self, sim: Any, action: Any) -> float:
        return 0.0


def episode(env: SceneEnv, seed: int) -> list[float]:
    observation, _ = env.reset(seed=seed)
    found, ended = [float(observation[0])], False
    while not ended:
        observation, _, _, ended, info = env.step(np.zeros(1))
        found.append(float(observation[0]))
    assert info["reason"] == "time"
    return found


def test_each_episode_has_its_own_friction_and_mass() -> None:
    env = SceneEnv(Slide())
    drawn = []
    for seed in range(4):
        way = episode(env, seed)
        drawn.append((env.task.friction, env.sim["box"].mass))
        # Coulomb's law, with velocities of the ends of steps: half a step short.
        expected = 0.5 * SPEED**2 / (9.81 * env.task.friction) - 0.5 * SPEED * STEP
        assert way[-1] == pytest.approx(expected, rel=0.02)
        assert env.sim["box"].mass == pytest.approx(env.task.mass)
    assert len(set(drawn)) == 4


def test_the_same_seed_gives_the_same_bits() -> None:
    first, second = SceneEnv(Slide()), SceneEnv(Slide())
    before = episode(first, 5)
    episode(second, 1)
    assert episode(second, 5) == before
    episode(first, 2)
    assert episode(first, 5) == before


FILE = """
import numpy as np
import stark
from gymnasium.spaces import Box

options = {"mass": 1.0}
until = 0.1


def build():
    scene = stark.Scene("falling")
    scene.add_box(0.1, mass=options["mass"], name="box")
    return scene


def randomise(random):
    options["mass"] = random.uniform(1.0, 2.0)


def spaces():
    return Box(-1.0, 1.0, (1,)), Box(-5.0, 5.0, (1,))


def act(sim, action):
    pass


def observe(sim):
    return [sim["box"].mass]


def reward(sim, action):
    return 0.0
"""


def test_scene_files_may_randomise(tmp_path: Path) -> None:
    path = tmp_path / "falling.py"
    path.write_text(FILE)
    env = SceneEnv(path)
    masses = [float(env.reset(seed=seed)[0][0]) for seed in (1, 2, 1)]
    assert masses[0] == masses[2] != masses[1]
    assert all(1.0 < mass < 2.0 for mass in masses)


def test_what_is_drawn_must_be_built(tmp_path: Path) -> None:
    path = tmp_path / "falling.py"
    path.write_text(FILE)
    with pytest.raises(TaskError, match=r"task 'slide': has randomise\(\), but the scene is that of"):
        SceneEnv(path, task=Slide())
