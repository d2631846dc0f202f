"""Runs a scene file: builds it, steps it, records it, checks it."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

from ..recording import Recorder, Recording
from .scene_file import SceneFile, SceneFileError, load

#: An interrupted run still gets its replay page when its recording is smaller than this.
_QUICK_PAGE_BYTES = 20e6


@dataclass
class RunResult:
    """What a run came to. ``status`` is complete, failed, interrupted or wrong (the scene's check raised)."""

    scene: str
    status: str
    message: str
    simulated: float  # [s]
    wall: float  # [s]
    steps: int = 0
    rejected_steps: int = 0
    newton_iterations: int = 0
    max_contacts: int = 0
    folder: Path | None = None
    files: list[Path] = field(default_factory=list)

    @property
    def exit_code(self) -> int:
        return {"complete": 0, "interrupted": 130}.get(self.status, 1)


def end_time(scene_file: SceneFile, until: float | None) -> float:
    """The simulated time [s]: the caller's, else the file's."""
    end = scene_file.until if until is None else float(until)
    if end is None:
        raise SceneFileError(f"scene '{scene_file.name}' does not say how long to run; give --until SECONDS")
    if not 0.0 < end < float("inf"):
        raise SceneFileError(f"until = {end} s; must be positive and finite")
    return end


def status_of(report: Any) -> str:
    """``accepted``, ``retried`` or ``failed``."""
    return str(getattr(report.status, "name", report.status)).lower()


def reached(sim: Any, end: float) -> bool:
    """Whether the time of a simulation, a sum of steps, has come to ``end`` [s], up to rounding."""
    return sim.time >= end - 1e-6 * sim.time_step


def run(
    scene: str | PathLike[str] | SceneFile,
    *,
    out: str | PathLike[str] | None = None,
    until: float | None = None,
    settings: Mapping[str, Any] | None = None,
    fps: float = 60.0,
    replay: bool = True,
    picture: bool = True,
    check: bool = True,
    certify: bool = False,
    on_step: Callable[[Any, Any], None] | None = None,
) -> RunResult:
    """Runs a scene file until its end and leaves recording, replay page and a picture in ``out``.

    ``out`` defaults to ``out/<scene>``. ``settings`` go over those of the file. ``fps`` is the largest
    number of recorded frames per simulated second; the last state is always recorded. ``on_step(sim,
    report)`` is called after each step. The run stops cleanly on KeyboardInterrupt: the recording is
    complete up to the last accepted step. A check is made only when the run went to the file's own end.
    ``certify`` records every accepted step in double precision, too, for ``stark.verify``.
    """
    import stark

    scene_file = scene if isinstance(scene, SceneFile) else load(scene)
    end = end_time(scene_file, until)
    if not fps > 0.0:
        raise SceneFileError(f"fps = {fps}; must be positive")
    built, file_settings = scene_file.build()
    all_settings = {**file_settings, **dict(settings or {})}
    sim = stark.Simulation(built, **all_settings)
    folder = Path(out) if out is not None else Path("out") / scene_file.name
    stored = sim.settings.to_dict() if hasattr(sim, "settings") else all_settings
    recorder = Recorder(
        folder,
        sim,
        scene=scene_file.name,
        settings=stored,
        stark_version=stark.__version__,
        certify=certify,
    )
    result = RunResult(scene_file.name, "complete", "", float(sim.time), 0.0, folder=folder)
    begin = clock.perf_counter()
    try:
        recorder.record(sim)
        recorder.record_state(sim)
        while not reached(sim, end):
            scene_file.drive(sim)
            before = clock.perf_counter()
            report = sim.step()
            wall, failed = clock.perf_counter() - before, status_of(report) == "failed"
            measured = {} if failed else scene_file.measure(sim)
            recorder.report(report, wall=wall, **({"measured": measured} if measured else {}))
            _count(result, report)
            if failed:
                result.status, result.message = "failed", str(report.message)
                break
            recorder.record_state(sim)
            if reached(sim, end) or sim.time - recorder.last_time >= 1.0 / fps - 1e-9:
                recorder.record(sim)
            if on_step:
                on_step(sim, report)
    except KeyboardInterrupt:
        result.status, result.message = "interrupted", "stopped by the user"
    except BaseException as error:
        recorder.close("failed", f"{type(error).__name__}: {error}")
        raise
    if sim.time > recorder.last_time:
        recorder.record(sim)  # where a stopped or failed run got to
    result.simulated = float(sim.time)
    result.wall = clock.perf_counter() - begin
    observables = scene_file.observables(sim) if result.status == "complete" else {}
    summary = {
        "simulated": result.simulated,
        "wall": result.wall,
        "steps": result.steps,
        "rejected_steps": result.rejected_steps,
        "newton_iterations": result.newton_iterations,
        "observables": observables,
    }
    recorder.close(result.status, result.message, summary)
    _finish(result, scene_file, replay, picture, check and end >= (scene_file.until or end))
    return result


def _count(result: RunResult, report: Any) -> None:
    result.steps += 1
    result.rejected_steps += int(report.rejected_steps)
    result.newton_iterations += int(report.newton_iterations)
    result.max_contacts = max(result.max_contacts, int(report.contact_count))


def _finish(result: RunResult, scene_file: SceneFile, replay: bool, picture: bool, check: bool) -> None:
    """Page, picture and check, from the recording as anybody would read it."""
    assert result.folder is not None
    recording = Recording(result.folder)
    size = sum(body.vertex_count for body in recording.bodies) * len(recording) * 12
    if replay and (result.status != "interrupted" or size < _QUICK_PAGE_BYTES):
        from ..replay import write_page

        result.files.append(write_page(recording))
    if picture and result.status != "interrupted":
        from ..render import render, write_png

        path = result.folder / "picture.png"
        write_png(path, render(recording.frame(-1)))
        result.files.append(path)
    if check and result.status == "complete" and scene_file.has_check:
        try:
            scene_file.check(recording)
        except AssertionError as error:
            result.status, result.message = "wrong", f"the scene's check failed: {error}"
        else:
            result.message = "check passed"
