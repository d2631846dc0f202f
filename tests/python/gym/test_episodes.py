"""Nothing of an episode reaches the next one, and what a task does wrong is named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from gymnasium.spaces import Box

import stark
from stark.gym import SceneEnv, Task, TaskError


class Many(Task):
    """A box on a motor, a box that is pushed, a scripted one, a pinned cloth, a belt; ``change(sim)`` at the
    start of an episode."""

    name = "many"
    action_space = Box(-1, 1, (1,), np.float32)
    observation_space = Box(-1e3, 1e3, (5,), np.float64)
    control_step, until = 0.02, 0.2
    change: Any = None

    def build(self) -> tuple[Any, dict[str, Any]]:
        scene = stark.Scene("many")
        scene.default_friction = 0.5
        turned = scene.add_box(0.05, mass=0.1, position=(0, 0.5, 0), name="turned")
        hinge = scene.add_hinge(None, turned, anchor=(0.1, 0.5, 0), axis=(0, 1, 0), name="hinge")
        hinge.add_motor(0.0, cap=0.05, delta=0.1, name="motor")
        pushed = scene.add_box(0.05, mass=0.1, position=(2, 0, 0), name="pushed")
        scene.add_force(pushed, (0, 0, 0), name="push")
        scene.add_box(0.05, motion="scripted", position=(0, 1, 0), name="scripted")
        sheet = stark.mesh.grid(0.1, 0.1, cells=2)
        scene.add_cloth(sheet, pins=[0, 2], position=(1, 0, 0), name="cloth")
        belt = scene.add_box((1, 1, 0.1), motion="fixed", position=(4, 0, 0), name="belt")
        belt.surface_velocity = (0.0, 0.0, 0.0)
        scene.add_box(0.05, mass=0.1, position=(4, 0, 0.0755), name="carried")
        return scene, {"time_step": 0.01}

    def start(self, sim: Any, random: Any) -> None:
        if self.change is not None:
            self.change(sim)

    def act(self, sim: Any, action: Any) -> None:
        pass

    def observe(self, sim: Any) -> Any:
        return [
            sim.joints["hinge"].angle,
            sim["pushed"].position[0],
            sim["scripted"].position[0],
            sim["cloth"].positions[:, 0].sum(),
            sim["carried"].position[0],
        ]

    def reward(self, sim: Any, action: Any) -> float:
        return 0.0


def change_motor(sim: Any) -> None:
    sim.actuators["motor"].target = lambda t: 10.0 * t


def change_force(sim: Any) -> None:
    sim.energies["push"].force = lambda t: (1.0, 0.0, 0.0)


def change_path(sim: Any) -> None:
    sim.scene["scripted"].follow(position=lambda t: (t, 1.0, 0.0))


def change_pins(sim: Any) -> None:
    sim.scene["cloth"].follow(displacement=lambda t: (t, 0.0, 0.0))


def change_belt(sim: Any) -> None:
    sim["belt"].surface_velocity = lambda t: (10.0 * t, 0.0, 0.0)


def change_belt_now(sim: Any) -> None:
    sim["belt"].surface_velocity = (1.0, 0.0, 0.0)


def episode(env: SceneEnv) -> bytes:
    found = [env.reset(seed=1)[0]]
    found += [env.step(np.zeros(1))[0] for _ in range(4)]
    return np.array(found).tobytes()


@pytest.mark.parametrize(
    "change", [change_motor, change_force, change_path, change_pins, change_belt, change_belt_now]
)
def test_what_an_episode_assigns_ends_with_it(change: Any) -> None:
    task = Many()
    env = SceneEnv(task)
    first = episode(env)
    task.change = change
    changed = episode(env)
    assert changed != first and episode(env) == changed
    task.change = None
    assert episode(env) == first


def test_functions_of_the_built_scene_come_back() -> None:
    class Driven(Many):
        def build(self) -> tuple[Any, dict[str, Any]]:
            scene, settings = super().build()
            scene["scripted"].follow(position=lambda t: (0.5 * t, 1.0, 0.0))
            scene.actuators["motor"].target = lambda t: 5.0 * t
            return scene, settings

    def stop(sim: Any) -> None:
        sim.scene["scripted"].follow()
        sim.actuators["motor"].target = 0.0

    task = Driven()
    env = SceneEnv(task)
    first = episode(env)
    task.change = stop
    assert episode(env) != first
    task.change = None
    assert episode(env) == first


FILE = """
import numpy as np
import stark
from gymnasium.spaces import Box

until, control_step = 0.2, 0.02
memory = {"calls": 0}


def spaces():
    return Box(-1, 1, (1,), np.float32), Box(-10, 10, (1,), np.float64)


def build():
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="box")
    scene.add_force(box, (0, 0, 0), name="push")
    memory["built"] = 1
    return scene, {"time_step": 0.01, "gravity": (0, 0, 0)}


def drive(sim):
    memory["calls"] += memory["built"]
    sim.energies["push"].force = (float(memory["calls"]), 0, 0)


def act(sim, action):
    pass


def observe(sim):
    return sim["box"].position[:1]


def reward(sim, action):
    return REWARD
