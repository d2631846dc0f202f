"""Runs a scene file: builds it, steps it, records it, keeps a checkpoint to go on from, checks it."""

from __future__ import annotations

import time as clock
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

from .._core import InvalidArgument
from .._interrupts import Deferred
from ..arguments import given_flag, given_path, real_number
from ..array_file import WriteError, refuse_link
from ..checkpoint import CheckpointError
from ..files import resolved
from ..recording import Recorder, Recording
from ..recording.format import CHECKPOINT, FAILURE, PICTURE
from ..steps import OnProgress, limit_of_step, reached
from .options import SceneFileError
from .scene_file import SceneFile, load

#: An interrupted run still gets its replay page when its recording is smaller than this.
_QUICK_PAGE_BYTES = 20e6

#: Wall-clock time from one checkpoint of a run to the next [s].
CHECKPOINT_PERIOD = 60.0

#: What a scene's drive(sim) must do.
DRIVE_RULE = "set targets and live values, and place bodies, only; the run takes the steps"

#: What a result counts, kept when a run is resumed.
COUNTS = ("steps", "rejected_steps", "newton_iterations", "max_contacts")

OnStep = Callable[[Any, Any], None]


@dataclass
class RunResult:
    """What a run came to. ``status`` is complete, failed, interrupted or wrong (the scene's check raised)."""

    scene: str
    status: str
    message: str
    simulated: float  # [s]
    wall: float  # [s]
    folder: Path
    steps: int = 0
    rejected_steps: int = 0
    newton_iterations: int = 0
    max_contacts: int = 0
    files: list[Path] = field(default_factory=list)

    @property
    def exit_code(self) -> int:
        """Exit code of ``stark run``: 0 complete, 130 interrupted, else 1."""
        return {"complete": 0, "interrupted": 130}.get(self.status, 1)


@dataclass(frozen=True)
class Plan:
    """What was asked of a run: all that is needed to go on with it."""

    scene: str  # packaged name or path
    options: dict[str, str]
    settings: dict[str, Any]  # those of the caller, over those of the file
    until: float  # [s]
    fps: float  # frames per simulated second
    checkpoint_every: float | None  # [s] of wall-clock time, None: no checkpoints
    content: str = ""  # SHA-256 of the scene file, "" where that is none


def end_time(scene_file: SceneFile, until: float | None) -> float:
    """The simulated time [s]: the caller's, else the file's."""
    end = scene_file.until if until is None else real_number(until, "run: until")
    if end is None:
        raise SceneFileError(f"scene '{scene_file.name}' does not say how long to run; give --until SECONDS")
    if not 0.0 < end < float("inf"):
        raise SceneFileError(f"until = {end} s; must be positive and finite")
    return end


def status_of(report: Any) -> str:
    """``accepted``, ``retried`` or ``failed``."""
    return str(getattr(report.status, "name", report.status)).lower()


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
    checkpoint_every: float | None = CHECKPOINT_PERIOD,
    certify: bool = False,
    fields: Sequence[str] = (),
    contacts: bool = False,
    on_step: OnStep | None = None,
    on_progress: OnProgress | None = None,
) -> RunResult:
    """Runs a scene file until its end, which the last step is shortened to meet, and leaves recording, replay
    page and a picture in ``out``.

    ``out`` defaults to ``out/<scene>``. ``settings`` go over those of the file. ``fps`` is the largest
    number of recorded frames per simulated second; the last state is always recorded. ``checkpoint_every``
    [s] of wall-clock time: how often ``checkpoint.stark`` is written, 0 after each step, None never;
    ``resume`` goes on from it. ``certify`` records every accepted step in double precision, too, for
    ``stark.verify``. ``fields`` and ``contacts`` are recorded in every frame, as by ``Recorder``, also after
    the run is resumed. ``on_step(sim, report)`` is called after each step, ``on_progress(p)`` while one is
    under way, as ``progress`` of ``Simulation.step``. The run stops cleanly on KeyboardInterrupt: the
    recording is complete up to the last accepted step. A check is made only when the run went to the file's
    own end.
    """
    import stark

    scene_file = scene if isinstance(scene, SceneFile) else load(scene)
    switches = {
        "replay": replay,
        "picture": picture,
        "check": check,
        "certify": certify,
        "contacts": contacts,
    }
    for what, value in switches.items():
        given_flag(value, f"run: {what}")
    if settings is not None and not isinstance(settings, Mapping):
        raise SceneFileError(f"run: settings = {settings!r}; must be a dictionary of values by dotted name")
    plan = Plan(
        scene=scene_file.source,
        options=scene_file.options,
        settings=dict(settings or {}),
        until=end_time(scene_file, until),
        fps=_positive(fps),
        checkpoint_every=_period(checkpoint_every),
        content=scene_file.content,
    )
    folder = Path("out") / scene_file.name if out is None else given_path(out, "run: out")
    folder = resolved(folder)  # functions of the scene may change the current folder
    sim = make_simulation(scene_file, plan.settings)
    with Deferred():  # whatever stops it from here on, the folder can be resumed
        recorder = Recorder(
            folder,
            sim,
            scene=scene_file.name,
            settings=sim.settings.to_dict(),
            stark_version=stark.__version__,
            certify=certify,
            fields=fields,
            contacts=contacts,
        )
        recorder.record(sim)
        recorder.record_state(sim)
        result = RunResult(scene_file.name, "complete", "", 0.0, 0.0, recorder.folder)
        job = Job(scene_file, plan, sim, recorder, result)
        job.save()
    return job.finish(job.advance(on_step, on_progress), replay, picture, check)


