"""Environments: the interface of Gymnasium, the same bits from the same seed, failed steps as truncation."""

from __future__ import annotations

import math
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("gymnasium")

import gymnasium
from gymnasium.spaces import Box
from gymnasium.utils.env_checker import check_env

import stark
from stark.gym import DragCloth, GraspBall, SceneEnv, Task, TaskError

MAKERS = [DragCloth, GraspBall]


@pytest.mark.parametrize("make", MAKERS)
def test_check_env_finds_nothing(make: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        name = f"stark/{make.__name__}-v0"
        check_env(gymnasium.make(name, render_mode="rgb_array", size=(64, 48)).unwrapped)


@pytest.mark.parametrize("make", MAKERS)
def test_the_same_seed_gives_the_same_bits(make: Any) -> None:
    """In one environment after another episode, and in another one."""

    def episode(env: SceneEnv) -> list[bytes]:
        observation, _ = env.reset(seed=5)
        found, random = [observation.tobytes()], np.random.default_rng(1)
        for _ in range(6):
            observation, reward, *_ = env.step(random.uniform(-1, 1, env.action_space.shape))
            found += [observation.tobytes(), np.float64(reward).tobytes()]
        return [*found, env.sim.state.hash.encode()]

    env = make()
    first = episode(env)
    env.reset(seed=6)
    env.step(np.ones(env.action_space.shape))
    assert episode(env) == first and episode(make()) == first


def test_seeds_and_environments_differ() -> None:
    env = DragCloth()
    starts = {env.reset(seed=seed)[0].tobytes() for seed in range(4)}
    assert len(starts) == 4
    assert env.reset(seed=None)[0].tobytes() not in starts  # goes on with the random numbers of the last seed


def test_names_are_registered() -> None:
    env = gymnasium.make("stark/DragCloth-v0")
    assert isinstance(env.unwrapped, DragCloth)
    assert pickle.loads(pickle.dumps(DragCloth)) is DragCloth


def test_pictures_are_drawn_only_when_asked_for() -> None:
    env = GraspBall(render_mode="rgb_array", size=(64, 48))
    env.reset(seed=1)
    picture = env.render()
    assert picture is not None and picture.shape == (48, 64, 3) and picture.std() > 5.0
    quiet = GraspBall()
    quiet.reset(seed=1)
    assert quiet.render() is None
    with pytest.raises(TaskError, match="render_mode = 'human'"):
        GraspBall(render_mode="human")


class Push(Task):
    """A cube on a rail; the action is the force on it [N]."""

    name = "push"
    action_space = Box(-1.0, 1.0, (1,), np.float64)
    observation_space = Box(-1.0, 1.0, (2,), np.float64)
    control_step, until = 0.02, 0.1

    def build(self) -> tuple[Any, dict[str, Any]]:
        scene = stark.Scene("push")
        cube = scene.add_box(0.1, mass=1.0, name="cube")
        rail = scene.add_slider(None, cube, anchor=(0, 0, 0), axis=(1, 0, 0), name="rail")
        rail.add_effort(0.0, name="force")
        scene.add_force(cube, (0.0, 0.0, 0.0), name="wind")
        return scene, {"time_step": 0.01}

    def start(self, sim: Any, random: np.random.Generator) -> None:
        sim.energies[0].force = (random.uniform(0.5, 1.0), 0.0, 0.0)

    def act(self, sim: Any, action: Any) -> None:
        sim.actuators[0].target = float(action[0])

    def observe(self, sim: Any) -> Any:
        joint = sim.joints[0]
        return [joint.displacement, joint.rates["displacement"]]

    def reward(self, sim: Any, action: Any) -> float:
        return -abs(float(sim.joints[0].displacement))


def test_forces_and_time_are_those_of_the_scene() -> None:
    """Newton's law with the force that was drawn and the action: x = n (n + 1) / 2 h^2 F / m of implicit
    Euler."""
    env = SceneEnv(Push())
    env.reset(seed=3)
    wind = float(np.asarray(env.sim.energies[0].force)[0])
    found = []
    for k in range(5):
        observation, reward, terminated, truncated, info = env.step(np.array([1.0]))
        assert not terminated and truncated == (k == 4)
        n = 2 * (k + 1)
        assert observation[0] == pytest.approx(0.5 * n * (n + 1) * 0.01**2 * (1.0 + wind), rel=1e-6)
        assert reward == -observation[0]
        found.append(info)
    assert found[-1] == {"reason": "time"}
    with pytest.raises(TaskError, match="must be after reset"):
        env.step(np.array([1.0]))


def test_live_values_start_anew() -> None:
    env = SceneEnv(Push())
    env.reset(seed=3)
    env.sim.energies[0].force = (9.0, 0.0, 0.0)
    env.reset(seed=3)
    assert np.asarray(env.sim.energies[0].force)[0] < 1.0


class Torn(Push):
    """From the third control step on a press goes through the cube on an anvil: the step fails."""

    def act(self, sim: Any, action: Any) -> None:
        super().act(sim, action)
        if sim.time > 0.045:
            sim["press"].position = (0.0, 0.0, 0.0)

    def build(self) -> tuple[Any, dict[str, Any]]:
        scene, settings = super().build()
        scene.add_box((0.3, 0.3, 0.1), name="anvil", motion="fixed", position=(0, 0, -0.11))
        scene.add_box((0.3, 0.3, 0.1), name="press", motion="scripted", position=(0, 0, 0.11))
        return scene, {**settings, "time.min_step": 0.006}


def test_a_failed_step_truncates_and_says_why() -> None:
    env = SceneEnv(Torn())
    for _ in range(2):  # and the next episode is not hurt
        env.reset(seed=1)
        for _ in range(5):
            observation, reward, terminated, truncated, info = env.step(np.zeros(1))
            if truncated:
                break
        assert truncated and not terminated and info["reason"] not in ("time", "")
        assert info["message"] and np.isfinite(observation).all() and math.isfinite(reward)
        assert env.sim.time < 0.1


def test_what_a_task_gets_wrong_is_named() -> None:
    class Bad(Push):
        observed: Any = (0.0, 0.0)
        rewarded: Any = 0.0

        def observe(self, sim: Any) -> Any:
            return self.observed

        def reward(self, sim: Any, action: Any) -> float:
            return self.rewarded

    task = Bad()
    env = SceneEnv(task)
    env.reset(seed=0)
    for action in ([np.nan], [1.0, 2.0], ["x"], "x", None, [[1.0], [1.0, 2.0]]):
        with pytest.raises(TaskError, match=r"must be \(1,\) finite numbers"):
            env.step(action)  # type: ignore[arg-type]
    task.rewarded = np.nan
    with pytest.raises(TaskError, match=r"reward\(\) = nan: must be a finite number"):
        env.step(np.zeros(1))
    task.observed = (0.0, np.nan)
    with pytest.raises(TaskError, match="1 numbers not finite"):
        env.reset()
    task.observed = (0.0,)
    with pytest.raises(TaskError, match="must be \\(2,\\)"):
        env.reset()


FILE = '''
"""A ball that is thrown up."""

import numpy as np
import stark
from gymnasium.spaces import Box

until, control_step = 0.2, 0.1
options = {"mass": 1.0}


def spaces():
    return Box(-1, 1, (1,), np.float32), Box(-10, 10, (1,), np.float32)


def settings():
    return {"time_step": 0.05}


def build():
    scene = stark.Scene()
    scene.add_sphere(0.1, subdivisions=1, mass=options["mass"], name="ball")
    return scene


def start(sim, random):
    sim["ball"].velocity = (0.0, 0.0, random.uniform(1.0, 2.0))


def act(sim, action):
    pass


def observe(sim):
    return sim["ball"].position[2:]


def reward(sim, action):
    return sim["ball"].position[2]


def done(sim):
    return sim["ball"].position[2] > 100.0
'''


@pytest.mark.parametrize("built", [stark.Scene(), None, (stark.Scene(),), (stark.Scene(), 0.01), ({}, {})])
def test_a_task_builds_a_scene_and_its_settings(built: Any) -> None:
    class Wrong(Push):
        def build(self) -> Any:
            return built

    with pytest.raises(TaskError, match=r"build\(\) gives .*: must be a scene and its settings"):
        SceneEnv(Wrong())


def test_scene_files_are_environments(tmp_path: Path) -> None:
    (tmp_path / "throw.py").write_text(FILE)
    env = SceneEnv(tmp_path / "throw.py", options={"mass": 2.0})
    assert env.sim["ball"].mass == 2.0
    env.reset(seed=1)
    observation, _, _, truncated, _ = env.step(np.zeros(1))
    assert 0.0 < observation[0] < 0.2 and not truncated
    assert env.step(np.zeros(1))[3]


def test_documents_and_other_files_take_a_task(tmp_path: Path) -> None:
    scene, settings = Push().build()
    path = scene.save(tmp_path / "push.json", settings=settings)
    env = SceneEnv(path, task=Push())
    assert env.reset(seed=3)[0].tobytes() == SceneEnv(Push()).reset(seed=3)[0].tobytes()
    with pytest.raises(TaskError, match="has no function spaces"):
        SceneEnv(path)
    for wrong in (7, None):
        with pytest.raises(TaskError, match="must be a scene file"):
            SceneEnv(wrong)  # type: ignore[arg-type]
    with pytest.raises(TaskError, match="neither task= nor options="):
        SceneEnv(Push(), task=Push())
    with pytest.raises(TaskError, match=r"must be a stark\.gym\.Task"):
        SceneEnv(path, task=7)  # type: ignore[arg-type]


class Placed(Push):
    """The cube starts where the options of the reset say."""

    def start(self, sim: Any, random: np.random.Generator) -> None:
        sim.joints[0].coordinates = {"displacement": self.options.get("start", 0.0)}


def test_options_of_a_reset_are_those_of_the_task(tmp_path: Path) -> None:
    scene, settings = Push().build()
    path = scene.save(tmp_path / "push.json", settings=settings)
    for env in (SceneEnv(Placed()), SceneEnv(path, task=Placed())):
        assert env.reset(seed=1, options={"start": 0.25})[0][0] == pytest.approx(0.25)
        assert env.reset(seed=1)[0][0] == 0.0
    (tmp_path / "throw.py").write_text(FILE)
    env = SceneEnv(tmp_path / "throw.py")
    env.reset(seed=1, options={})
    with pytest.raises(TaskError, match=r"options = \{'start': 0\.25\}: must be none"):
        env.reset(options={"start": 0.25})


def test_options_of_a_reset_are_a_dictionary() -> None:
    env = stark.gym.DragCloth()
    with pytest.raises(stark.gym.TaskError, match="reset: options = 5: must be a dictionary"):
        env.reset(seed=1, options=5)  # type: ignore[arg-type]
