"""Goes on with a run that was killed, stopped or failed, or lets one that is complete run longer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from os import PathLike
from pathlib import Path
from typing import Any

from ..checkpoint import Checkpoint, CheckpointError
from ..recording import Recorder
from ..recording.format import CHECKPOINT
from .runner import Job, OnStep, Plan, RunResult, end_time, make_simulation, reached
from .scene_file import SceneFile, load


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
) -> RunResult:
    """Goes on with the run in ``folder`` from its last checkpoint; frames and telemetry after it are dropped
    and made again, so that the recording ends up as that of an uninterrupted run.

    ``scene`` is needed when the scene file has been moved. ``until`` [s] replaces the end. ``settings`` are
    changed from here on: with those that influence results the run is another one than without them. Raises
    ``CheckpointError`` when there is no checkpoint, or one of another scene than the file now makes, and
    ``RecordingError`` when the recording is damaged."""
    folder = Path(folder)
    checkpoint = read_checkpoint(folder)
    owner = f"checkpoint '{folder / CHECKPOINT}'"
    plan, frames, lines, counts, wall = _read_run(checkpoint, owner)
    scene_file = scene if isinstance(scene, SceneFile) else load(scene or plan.scene, plan.options)
    changed = dict(settings or {})
    plan = replace(
        plan,
        scene=scene_file.source,
        settings={**plan.settings, **changed},
        until=end_time(scene_file, plan.until if until is None else until),
    )
    sim = make_simulation(scene_file, plan.settings)
    checkpoint.put_into(sim, exact=not _matter(changed), owner=owner)
    if reached(sim, plan.until) and until is not None and sim.time > until + sim.time_step:
        raise CheckpointError(f"{owner}: is at {sim.time:g} s, after until = {until:g} s; give a later end")
    scene_file.recall(checkpoint.memory)
    recorder = Recorder.resume(folder, sim, frames=frames, lines=lines)
    result = RunResult(scene_file.name, "complete", "", 0.0, wall, **counts)
    job = Job(scene_file, plan, sim, recorder, result)
    return job.finish(job.advance(on_step), replay, picture, check)


def planned_end(folder: Path) -> float:
    """Simulated time [s] at which the run in ``folder`` was to end."""
    checkpoint = read_checkpoint(folder)
    return _read_run(checkpoint, f"checkpoint '{folder / CHECKPOINT}'")[0].until


def read_checkpoint(folder: Path) -> Checkpoint:
    """The checkpoint of a run folder."""
    path = folder / CHECKPOINT
    if not path.exists():
        what = "it has no checkpoint" if folder.is_dir() else "no such folder"
        raise CheckpointError(f"'{folder}' cannot be resumed: {what}; run the scene anew")
    return Checkpoint.read(path)


def _matter(settings: Mapping[str, Any]) -> bool:
    """Whether any of them influences results."""
    return any(not name.startswith("execution.") and name != "threads" for name in settings)


def _read_run(checkpoint: Checkpoint, owner: str) -> tuple[Plan, int, int, dict[str, int], float]:
    if checkpoint.run is None:
        raise CheckpointError(f"{owner}: was not written by 'stark run'; load it with Simulation.load()")
    try:
        run = checkpoint.run
        plan = Plan(**{f.name: run["plan"][f.name] for f in fields(Plan)})
        frames, lines = int(run["frames"]), int(run["lines"])
        counts = {str(name): int(value) for name, value in run["counts"].items()}
        if not plan.fps > 0.0 or frames < 1 or lines < 0:
            raise ValueError("frames and fps must be positive")
        return plan, frames, lines, counts, float(run["wall"])
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise CheckpointError(f"{owner} is damaged (run: {error}); run the scene anew") from error