def make_simulation(scene_file: SceneFile, settings: Mapping[str, Any]) -> Any:
    """The scene of a file with its settings and those of the caller."""
    import stark

    built, file_settings = scene_file.build()
    return stark.Simulation(built, **{**file_settings, **settings})


def _positive(fps: float) -> float:
    if not fps > 0.0:
        raise SceneFileError(f"fps = {fps}; must be positive")
    return float(fps)


def _period(seconds: float | None) -> float | None:
    if seconds is not None and not 0.0 <= seconds < float("inf"):
        raise SceneFileError(f"checkpoint_every = {seconds} s; must be >= 0 and finite, or None for none")
    return None if seconds is None else float(seconds)


@dataclass
class Job:
    """A run under way."""

    scene_file: SceneFile
    plan: Plan
    sim: Any
    recorder: Recorder
    result: RunResult  # counts and time of the run before it was resumed
    _begin: float = field(default_factory=clock.perf_counter, init=False)
    _saved_at: float = field(default=-float("inf"), init=False)

    def __post_init__(self) -> None:
        self._wall_before = self.result.wall  # [s]

    def save(self) -> None:
        """Where it is now, to be resumed from."""
        try:
            self._save(self._moment())
        except BaseException as error:
            self._leave(None, error)
            raise

    def advance(self, on_step: OnStep | None, on_progress: OnProgress | None = None) -> RunResult:
        """Steps until the end. Whatever ends the loop, the last moment between two steps is saved, but none
        after steps that were shortened to meet the end: with a later end, they are taken whole."""
        moment, shortened = None, False
        try:
            moment = self._moment()
            while not reached(self.sim, self.plan.until):
                self._save(moment, only_when_due=True)
                limit = limit_of_step(self.sim, self.plan.until)
                report = self._step(limit, on_progress)
                if report is None:
                    break
                shortened = shortened or limit is not None
                moment = moment if shortened else self._moment()
                if on_step:
                    on_step(self.sim, report)
        except KeyboardInterrupt:
            self.result.status, self.result.message = "interrupted", "stopped by the user"
        except BaseException as error:
            self._leave(moment, error)
            raise
        self._save(moment)
        return self.result

    def _leave(self, moment: Any, error: BaseException) -> None:
        """Saves what can be saved. A full disk may refuse that as well: what is raised is what went wrong
        first."""
        with suppress(OSError, CheckpointError):
            self._save(moment)
        with suppress(OSError):
            self.recorder.close("failed", f"{type(error).__name__}: {error}")

    def _step(self, limit: float | None, on_progress: OnProgress | None) -> Any:
        """One step of at most ``limit`` [s] with its telemetry and frame; its report, or None when it
        failed."""
        with self.sim._held_still("drive(sim) of the scene", DRIVE_RULE, may_place=True):
            self.scene_file.drive(self.sim)
        if len(self.sim._core.placed_bodies) > 0:
            self.recorder.record_state(self.sim)  # a jump, which no step leads to
        before = clock.perf_counter()
        report = self.sim.step(max_time_step=limit, progress=on_progress)
        wall, failed = clock.perf_counter() - before, status_of(report) == "failed"
        with self.sim._held_still("measure(sim) of the scene", "read only; the run takes the steps"):
            measured = {} if failed else self.scene_file.measure(self.sim)
        self.recorder.report(report, wall=wall, **({"measured": measured} if measured else {}))
        self._count(report)
        if failed:
            self.result.status, self.result.message = "failed", str(report.message)
            self._keep_failure()
            return None
        self.recorder.record_state(self.sim)
        if self.sim.time - self.recorder.last_time >= 1.0 / self.plan.fps - 1e-9:
            self.recorder.record(self.sim)
        return report

    def _keep_failure(self) -> None:
        """The failed step as a folder of its own."""
        folder = self.recorder.folder / FAILURE
        try:
            refuse_link(folder)
            self.result.files.append(self.sim.write_reproducer(folder))
        except (InvalidArgument, WriteError) as error:
            self.result.message += f"; no reproducer was written: {error}"

    def _observables(self) -> dict[str, float]:
        try:
            with self.sim._held_still(
                "observables(sim) of the scene", "read only; the run has come to its end"
            ):
                return self.scene_file.observables(self.sim)
        except BaseException as error:
            self.recorder.close("failed", f"{type(error).__name__}: {error}")
            raise

    def _count(self, report: Any) -> None:
        self.result.steps += 1
        self.result.rejected_steps += int(report.rejected_steps)
        self.result.newton_iterations += int(report.newton_iterations)
        self.result.max_contacts = max(self.result.max_contacts, int(report.contact_count))

    def _moment(self) -> Any:
        """Where the run is between two steps, before the controller acts: what it can be resumed from."""
        if self.plan.checkpoint_every is None:
            return None
        from ..checkpoint import Checkpoint

        run = {
            "plan": asdict(self.plan),
            "frames": self.recorder.frame_count,
            "lines": self.recorder.line_count,
            "states": self.recorder.state_count,
            "counts": {name: getattr(self.result, name) for name in COUNTS},
            "wall": self._wall(),
        }
        return Checkpoint.of(self.sim, memory=self.scene_file.memory, run=run)

    def _wall(self) -> float:
        return self._wall_before + clock.perf_counter() - self._begin

    def _save(self, moment: Any, *, only_when_due: bool = False) -> None:
        """First what the checkpoint builds on, then the checkpoint: a run that is killed in between has more
        than it needs."""
        if moment is None:
            return
        now, period = clock.perf_counter(), self.plan.checkpoint_every
        if only_when_due and period is not None and now - self._saved_at < period:
            return
        self.recorder.sync()
        moment.write(self.recorder.folder / CHECKPOINT)
        self._saved_at = now

    def finish(self, result: RunResult, replay: bool, picture: bool, check: bool) -> RunResult:
        """The last frame, summary, page, picture and check."""
        if self.sim.time > self.recorder.last_time:
            self.recorder.record(self.sim)  # the end, or where a stopped or failed run got to
        result.simulated, result.wall = float(self.sim.time), self._wall()
        complete = result.status == "complete"
        summary = {
            "simulated": result.simulated,
            "wall": result.wall,
            "steps": result.steps,
            "rejected_steps": result.rejected_steps,
            "newton_iterations": result.newton_iterations,
            "observables": self._observables() if complete else {},
        }
        self.recorder.close(result.status, result.message, summary)
        own_end = self.plan.until >= (self.scene_file.until or self.plan.until)
        _finish(result, self.scene_file, replay, picture, check and own_end)
        return result


