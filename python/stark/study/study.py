"""Makes studies, goes on with them and reads them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np

from .._core import InvalidArgument
from ..arguments import given_flag, given_path, given_task
from ..files import printable, resolved
from ..recording.lock import FolderLock
from ..scenes import load, names
from . import page, table
from .folder import STATUSES, RunEntry, StudyError, StudyFolder
from .local import LocalPool, default_processes
from .plan import Plan
from .table import Row
from .task import Task, entry_options, settled, tasks

#: Called with the runs that are over, all runs, and the work done in runs (parts of those under way count).
OnProgress = Callable[[int, int, float], None]

_ON_PROGRESS = "a function of the runs that are over, all runs and the work done in runs"

#: Files that a study writes of its results.
CSV, PARQUET, PAGE = "table.csv", "table.parquet", "study.html"


class Study:
    """A study folder: its plan, and a row for each run. ``scene`` is needed when the scene file was moved, or
    came with the folder."""

    def __init__(self, folder: str | PathLike[str], *, scene: str | PathLike[str] | None = None) -> None:
        self._files = StudyFolder(folder)
        plan, runs = self._files.read()
        self.runs: list[RunEntry] = runs
        self.folder: Path = self._files.path
        self.plan: Plan = plan if scene is None else _with_scene(plan, str(given_path(scene, "study: scene")))
        self._scene_is_named = scene is not None
        #: Runs that ``run`` or ``resume`` made, and those whose results it kept.
        self.made: int = 0
        self.kept: int = 0

    def rows(self) -> list[Row]:
        """The table as dictionaries, in the order of the plan; runs that are not over are ``waiting``, or
        ``begun``. Executes nothing of the scene."""
        rows = []
        for index, entry in enumerate(self.runs):
            known = table.row(index, entry.key, entry.repetition, entry.options, "waiting")
            result = self._files.result(entry.key)
            attempts = self._files.attempts(entry.key)
            if result is not None:
                known = table.with_result(known, result, attempts)
            elif attempts:
                known["status"] = "begun"
            rows.append(known)
        return rows

    def counts(self) -> dict[str, int]:
        """How many runs have come to what: complete, failed, ..., begun, waiting."""
        found = Counter(str(row["status"]) for row in self.rows())
        return {name: found[name] for name in (*STATUSES, "begun", "waiting") if found[name]}

    def other_results(self) -> int:
        """How many results in the folder are of no run of this plan, and so in no row: those of earlier
        plans, scene files or versions of Stark. They stay, and are kept by a plan that has their runs."""
        return self._files.others([entry.key for entry in self.runs])

    def run_folder(self, run: str | int) -> Path:
        """The run folder of a run, a recording, by the number or the key that the table has of it."""
        keys = [entry.key for entry in self.runs]
        if not isinstance(run, (bool, str)) and isinstance(run, (int, np.integer)) and 0 <= run < len(keys):
            return self._files.run_folder(keys[run])
        if not isinstance(run, str) or run not in keys:
            raise StudyError(
                f"'{self.folder}': run_folder: run = {run!r}: must be a number in [0, {len(keys)}) or a key, "
                "as in the columns 'run' and 'key' of the table"
            )
        return self._files.run_folder(run)

    def write_csv(self, path: str | PathLike[str] | None = None) -> Path:
        """Writes ``table.csv`` into the folder, or to ``path``."""
        place = self.folder / CSV if path is None else given_path(path, "write_csv: path")
        table.write_csv(place, self.rows())
        return place

    def write_parquet(self, path: str | PathLike[str] | None = None) -> Path:
        """Writes ``table.parquet`` into the folder, or to ``path``; needs pyarrow."""
        place = self.folder / PARQUET if path is None else given_path(path, "write_parquet: path")
        table.write_parquet(place, self.rows())
        return place

    def write_page(self, path: str | PathLike[str] | None = None, *, replays: bool = True) -> Path:
        """Writes ``study.html`` into the folder, or to ``path``: table, plots and pictures in one page. With
        ``replays``, replay pages of runs that have none are written, too."""
        place = resolved(self.folder / PAGE if path is None else given_path(path, "write_page: path"))
        page.write_page(place, self.folder.name, self.rows(), self.run_folder, replays)
        return place

    def resume(
        self,
        *,
        processes: int | None = None,
        ray: str | None = None,
        retry_failed: bool = False,
        on_progress: OnProgress | None = None,
    ) -> Study:
        """Makes the runs that have no result, with ``retry_failed`` also those that did not come to a good
        end, and writes ``table.csv``. ``processes`` on this machine, by default one for each core; or on the
        Ray cluster at the address ``ray``."""
        count = _processes(processes, ray)
        given_task(on_progress, "study: on_progress", _ON_PROGRESS)
        retry_failed = given_flag(retry_failed, "study: retry_failed")
        made = self._tasks()
        lock: FolderLock = self._files.lock()
        try:
            self._files.make_folders()
            waiting = [task for task in made if self._is_open(task, retry_failed)]
            self.made, self.kept = len(waiting), len(made) - len(waiting)
            shares = _Shares(len(made), len(made) - len(waiting), on_progress)
            if ray is None:
                LocalPool(self._files, count, self.plan.limits.retries, shares.set).run(waiting)
            else:
                from .on_ray import run_on_ray

                run_on_ray(self._files, waiting, ray, self.plan.limits.retries, shares.set)
            self.write_csv()
        finally:
            lock.release()
        return self

    def _tasks(self) -> list[Task]:
        """What is to be done. Executes the scene file, to know its options. Raises StudyError where that is
        not the scene of the study."""
        if not self._scene_is_named:
            _require_outside(self.plan.scene, self.folder)
        made = tasks(self.plan, self.folder)
        if [task.key for task in made] != [entry.key for entry in self.runs]:
            raise StudyError(
                f"study '{self.folder}': its scene '{self.plan.scene}' or Stark has changed since: results "
                f"would be of two kinds; run the plan again: stark study run PLAN.toml --out {self.folder}"
            )
        return made

    def _is_open(self, task: Task, retry_failed: bool) -> bool:
        result = self._files.result(task.key)
        if result is not None and retry_failed and result["status"] != "complete":
            self._files.forget(task.key)
            return True
        return result is None


class _Shares:
    """Adds up how far the runs are."""

    def __init__(self, total: int, over: int, on_progress: OnProgress | None) -> None:
        self._total, self._over, self._tell = total, over, on_progress
        self._under_way: dict[str, float] = {}

    def set(self, task: Task, share: float) -> None:
        self._under_way.pop(task.key, None)
        if share >= 1.0:
            self._over += 1
        else:
            self._under_way[task.key] = share
        if self._tell is not None:
            self._tell(self._over, self._total, self._over + sum(self._under_way.values()))


def run(
    plan: Plan | str | PathLike[str],
    out: str | PathLike[str],
    *,
    processes: int | None = None,
    ray: str | None = None,
    on_progress: OnProgress | None = None,
) -> Study:
    """Makes all runs of a plan, given as such or as a file, into the folder ``out``. Results that are there
    already are kept: a plan may be extended. The table is that of this plan; results of runs that it does not
    have stay in the folder (``Study.other_results``). Arguments as those of ``Study.resume``."""
    _processes(processes, ray)
    given_task(on_progress, "study: on_progress", _ON_PROGRESS)
    given = plan if isinstance(plan, Plan) else Plan.read(plan)
    files, scene_file = StudyFolder(out), load(given.scene)
    made = settled(given, scene_file)
    entries = [
        RunEntry(task.key, entry_options(made, task, scene_file), task.repetition)
        for task in tasks(made, files.path, scene_file)
    ]
    files.create(made, entries)
    study = Study(out, scene=made.scene)
    return study.resume(processes=processes, ray=ray, on_progress=on_progress)


def resume(
    folder: str | PathLike[str],
    *,
    scene: str | PathLike[str] | None = None,
    processes: int | None = None,
    ray: str | None = None,
    retry_failed: bool = False,
    on_progress: OnProgress | None = None,
) -> Study:
    """Goes on with the study in ``folder``, see ``Study.resume``."""
    study = Study(folder, scene=scene)
    return study.resume(processes=processes, ray=ray, retry_failed=retry_failed, on_progress=on_progress)


def _processes(processes: int | None, ray: str | None) -> int:
    if ray is not None and (not isinstance(ray, str) or not ray):
        raise InvalidArgument(
            f"study: ray = {ray!r}; must be the address of a Ray cluster, 'auto' or 'local'"
        )
    if processes is None:
        return default_processes()
    if ray is not None:
        raise InvalidArgument(f"study: processes = {processes} and ray = {ray!r}: give one of them")
    if type(processes) is not int or not 1 <= processes <= 1024:
        raise InvalidArgument(f"study: processes = {processes!r}; must be an integer from 1 to 1024")
    return processes


def _with_scene(plan: Plan, scene: str) -> Plan:
    is_file = scene.endswith(".py") or "/" in scene
    return replace(plan, scene=str(Path(scene).resolve()) if is_file else scene)


def _require_outside(scene: str, folder: Path) -> None:
    """A scene file is code: one that came with the study folder is not executed unless the caller names
    it."""
    if scene in names():
        return
    path = Path(scene)
    if not path.is_absolute() or path.resolve().is_relative_to(folder.resolve()):
        raise StudyError(
            f"study '{folder}': names the scene '{printable(scene)}': must be an absolute path outside of "
            f"the study folder; say which scene it is: --scene FILE.py"
        )
