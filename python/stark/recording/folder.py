"""The folder of a recording: taken for one recorder, and emptied of an earlier recording or gone on with."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from ..array_file import is_leftover, naming, remove_leftovers
from ..caller import warn
from ..telemetry import _plain
from .format import (
    CERTIFICATE,
    CHECKPOINT,
    FAILURE,
    FIELDS,
    LOCK,
    MADE_LATER,
    MANIFEST,
    PAGE,
    PICTURE,
    STATES,
    TELEMETRY,
    RecordingError,
)
from .lock import FolderLock


def prepare(folder: Path) -> FolderLock:
    """Makes the folder, locks it and removes the recording in it. Raises RecordingError for a folder with
    other things, or that is in use, and WriteError."""
    if folder.exists() and not folder.is_dir():
        raise RecordingError(f"'{folder}' is a file; choose a folder for the recording")
    with naming(folder):
        _require_recording(folder)
        folder.mkdir(parents=True, exist_ok=True)
        lock = FolderLock(folder)
        try:
            _require_recording(folder)
            _empty(folder)
        except BaseException:
            lock.release()
            raise
    return lock


def _require_recording(folder: Path) -> None:
    """A folder that does not exist or is empty will do as well, and what a process left that was killed
    before its first manifest."""
    if not folder.exists() or (folder / MANIFEST).exists():
        return
    for path in folder.iterdir():
        if path.name != LOCK and not is_leftover(path):
            raise RecordingError(
                f"folder '{folder}' is not empty and holds no recording; choose another folder"
            )


def _empty(folder: Path) -> None:
    """The checkpoint goes first: what is left when the process is killed here is not resumed. The manifest
    stays until it is replaced: the folder is known as that of a recording."""
    for name in (CHECKPOINT, CERTIFICATE, TELEMETRY, PAGE, PICTURE):
        (folder / name).unlink(missing_ok=True)
    for name in ("frames", STATES, FIELDS, FAILURE):
        _remove_folder(folder / name)
    remove_leftovers(folder)
    if kept := [name for name in MADE_LATER if (folder / name).exists()]:
        warn(
            f"'{folder}' keeps what was made of its earlier recording: {', '.join(kept)}; remove it, or make "
            f"it again of the new one, or record into another folder"
        )


def tidy(folder: Path) -> None:
    """Before a recording goes on: what a killed process left, and the failed step, which is taken again."""
    for part in (folder, folder / "frames", folder / STATES, folder / FIELDS):
        remove_leftovers(part)
    _remove_folder(folder / FAILURE)


def _remove_folder(folder: Path) -> None:
    """With what is in it; a link alone, not what it leads to."""
    if folder.is_symlink():
        folder.unlink()
    shutil.rmtree(folder, ignore_errors=True)


def drop_chunks_after(folder: Path, count: int) -> None:
    """Removes chunks that a recording no longer has."""
    for path in folder.glob("chunk_*.npz"):
        number = re.fullmatch(r"chunk_(\d{6,})\.npz", path.name)
        if number and int(number[1]) >= count:
            path.unlink(missing_ok=True)


def require_same_settings(
    folder: str | PathLike[str], before: Mapping[str, Any], now: Mapping[str, Any]
) -> None:
    """Claims of a certificate are about one set of settings."""
    plain = _plain(dict(now))
    changed = [
        name for name in plain if before.get(name) != plain[name] and not name.startswith("execution.")
    ]
    if changed:
        raise RecordingError(
            f"'{folder}' was recorded for certification: settings must stay as they were, {changed[0]} = "
            f"{before.get(changed[0])}; resume it without changes, or run the scene anew"
        )
