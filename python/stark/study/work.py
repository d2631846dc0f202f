"""Makes one run of a study, in whatever process: begins it or goes on with it, and writes its result."""

from __future__ import annotations

import math
import platform
import signal
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from .. import scenes
from ..array_file import DISK_ERRORS
from ..checkpoint import CheckpointError
from ..files import printable
from ..recording import Recording, RecordingError
from ..recording.format import CHECKPOINT
from ..recording.lock import FolderLock
from ..scenes.options import option_text
from ..scenes.resuming import read_checkpoint
from ..scenes.runner import told
from ..scenes.scene_file import SceneFile
from .folder import StudyFolder
from .task import Task

#: Called with the simulated time [s] that a run has reached.
OnTime = Callable[[float], None]

_LONGEST_MESSAGE = 4000

#: How long to wait for a process that was given up [s].
_PATIENCE = 60.0


@dataclass(frozen=True)
class _Watched(SceneFile):
    """A scene file that notes the state at the end of its run."""

    noted: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, scene_file: SceneFile) -> _Watched:
        return cls(**{f.name: getattr(scene_file, f.name) for f in fields(SceneFile)})

    def observables(self, sim: Any) -> dict[str, float]:
        self.noted["state_hash"] = sim.state.hash
        return super().observables(sim)


def perform(task: Task, on_time: OnTime | None = None) -> dict[str, Any]:
    """Makes a run unless its result is there; returns the result. It is written whole or not at all.

    Raises KeyboardInterrupt when the run was stopped: it has no result then, and a checkpoint to go on from.
    """
    folder = StudyFolder(task.folder)
    done = folder.result(task.key) or _after_others(task, folder)
    if done is not None:
        return done
    folder.begin(task.key)
    cpu, wall = clock.process_time(), clock.perf_counter()
    result = empty_result(task)
    with _limited(task.time_out) as alarm:
        try:
            result.update(_make(task, folder, on_time))
        except KeyboardInterrupt:
            result["status"] = "interrupted"
        except (Exception, SystemExit) as error:  # code of the user may raise anything
            result.update(reached(task, folder))
            result["status"], result["message"] = "error", told(error, task.scene)
            if isinstance(error, OSError) and error.errno in DISK_ERRORS:
                raise  # a full disk is no property of the run
    if alarm.rang and result["status"] in ("interrupted", "error"):
        result["status"], result["message"] = "timed_out", _too_long(task)
    if result["status"] == "interrupted":
        raise KeyboardInterrupt
    result["message"] = printable(result["message"])[:_LONGEST_MESSAGE]
    result["cpu"] = clock.process_time() - cpu
    result["wall"] = result["wall"] or clock.perf_counter() - wall
    folder.write_result(task.key, result)
    return result


def _after_others(task: Task, folder: StudyFolder) -> dict[str, Any] | None:
    """Waits for a process that was given up and still writes the run; returns the result if it made one."""
    place = folder.safe_run_folder(task.key)
    deadline = clock.monotonic() + _PATIENCE
    while place.is_dir():
        try:
            FolderLock(place).release()
        except RecordingError:
            if clock.monotonic() > deadline:
                raise
            clock.sleep(0.2)
        else:
            break
    return folder.result(task.key)


def empty_result(task: Task) -> dict[str, Any]:
    """The result of a run that came to nothing."""
    return {
        "key": task.key,
        "status": "crashed",
        "message": "",
        "options": task.options,
        "observables": {},
        "measured": {},
        "state_hash": "",
        "host": platform.node(),
        "simulated": 0.0,
        "wall": 0.0,
        "cpu": 0.0,
        **dict.fromkeys(("steps", "rejected_steps", "newton_iterations", "max_contacts"), 0),
    }


