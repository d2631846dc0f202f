"""Goes on with a run that was killed, stopped or failed, or lets one that is complete run longer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from os import PathLike
from pathlib import Path
from shlex import quote
from typing import Any

from .._interrupts import Deferred
from ..arguments import given_path
from ..caller import warn
from ..checkpoint import Checkpoint, CheckpointError
from ..files import resolved
from ..recording import Recorder
from ..recording.format import CHECKPOINT
from ..recording.lock import FolderLock
from ..steps import OnProgress
from .runner import COUNTS, Job, OnStep, Plan, RunResult, end_time, make_simulation
from .scene_file import SceneFile, load, names


def resume(
    folder: str | PathLike[str],
    *,
    scene: str | PathLike[str] | SceneFile | None = None,
    until: float | None = None,
    settings: Mapping[str, Any] | None = None,
    replay: bool = True,
    picture: bool = True,
    check: bool = True,
    on_step: OnStep | None = None,
    on_progress: OnProgress | None = None,
) -> RunResult:
    """Goes on with the run in ``folder`` from its last checkpoint; frames and telemetry after it are dropped
    and made again, so that the recording ends up as that of an uninterrupted run.

    ``scene`` is needed when the scene file has been moved. ``until`` [s] replaces the end; with a later one,
    steps that were shortened to meet the old one are taken whole. ``settings`` are changed from here on: with
    those that influence results the run is another one than without them. Raises ``CheckpointError`` when
    there is no checkpoint, or one of another scene than the file now makes, and ``RecordingError`` when the
    recording is damaged or another process writes it."""
    folder = resolved(given_path(folder, "resume: folder"))
    _require_checkpoint(folder)
    lock = FolderLock(folder)
    try:
        job = _job(folder, scene, until, dict(settings or {}), lock)
    except BaseException:
        lock.release()
        raise
    return job.finish(job.advance(on_step, on_progress), replay, picture, check)


def _job(
    folder: Path,
    scene: str | PathLike[str] | SceneFile | None,
    until: float | None,
    changed: dict[str, Any],
    lock: FolderLock,
) -> Job:
    """The run as it was at its last checkpoint."""
    checkpoint = read_checkpoint(folder)
    owner = f"checkpoint '{folder / CHECKPOINT}'"
    plan, recorded, counts, wall = _read_run(checkpoint, owner)
    scene_file = scene if isinstance(scene, SceneFile) else _load(scene, plan, folder, owner)
    is_changed = bool(plan.content) and scene_file.content != plan.content
    plan = replace(
        plan,
        scene=scene_file.source,
        content=scene_file.content,
        settings={**plan.settings, **changed},
        until=end_time(scene_file, plan.until if until is None else until),
    )
    sim = make_simulation(scene_file, plan.settings)
    checkpoint.put_into(sim, exact=not _matter(changed), owner=owner)
    if until is not None and sim.time > until + 1e-9 * sim.time_step:
        raise CheckpointError(f"{owner}: is at {sim.time:g} s, after until = {until:g} s; give a later end")
    scene_file.recall(checkpoint.memory)
    if is_changed:
        warn(
            f"{owner}: the scene file '{scene_file.source}' is not as it was before {sim.time:g} s: its "
            f"functions and options hold from there on, earlier steps stay as they are; run it anew if all "
            f"are to follow it"
        )
    with Deferred():
        recorder = Recorder.resume(folder, sim, **recorded, lock=lock)
    result = RunResult(scene_file.name, "complete", "", 0.0, wall, recorder.folder, **dict[str, Any](counts))
    return Job(scene_file, plan, sim, recorder, result)


def _load(scene: str | PathLike[str] | None, plan: Plan, folder: Path, owner: str) -> SceneFile:
    """The scene that the caller names, or that of the run. A scene file is code: one that came with the run
    folder, or that is found from the current folder only, is not executed unless the caller names it."""
    if scene is None and plan.scene not in names():
        path = Path(plan.scene)
        if not path.is_absolute() or path.resolve().is_relative_to(folder.resolve()):
            raise CheckpointError(
                f"{owner}: names the scene '{plan.scene}': must be an absolute path outside of the run "
                f"folder; say which scene it is: stark run SCENE --resume {quote(str(folder))}"
            )
    return load(plan.scene if scene is None else scene, plan.options)


def planned_end(folder: Path) -> float:
    """Simulated time [s] at which the run in ``folder`` was to end."""
    checkpoint = read_checkpoint(folder)
    return _read_run(checkpoint, f"checkpoint '{folder / CHECKPOINT}'")[0].until


def read_checkpoint(folder: Path) -> Checkpoint:
    """The checkpoint of a run folder."""
    _require_checkpoint(folder)
    return Checkpoint.read(folder / CHECKPOINT)


def _require_checkpoint(folder: Path) -> None:
    if not (folder / CHECKPOINT).exists():
        what = "it has no checkpoint" if folder.is_dir() else "no such folder"
        raise CheckpointError(f"'{folder}' cannot be resumed: {what}; run the scene anew")


def _matter(settings: Mapping[str, Any]) -> bool:
    """Whether any of them influences results."""
    return any(not name.startswith("execution.") and name != "threads" for name in settings)


def _read_run(checkpoint: Checkpoint, owner: str) -> tuple[Plan, dict[str, int], dict[str, int], float]:
    """The plan, how many frames, lines and states are recorded, what a result counts, seconds so far."""
    if checkpoint.run is None:
        raise CheckpointError(f"{owner}: was not written by 'stark run'; load it with Simulation.load()")
    run = checkpoint.run
    try:
        plan = _plan(run["plan"])
        recorded = {"frames": run["frames"], "lines": run["lines"], "states": run.get("states", 0)}
        wall = run["wall"]
        counts = {name: run["counts"][name] for name in COUNTS}
        for name, value, least in (
            *((n, c, 1 if n == "frames" else 0) for n, c in recorded.items()),
            *((n, c, 0) for n, c in counts.items()),
        ):
            if type(value) is not int or value < least:
                raise ValueError(f"{name} = {value!r}: must be an integer >= {least}")
        _number("wall", wall, at_least=0.0)
    except (KeyError, TypeError, ValueError) as error:
        raise CheckpointError(f"{owner} is damaged (run: {error}); run the scene anew") from error
    return plan, recorded, counts, wall


def _plan(given: dict[str, Any]) -> Plan:
    """Raises KeyError, TypeError or ValueError for what a run never writes."""
    if not isinstance(given, dict):
        raise TypeError(f"plan = {given!r}: must be an object")
    written: dict[str, Any] = {"content": ""} | given  # which earlier runs did not write
    plan = Plan(**{f.name: written[f.name] for f in fields(Plan)})
    if not isinstance(plan.scene, str) or not isinstance(plan.options, dict):
        raise TypeError("scene and options must be a text and an object")
    if not isinstance(plan.content, str):
        raise TypeError("content must be a text")
    if not all(isinstance(text, str) for text in plan.options.values()):
        raise TypeError("options must be texts")
    if not isinstance(plan.settings, dict):
        raise TypeError("settings must be an object")
    _number("until", plan.until, at_least=0.0)
    if _number("fps", plan.fps, at_least=0.0) == 0.0:
        raise ValueError("fps must be > 0")
    if plan.checkpoint_every is not None:
        _number("checkpoint_every", plan.checkpoint_every, at_least=0.0)
    return plan


def _number(name: str, value: Any, at_least: float) -> float:
    if not isinstance(value, float) or not at_least <= value < float("inf"):
        raise ValueError(f"{name} = {value!r}: must be a number >= {at_least:g}")
    return value