"""


def test_the_memory_of_a_scene_file_starts_anew(tmp_path: Path) -> None:
    (tmp_path / "push.py").write_text(FILE.replace("REWARD", "0.0"))
    env = SceneEnv(tmp_path / "push.py")
    assert episode(env) == episode(env) == episode(SceneEnv(tmp_path / "push.py"))


class Wrong(Many):
    """Gives what it is told to."""

    given: Any

    def __init__(self, **given: Any) -> None:
        self.given = given

    def observe(self, sim: Any) -> Any:
        return self.given.get("observe", np.zeros(5))

    def reward(self, sim: Any, action: Any) -> Any:
        return self.given.get("reward", 0.0)

    def done(self, sim: Any) -> Any:
        return self.given.get("done", False)

    def info(self, sim: Any) -> Any:
        return self.given.get("info", {})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"observe": "abc"}, r"observe\(\) = 'abc': must be \(5,\) finite numbers"),
        ({"observe": None}, r"observe\(\) gives None"),
        ({"observe": {"a": 1}}, r"observe\(\) = {'a': 1}: must be"),
        ({"reward": None}, r"reward\(\) = None: must be a finite number"),
        ({"reward": np.array([1.0])}, r"reward\(\) = array\(\[1\.\]\): must be"),
        ({"reward": "1"}, r"reward\(\) = '1': must be"),
        ({"reward": float("inf")}, r"reward\(\) = inf: must be"),
        ({"done": np.array([True, False])}, r"done\(\) = array\(\[ True, False\]\): must be True or False"),
        ({"done": None}, r"done\(\) = None: must be"),
        ({"info": None}, r"info\(\) = None: must be a dictionary"),
    ],
)
def test_what_functions_give_is_checked(given: dict[str, Any], message: str) -> None:
    def run() -> None:
        env = SceneEnv(Wrong(**given))
        env.reset(seed=0)
        env.step(np.zeros(1))

    with pytest.raises(TaskError, match=f"task 'many': {message}"):
        run()


@pytest.mark.parametrize("reward", [1, True, np.float32(1.0), np.array(1.0)])
def test_numbers_of_all_kinds_are_rewards(reward: Any) -> None:
    env = SceneEnv(Wrong(reward=reward, done=np.bool_(False)))
    env.reset(seed=0)
    assert env.step(np.zeros(1))[1] == 1.0


def test_a_scene_file_that_gives_no_reward_is_named(tmp_path: Path) -> None:
    (tmp_path / "push.py").write_text(FILE.replace("REWARD", "None"))
    env = SceneEnv(tmp_path / "push.py")
    env.reset(seed=0)
    with pytest.raises(TaskError, match=r"task 'push': reward\(\) = None"):
        env.step(np.zeros(1))


@pytest.mark.parametrize("function", ["act", "observe", "reward", "done", "info"])
@pytest.mark.parametrize("what", ["step()", "reset()"])
def test_only_the_environment_takes_steps(function: str, what: str) -> None:
    task = Many()
    env = SceneEnv(task)
    env.reset(seed=0)
    setattr(task, function, lambda sim, *_: getattr(sim, what[:-2])())
    with pytest.raises(stark.InvalidArgument, match=rf"task 'many': {function}\(\) uses sim.{what[:-2]}"):
        env.step(np.zeros(1))


def test_a_start_that_takes_steps_shortens_no_control_step() -> None:
    task = Many()
    task.change = lambda sim: sim.run_until(0.015)
    env = SceneEnv(task)
    env.reset(seed=0)
    env.step(np.zeros(1))
    assert env.sim.time == pytest.approx(0.035)


class Arm(Task):
    """A robot whose servos carry its weight, or not."""

    name = "arm"
    action_space = Box(-1, 1, (1,), np.float32)
    observation_space = Box(-1e3, 1e3, (6,), np.float64)
    control_step, until = 0.02, 0.2
    compensated = False

    def build(self) -> tuple[Any, dict[str, Any]]:
        scene = stark.Scene("arm")
        robot = scene.add_robot(Path(__file__).parents[3] / "examples/robot_arm.urdf")
        robot.add_servos(stiffness=100.0, damping=10.0)
        return scene, {"time_step": 0.02}

    def start(self, sim: Any, random: Any) -> None:
        sim.robots[0].drives[0].gravity_compensation = self.compensated

    def act(self, sim: Any, action: Any) -> None:
        pass

    def observe(self, sim: Any) -> Any:
        return sim.robots[0].q[:6]

    def reward(self, sim: Any, action: Any) -> float:
        return 0.0


def test_gravity_compensation_ends_with_its_episode() -> None:
    task = Arm()
    env = SceneEnv(task)
    first = episode(env)
    task.compensated = True
    assert episode(env) != first
    env.reset(seed=1)
    assert env.sim.robots[0].drives[0].gravity_compensation
    task.compensated = False
    assert episode(env) == first


class Broken(Many):
    """Its ``start`` raises where it is told to, its ``act`` on actions above 0.5."""

    def start(self, sim: Any, random: Any) -> None:
        if self.options.get("broken"):
            raise ValueError("start")

    def act(self, sim: Any, action: Any) -> None:
        if action[0] > 0.5:
            raise ValueError("act")


def test_a_reset_that_raises_leaves_no_episode() -> None:
    """Steps went on with the clock of the episode before."""
    env = SceneEnv(Broken())
    env.reset(seed=1)
    env.step(np.zeros(1))
    with pytest.raises(ValueError, match="start"):
        env.reset(seed=2, options={"broken": True})
    with pytest.raises(TaskError, match="must be after reset"):
        env.step(np.zeros(1))


def test_a_step_whose_act_raises_does_not_count() -> None:
    """The next one took twice the time."""
    env = SceneEnv(Broken())
    env.reset(seed=1)
    with pytest.raises(ValueError, match="act"):
        env.step(np.ones(1))
    env.step(np.zeros(1))
    assert env.sim.time == pytest.approx(0.02, rel=1e-12)