def reached(task: Task, folder: StudyFolder) -> dict[str, Any]:
    """How far a run got that came to no end by itself, from its telemetry; empty where it did not begin, or
    left a recording that cannot be read."""
    try:
        recording = Recording(folder.run_folder(task.key))
        if recording.status == "complete":  # of an earlier attempt, this one did not begin
            return {}
        steps = recording.telemetry
        if not len(steps):
            return {}
        sums = {name: int(steps[name].sum()) for name in ("rejected_steps", "newton_iterations")}
        return {
            "simulated": float(steps["time"][-1]),
            "steps": len(steps),
            **sums,
            "max_contacts": int(steps["contact_count"].max()),
            "measured": _last_measured(recording),
        }
    except (RecordingError, KeyError, ValueError, OSError):
        return {}


def timed_out_result(task: Task, folder: StudyFolder) -> dict[str, Any]:
    """The result of a run whose process had to be killed after the time-out."""
    found = {**empty_result(task), **reached(task, folder)}
    return {**found, "status": "timed_out", "message": _too_long(task)}


def _too_long(task: Task) -> str:
    return (
        f"took longer than limits.time_out = {task.time_out:g} s; raise it and resume with --retry-failed: "
        "the run goes on from its last checkpoint"
    )


def _make(task: Task, folder: StudyFolder, on_time: OnTime | None) -> dict[str, Any]:
    scene_file = _Watched.of(scenes.load(task.scene, task.options))
    place = folder.safe_run_folder(task.key)
    common: dict[str, Any] = {"replay": False, "picture": False}
    if on_time is not None:
        common["on_step"] = lambda sim, report: on_time(float(sim.time))
        common["on_progress"] = lambda progress: on_time(float(progress.time))
    settings = {**task.settings, "threads": 1}
    if _can_go_on(task, place):
        run = scenes.resume(place, scene=scene_file, **common)
    else:
        run = scenes.run(
            scene_file,
            out=place,
            until=task.until,
            settings=settings,
            fps=task.fps,
            checkpoint_every=task.checkpoint_every,
            certify=task.certify,
            **common,
        )
    recording = Recording(place)
    observables = recording.manifest.get("summary", {}).get("observables", {})
    return {
        "status": run.status,
        "message": run.message,
        "simulated": run.simulated,
        "wall": run.wall,
        "steps": run.steps,
        "rejected_steps": run.rejected_steps,
        "newton_iterations": run.newton_iterations,
        "max_contacts": run.max_contacts,
        "observables": {name: _number(value) for name, value in observables.items()},
        "measured": _last_measured(recording),
        "state_hash": scene_file.noted.get("state_hash", ""),
    }


def _number(value: Any) -> float:
    """JSON of a manifest has null for what is not finite."""
    return math.nan if value is None else float(value)


def _last_measured(recording: Recording) -> dict[str, float]:
    """The values of ``measure(sim)`` after the last step."""
    telemetry = recording.telemetry
    names = [name for name in telemetry.names if name.startswith("measured.")]
    return {name.partition(".")[2]: float(telemetry[name][-1]) for name in names} if len(telemetry) else {}


def _can_go_on(task: Task, place: Path) -> bool:
    """Whether the folder has a checkpoint of this very run; anything else is made anew."""
    if not (place / CHECKPOINT).is_file() or (place / CHECKPOINT).is_symlink():
        return False
    try:
        plan = (read_checkpoint(place).run or {})["plan"]
        wanted = {name: option_text(value) for name, value in task.options.items()}
        same = plan["options"] == wanted and plan["until"] == task.until
        return bool(same and plan["settings"] == {**task.settings, "threads": 1})
    except (CheckpointError, KeyError, TypeError):
        return False


class _Alarm:
    rang = False

    def ring(self, number: int, frame: Any) -> None:
        self.rang = True
        raise KeyboardInterrupt


@contextmanager
def _limited(seconds: float | None) -> Iterator[_Alarm]:
    """Raises KeyboardInterrupt when that much time has passed, which ends a run between two iterations."""
    alarm = _Alarm()
    if seconds is None:
        yield alarm
        return
    before = signal.signal(signal.SIGALRM, alarm.ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield alarm
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
