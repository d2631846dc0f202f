"""The folder of a study: the plan, a folder for each run and a file for each result.

    study.json            the plan, and the keys and options of its runs
    runs/KEY/             run folders, as those of ``stark run``
    results/KEY.json      what a run came to; there when the run is over, and never half-written
    attempts/KEY          a line for each time a run was begun

A folder may come from others: nothing is written through a link, and no file is read that is no file or too
large."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Collection
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from .._core import InvalidArgument
from ..arguments import given_path
from ..array_file import is_leftover, make_folder, naming, refuse_link, write_atomically
from ..files import printable, read_bytes, resolved
from ..recording.format import LOCK
from ..recording.lock import FolderLock
from .plan import Limits, Plan
from .sampling import Value

MANIFEST, RUNS, RESULTS, ATTEMPTS = "study.json", "runs", "results", "attempts"
FORMAT, VERSION = "stark-study", 1

#: Largest result and largest plan that are read [bytes].
LARGEST_RESULT, LARGEST_MANIFEST = 1 << 24, 1 << 26

#: How a run may end. ``wrong``: its check failed; ``failed``: a step did; ``error``: an exception.
STATUSES = ("complete", "wrong", "failed", "error", "timed_out", "crashed")

_KEY = re.compile(r"[0-9a-f]{20}")
_ITEMS = {"options": (bool, int, float, str), "observables": (float,), "measured": (float,)}
_MEASURED = ("observables", "measured")
_COUNTS = ("steps", "rejected_steps", "newton_iterations", "max_contacts")


class StudyError(InvalidArgument):
    """A study folder that cannot be used: names it, the defect and a remedy."""


@dataclass(frozen=True)
class RunEntry:
    """A run of a study, as ``study.json`` has it."""

    key: str
    options: dict[str, Value]
    repetition: int


class StudyFolder:
    """Paths and files of a study."""

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path: Path = resolved(given_path(path, "study: folder"))

    def create(self, plan: Plan, runs: list[RunEntry]) -> None:
        """Makes the folder, or gives one that holds a study this plan: results of earlier plans stay."""
        others = self.path.is_dir() and any(
            path.name != LOCK and not is_leftover(path) for path in self.path.iterdir()
        )
        if others and not (self.path / MANIFEST).exists():
            raise StudyError(f"folder '{self.path}' is not empty and holds no study; choose another folder")
        if self.path.exists() and not self.path.is_dir():
            raise StudyError(f"'{self.path}' is a file; choose a folder for the study")
        with naming(self.path):
            self.path.mkdir(parents=True, exist_ok=True)
        header: dict[str, Any] = {"format": FORMAT, "version": VERSION, "plan": asdict(plan)}
        header["runs"] = [asdict(entry) for entry in runs]
        text = json.dumps(header, indent=1).encode()
        lock = self.lock()  # not while somebody else makes runs
        try:
            write_atomically(self.path / MANIFEST, lambda file: file.write(text))
            self.make_folders()
        finally:
            lock.release()

    def make_folders(self) -> None:
        for name in (RUNS, RESULTS, ATTEMPTS):
            make_folder(self.path / name)

    def lock(self) -> FolderLock:
        """Keeps other studies out until it is released."""
        return FolderLock(self.path)

    def read(self) -> tuple[Plan, list[RunEntry]]:
        """The plan of the study and its runs. Raises StudyError."""
        if self.path.is_file():
            raise StudyError(_no_folder(self.path))
        try:
            text = json.loads(read_bytes(self.path / MANIFEST, LARGEST_MANIFEST))
            if text["format"] != FORMAT or text["version"] != VERSION:
                raise ValueError(f"format {text['format']!r} {text['version']!r} is not {FORMAT} {VERSION}")
            return _plan(text["plan"]), [_entry(given) for given in text["runs"]]
        except FileNotFoundError:
            raise StudyError(f"'{self.path}' is not a study folder: it has no {MANIFEST}") from None
        except (OSError, ValueError, KeyError, TypeError, RecursionError, InvalidArgument) as error:
            raise StudyError(
                f"study '{self.path}': its {MANIFEST} is damaged ({printable(str(error))}); run the plan "
                f"anew, which keeps results: stark study run PLAN.toml --out {self.path}"
            ) from error

    def run_folder(self, key: str) -> Path:
        return self.path / RUNS / key

    def safe_run_folder(self, key: str) -> Path:
        """The folder of a run to write in. Raises WriteError where it leads elsewhere."""
        refuse_link(self.path / RUNS)
        folder = self.run_folder(key)
        refuse_link(folder)
        return folder

    def begin(self, key: str) -> int:
        """Notes that a run is begun; returns the how manyth time it is."""
        folder = self.path / ATTEMPTS
        make_folder(folder)
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
        with naming(folder / key):
            descriptor = os.open(folder / key, flags, 0o644)
            try:
                os.write(descriptor, b".")
                return os.fstat(descriptor).st_size
            finally:
                os.close(descriptor)

    def attempts(self, key: str) -> int:
        try:
            return os.stat(self.path / ATTEMPTS / key, follow_symlinks=False).st_size
        except OSError:
            return 0

    def write_result(self, key: str, result: dict[str, Any]) -> None:
        folder = self.path / RESULTS
        make_folder(folder)
        stored = {**result, **{name: _with_nulls(result[name]) for name in _MEASURED}}
        text = json.dumps(stored, sort_keys=True, allow_nan=False).encode()
        write_atomically(folder / f"{key}.json", lambda file: file.write(text))

    def result(self, key: str) -> dict[str, Any] | None:
        """What a run came to; None while it is not over. A file that is no result counts as none."""
        if not _KEY.fullmatch(key) or (self.path / RESULTS).is_symlink():
            return None
        path = self.path / RESULTS / f"{key}.json"
        try:
            if path.is_symlink():
                return None
            result = json.loads(read_bytes(path, LARGEST_RESULT))
            result.update({name: _with_nans(result[name]) for name in _MEASURED})
            return result if _is_result(result, key) else None
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            return None

    def others(self, keys: Collection[str]) -> int:
        """How many results there are of other runs: of earlier plans, scene files or versions of Stark."""
        place = self.path / RESULTS
        if place.is_symlink() or not place.is_dir():
            return 0
        found = {path.stem for path in place.glob("*.json") if _KEY.fullmatch(path.stem)}
        return len(found - set(keys))

    def forget(self, key: str) -> None:
        """Makes a run be made again."""
        make_folder(self.path / RESULTS)
        (self.path / RESULTS / f"{key}.json").unlink(missing_ok=True)


def _no_folder(path: Path) -> str:
    """What to say of a file that is given as a study."""
    if path.suffix == ".toml":
        return (
            f"'{path}' is a file, not the folder of a study; if it is a plan, make or go on with its study "
            f"by stark study run {path}, or give the folder that it was made in: out/{path.stem}"
        )
    if path.name == MANIFEST:
        return f"'{path}' is a file of a study; give its folder, '{path.parent}'"
    return f"'{path}' is a file, not the folder of a study; give the folder"


def _with_nulls(numbers: dict[str, float]) -> dict[str, float | None]:
    """JSON has no NaN; nor infinite numbers, which no result has."""
    return {name: value if math.isfinite(value) else None for name, value in numbers.items()}


def _with_nans(numbers: dict[str, float | None]) -> dict[str, float]:
    return {name: math.nan if value is None else value for name, value in numbers.items()}


def _plan(given: dict[str, Any]) -> Plan:
    """Raises KeyError, TypeError, ValueError or PlanError for what a study never writes."""
    plan = Plan(**{**given, "limits": Limits(**given["limits"])})
    kinds = {"scene": str, "samples": list, "settings": dict, "repetitions": int, "repetition_option": str}
    for name, kind in kinds.items():
        if not isinstance(getattr(plan, name), kind):
            raise TypeError(f"{name} must be of type {kind.__name__}")
    for sample in plan.samples:
        _require_items(sample, _ITEMS["options"])
    numbers = (plan.fps, plan.checkpoint_every, plan.until, plan.limits.time_out)
    if not all(value is None or isinstance(value, (int, float)) for value in numbers):
        raise TypeError("fps, checkpoint_every, until and time_out must be numbers")
    if type(plan.certify) is not bool:
        raise TypeError("certify must be true or false")
    if type(plan.limits.retries) is not int or type(plan.repetitions) is not int:
        raise TypeError("retries and repetitions must be integers")
    return plan


def _entry(given: dict[str, Any]) -> RunEntry:
    entry = RunEntry(**given)
    if not _KEY.fullmatch(entry.key) or type(entry.repetition) is not int:
        raise ValueError("runs: key must be a hash, and repetition an integer")
    _require_items(entry.options, _ITEMS["options"])
    return entry


def _require_items(table: Any, kinds: tuple[type, ...]) -> None:
    if not isinstance(table, dict) or not all(isinstance(value, kinds) for value in table.values()):
        raise TypeError(f"must be a table of {' or '.join(kind.__name__ for kind in kinds)}")


def _is_result(result: Any, key: str) -> bool:
    """Whether it has all that a result has, of the right types."""
    for name, kinds in _ITEMS.items():
        _require_items(result[name], kinds)
    good = result["key"] == key and result["status"] in STATUSES
    good &= all(isinstance(result[name], str) for name in ("message", "state_hash", "host"))
    good &= all(type(result[name]) is int for name in _COUNTS)
    return good and all(type(result[name]) is float for name in ("simulated", "wall", "cpu"))
