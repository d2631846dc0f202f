"""A scene as a Gymnasium environment."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from os import PathLike
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from stark._core import StepReport
from stark.arguments import shown_value
from stark.scene import Scene
from stark.simulation import Simulation
from stark.steps import limit_of_step, reached

from .task import Task, TaskError, checked, task_of

#: What functions of a task must do.
_ACT_RULE = "set targets and live values, and place bodies, only; the environment takes the steps"
_READ_RULE = "read only; the environment takes the steps"


class SceneEnv(gymnasium.Env[NDArray[Any], NDArray[Any]]):
    """An environment around a scene.

    ``scene`` is a scene file with ``spaces``, ``act``, ``observe`` and ``reward`` (a path or the name of a
    packaged one, with ``options`` as of ``stark run``), or a ``Task``; a scene document or another scene file
    takes a ``task`` beside it. ``settings`` go over those of the scene; one thread is the default, as
    processes are what learners have many of.

    ``render_mode="rgb_array"``: ``render()`` draws a picture of ``size`` pixels (width, height); ``camera``
    and other options of ``Simulation.picture`` in ``picture``.

    An episode is truncated after ``until`` of the task, ``info["reason"]`` is "time", and where a step of the
    simulation fails even at its shortest length: ``info["reason"]`` then names the cause, ``info["message"]``
    says what was found, and the observation is that of the last state that was reached. Observations and
    rewards are always finite; a task that gives others raises TaskError."""

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array"], "render_fps": 20}  # type: ignore[misc]

    def __init__(
        self,
        scene: str | PathLike[str] | Task,
        *,
        options: Mapping[str, Any] | None = None,
        task: Task | None = None,
        settings: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
        size: tuple[int, int] = (480, 360),
        picture: Mapping[str, Any] | None = None,
    ) -> None:
        for what, given in (("options", options), ("settings", settings), ("picture", picture)):
            if given is not None and not (
                isinstance(given, Mapping) and all(isinstance(k, str) for k in given)
            ):
                raise TaskError(f"SceneEnv: {what} = {given!r}: must be a dictionary of values by name")
        modes = (None, *self.metadata["render_modes"])
        if not isinstance(render_mode, (str, type(None))) or render_mode not in modes:
            raise TaskError(f"SceneEnv: render_mode = {render_mode!r}: must be None or 'rgb_array'")
        self.task: Task = checked(task_of(scene, options, task))
        self.action_space: Box = self.task.action_space
        self.observation_space: Box = self.task.observation_space
        self.render_mode = render_mode
        self._picture = {"size": size, "quality": "draft", **(picture or {})}
        self.metadata = {**self.metadata, "render_fps": max(1, round(1.0 / self.task.control_step))}  # type: ignore[misc]
        self._settings = dict(settings or {})
        self.task.randomise(np.random.default_rng(0))
        self._build()
        self._count: int | None = None  # control steps since the start; None: no episode

    # --- the interface of Gymnasium ---

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Starts an episode; the same ``seed`` gives the same one, whatever was before. Costs less than a
        step, as nothing is built again; a task with ``randomise`` gets another ``sim``. ``options`` become
        those of the task."""
        if options is not None and not isinstance(options, Mapping):
            raise TaskError(f"task '{self.task.name}': reset: options = {options!r}: must be a dictionary")
        self._count = None  # a reset that raises leaves no episode behind
        super().reset(seed=seed)
        self.task._take_options(dict(options or {}))
        if self.task.is_randomised:
            self.task.randomise(self.np_random)
            self._build()
        else:
            self.sim.reset(self._state)
            for live, values in zip(self.sim._live_values, self._values, strict=True):
                live.assign(values)
            self._put_back_functions_of_time()
        self.task.start(self.sim, self.np_random)
        self._begin = self.sim.time
        first = self._observation(), self._info()
        self._count = 0
        return first

    def step(self, action: NDArray[Any]) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """One control step. Actions beyond their space are cut to it; raises TaskError for those that are not
        finite or of another shape, and where no episode is under way."""
        if self._count is None:
            raise TaskError(f"task '{self.task.name}': step() without an episode: must be after reset()")
        given = self._action(action)
        failed = self._advance(given, self._begin + (self._count + 1) * self.task.control_step)
        self._count += 1  # not of a step whose act() raised: taken again, it has the same end
        observation = self._observation()
        reward, done, info = self._outcome(given)
        terminated = failed is None and done
        truncated = failed is not None or self._count * self.task.control_step >= self.task.until - 1e-9
        if failed is not None:
            cause = failed.diagnosis.cause if failed.diagnosis else "failed"
            info |= {"reason": str(cause), "message": str(failed.message)}
        elif truncated and not terminated:
            info["reason"] = "time"
        if terminated or truncated:
            self._count = None
        return observation, reward, terminated, truncated, info

    def render(self) -> NDArray[np.uint8] | None:  # type: ignore[override]
        """A picture (height, width, 3) uint8 with ``render_mode="rgb_array"``, else None."""
        if self.render_mode is None:
            return None
        return np.asarray(self.sim.picture(**self._picture), dtype=np.uint8)

    # --- details ---

    def _build(self) -> None:
        """A simulation of the scene of the task, settled."""
        built, own = self._built()
        self.sim: Simulation = Simulation(built, **{"threads": 1, **own, **self._settings})
        self._settle()
        self._state = self.sim.state
        self._values = [live.present() for live in self.sim._live_values]
        scene = self.sim.scene
        self._courses = dict(scene._courses)
        self._followers = {body: list(followers) for body, followers in scene._followers.items()}

    def _built(self) -> tuple[Scene, Mapping[str, Any]]:
        """What the task builds."""
        found: Any = self.task.build()
        if isinstance(found, tuple) and len(found) == 2:
            scene, settings = found
            if isinstance(scene, Scene) and isinstance(settings, Mapping):
                return scene, settings
        raise TaskError(
            f"task '{self.task.name}': build() gives {shown_value(found)}: must be a scene and its settings: "
            "return scene, {'time_step': 0.01}"
        )

    def _put_back_functions_of_time(self) -> None:
        """Those that the scene was built with: what an episode assigned, or let bodies follow, ends with
        it."""
        scene = self.sim.scene
        scene._courses.clear()
        scene._courses.update(self._courses)
        scene._followers.clear()
        scene._followers.update({body: list(found) for body, found in self._followers.items()})

    def _settle(self) -> None:
        end = self.sim.time + self.task.settle
        while self.task.settle > 0.0 and not reached(self.sim, end):
            report = self.sim.step(max_time_step=limit_of_step(self.sim, end))
            if report.failed:
                raise TaskError(f"task '{self.task.name}': fails while it settles: {report.message}")

    def _advance(self, action: NDArray[Any], end: float) -> StepReport | None:
        """Steps up to a time [s]; the report of a step that failed."""
        while not reached(self.sim, end):
            with self.sim._held_still(f"task '{self.task.name}': act()", _ACT_RULE, may_place=True):
                self.task.act(self.sim, action)
            report = self.sim.step(max_time_step=limit_of_step(self.sim, end))
            if report.failed:
                return report
        return None

    def _action(self, action: Any) -> NDArray[Any]:
        space = self.task.action_space
        try:
            numbers = np.asarray(action, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):  # a text, rows of several lengths
            numbers = np.full(space.shape, np.nan)
        if numbers.shape != space.shape or not np.isfinite(numbers).all():
            raise TaskError(
                f"task '{self.task.name}': action = {action!r}: must be {space.shape} finite numbers"
            )
        return np.clip(numbers, space.low, space.high)

    @contextmanager
    def _reading(self, function: str) -> Iterator[None]:
        """While a function of the task runs that must leave the simulation as it is."""
        with self.sim._held_still(f"task '{self.task.name}': {function}()", _READ_RULE):
            yield

    def _observation(self) -> NDArray[Any]:
        space = self.task.observation_space
        with self._reading("observe"):
            observed = self.task.observe(self.sim)
        try:
            numbers = np.asarray(observed, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise self._wrong("observe", observed, f"{space.shape} finite numbers") from None
        if observed is None or numbers.shape != space.shape or not np.isfinite(numbers).all():
            found = "None" if observed is None else f"the shape {numbers.shape}"
            raise TaskError(
                f"task '{self.task.name}': observe() gives {found}, "
                f"{int((~np.isfinite(numbers)).sum())} numbers not finite: must be {space.shape}, all finite"
            )
        return np.clip(numbers, space.low, space.high).astype(space.dtype)

    def _outcome(self, action: NDArray[Any]) -> tuple[float, bool, dict[str, Any]]:
        """Reward of a control step, whether the goal is reached, and what else there is to know."""
        with self._reading("reward"):
            reward = self.task.reward(self.sim, action)
        if not _is_number(reward) or not math.isfinite(reward):
            raise self._wrong("reward", reward, "a finite number")
        with self._reading("done"):
            done = self.task.done(self.sim)
        if not (isinstance(done, (bool, np.bool_)) or _is_number(done)):
            raise self._wrong("done", done, "True or False")
        return float(reward), bool(done), self._info()

    def _info(self) -> dict[str, Any]:
        with self._reading("info"):
            info = self.task.info(self.sim)
        if not isinstance(info, Mapping):
            raise self._wrong("info", info, "a dictionary")
        return dict(info)

    def _wrong(self, function: str, value: Any, rule: str) -> TaskError:
        return TaskError(f"task '{self.task.name}': {function}() = {shown_value(value, 80)}: must be {rule}")


def _is_number(value: Any) -> bool:
    """Also an array without dimensions."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    return isinstance(value, (bool, int, float, np.bool_, np.integer, np.floating))