def _finish(result: RunResult, scene_file: SceneFile, replay: bool, picture: bool, check: bool) -> None:
    """Page, picture and check, from the recording as anybody would read it."""
    recording = Recording(result.folder)
    size = sum(body.vertex_count for body in recording.bodies) * len(recording) * 12
    if replay and (result.status != "interrupted" or size < _QUICK_PAGE_BYTES):
        from ..replay import write_page

        result.files.append(write_page(recording))
    if picture and result.status != "interrupted":
        from ..render import render, write_png

        path = result.folder / PICTURE
        write_png(path, render(recording.frame(-1)))
        result.files.append(path)
    if check and result.status == "complete" and scene_file.has_check:
        file = str(scene_file.module.__file__)
        try:
            scene_file.check(recording)
        except AssertionError as error:
            text = str(error) or "an assert without a message"
            result.status = "wrong"
            result.message = f"the scene's check failed: {text}{place_in(error, file)}"
        except Exception as error:  # code of the user may raise anything
            text = told(error, file)
            result.status, result.message = "wrong", f"the scene's check raised {text}"
        else:
            result.message = "check passed"


def told(error: BaseException, file: str) -> str:
    """Kind and text of what a scene file raised, and the line of the scene's file that it came from."""
    return f"{type(error).__name__}: {error}{place_in(error, file)}"


def place_in(error: BaseException, file: str) -> str:
    """' (name of the file, line)' where an error came from, if it passed through that file."""
    path = Path(file).resolve()
    rows = [row for row in traceback.extract_tb(error.__traceback__) if Path(row.filename).resolve() == path]
    return f" ({path.name}, line {rows[-1].lineno})" if rows else ""
