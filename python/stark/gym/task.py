"""What an environment does with a scene: spaces, actions, observations, rewards."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from numbers import Real
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.scenes.scene_file import SceneFile, load

Floats = NDArray[np.float64]


class TaskError(InvalidArgument):
    """A task that cannot be used, or that gives what no environment can: names the task, the function, the
    value and the rule."""


class Task:
    """What is to be learnt in a scene; derive from it. ``sim`` is the ``stark.Simulation``.

    All functions must depend on ``sim``, their arguments and what ``start`` drew alone: then the same seed
    gives the same episode, bit for bit."""

    name: str = "task"
    action_space: Box
    """Of ``act``; numbers in [-1, 1] are what learners expect."""
    observation_space: Box
    """Of ``observe``; observations beyond it are cut to it."""
    control_step: float = 0.05
    """From one action to the next [s]; simulated in steps of ``time_step``."""
    until: float = 5.0
    """Longest episode [s]."""
    settle: float = 0.0
    """Simulated once, before the first episode [s]: every episode starts from there."""
    options: Mapping[str, Any] = MappingProxyType({})
    """What ``reset(options=...)`` was given, for ``randomise`` and ``start``; empty without."""

    def randomise(self, random: np.random.Generator) -> None:
        """Draws what ``build`` then makes the scene of: friction, masses, materials, shapes. A task that has
        this function is built anew, and settles anew, for each episode; others are built once, which is much
        faster."""

    def build(self) -> tuple[Any, dict[str, Any]]:
        """The scene and settings of the simulation; called once, or after each ``randomise``."""
        raise NotImplementedError

    @property
    def is_randomised(self) -> bool:
        """Whether the scene is another one in each episode."""
        return type(self).randomise is not Task.randomise

    def start(self, sim: Any, random: np.random.Generator) -> None:
        """Makes the start of an episode another one: places bodies, draws targets. ``sim`` is at the
        start."""

    def act(self, sim: Any, action: Floats) -> None:
        """Sets targets for the end of the coming step, as ``drive(sim)`` of a scene file; called before each
        step that the simulation takes."""
        raise NotImplementedError

    def observe(self, sim: Any) -> Any:
        """Numbers of the shape of the space."""
        raise NotImplementedError

    def reward(self, sim: Any, action: Floats) -> float:
        """Of the control step that has ended."""
        raise NotImplementedError

    def done(self, sim: Any) -> bool:
        """Whether the episode has come to its goal, or to where it has none any more."""
        return False

    def info(self, sim: Any) -> dict[str, Any]:
        """What else one may want to know."""
        return {}

    def _take_options(self, options: dict[str, Any]) -> None:
        """Those of ``reset``."""
        self.options = options


class FileTask(Task):
    """The task of a scene file: its functions ``spaces()``, ``start(sim, random)``, ``act(sim, action)``,
    ``observe(sim)``, ``reward(sim, action)``, ``done(sim)``, ``randomise(random)``, and ``control_step`` [s].
    """

    def __init__(self, file: SceneFile) -> None:
        self._file = file
        self._first_memory = copy.deepcopy(file.memory)
        self._memory = self._first_memory
        self.name: str = file.name
        for function in ("spaces", "act", "observe", "reward"):
            if not callable(getattr(file.module, function, None)):
                raise TaskError(
                    f"scene '{file.name}': has no function {function}(): must have spaces, act, observe and "
                    f"reward to be an environment; or give a stark.gym.Task"
                )
        spaces = file.module.spaces()
        if not isinstance(spaces, tuple) or len(spaces) != 2:
            raise TaskError(f"scene '{file.name}': spaces() = {spaces!r}: must be (actions, observations)")
        self.action_space: Box = spaces[0]
        self.observation_space: Box = spaces[1]
        self.control_step: float = getattr(file.module, "control_step", Task.control_step)
        self.settle: float = getattr(file.module, "settle", Task.settle)
        self.until: float = Task.until if file.until is None else file.until

    def randomise(self, random: np.random.Generator) -> None:
        self._optional("randomise", None, random)

    @property
    def is_randomised(self) -> bool:
        return hasattr(self._file.module, "randomise")

    def build(self) -> tuple[Any, dict[str, Any]]:
        self._file.recall(copy.deepcopy(self._first_memory))
        built = self._file.build()
        self._memory = copy.deepcopy(self._file.memory)
        return built

    def _take_options(self, options: dict[str, Any]) -> None:
        if options:
            raise TaskError(
                f"scene '{self.name}': reset: options = {options!r}: must be none, functions of a scene file "
                "do not get them; give a stark.gym.Task"
            )

    def start(self, sim: Any, random: np.random.Generator) -> None:
        self._file.recall(copy.deepcopy(self._memory))  # what drive() remembered of the last episode goes
        self._optional("start", None, sim, random)

    def act(self, sim: Any, action: Floats) -> None:
        self._file.drive(sim)
        self._file.module.act(sim, action)

    def observe(self, sim: Any) -> Any:
        return self._file.module.observe(sim)

    def reward(self, sim: Any, action: Floats) -> float:
        reward: float = self._file.module.reward(sim, action)
        return reward

    def done(self, sim: Any) -> bool:
        done: bool = self._optional("done", False, sim)
        return done

    def info(self, sim: Any) -> dict[str, Any]:
        return self._file.measure(sim)

    def _optional(self, name: str, default: Any, *arguments: Any) -> Any:
        function: Callable[..., Any] | None = getattr(self._file.module, name, None)
        return default if function is None else function(*arguments)


class SceneTask(Task):
    """A task in the scene of a file or document instead of its own."""

    def __init__(self, task: Task, file: SceneFile) -> None:
        self._task, self._file = task, file
        self.__dict__.update(
            {
                name: getattr(task, name)
                for name in ("name", "action_space", "observation_space", "control_step", "until", "settle")
            }
        )
        for name in ("start", "act", "observe", "reward", "done", "info"):
            setattr(self, name, getattr(task, name))

    def build(self) -> tuple[Any, dict[str, Any]]:
        return self._file.build()

    def _take_options(self, options: dict[str, Any]) -> None:
        self._task._take_options(options)


def task_of(scene: str | PathLike[str] | Task, options: Mapping[str, Any] | None, task: Task | None) -> Task:
    """The task of what ``SceneEnv`` was given."""
    if isinstance(scene, Task):
        if task is not None or options:
            raise TaskError("SceneEnv: a task is given as the scene: must have neither task= nor options=")
        return scene
    if not isinstance(scene, (str, Path)) and not hasattr(scene, "__fspath__"):
        raise TaskError(f"SceneEnv: scene = {scene!r}: must be a scene file, a document or a stark.gym.Task")
    file = load(scene, options)
    if task is None:
        return FileTask(file)
    if not isinstance(task, Task):
        raise TaskError(f"SceneEnv: task = {task!r}: must be a stark.gym.Task")
    if task.is_randomised:
        raise TaskError(
            f"task '{task.name}': has randomise(), but the scene is that of '{file.name}': must build its "
            f"own scene of what it draws; or give the scene file a function randomise(random)"
        )
    return SceneTask(task, file)


def checked(task: Task) -> Task:
    """A task whose attributes fit together. Raises TaskError."""
    for name in ("action_space", "observation_space"):
        if not isinstance(getattr(task, name, None), Box):
            raise TaskError(f"task '{task.name}': {name} must be a gymnasium.spaces.Box")
    for name in ("control_step", "until", "settle"):
        value, zero = getattr(task, name), name == "settle"
        number = float(value) if isinstance(value, Real) else math.nan
        good = math.isfinite(number) and (number > 0.0 or (zero and number == 0.0))
        if not good:
            rule = f"must be a number {'>=' if zero else '>'} 0 and finite"
            raise TaskError(f"task '{task.name}': {name} = {value!r} s: {rule}")
    return task
