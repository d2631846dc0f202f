"""What kill -9 leaves of a folder at any moment: copies of it, taken before each operation of the process on
its files. Python tells of these by itself (sys.addaudithook), so no operation is forgotten."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

#: Content of all files by path; None for folders.
Snapshot = dict[str, bytes | None]

_EVENTS = {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate", "os.link", "os.symlink"}
_watched: list[tuple[Path, list[Snapshot]]] = []
_installed = False


def snapshot(folder: Path) -> Snapshot:
    return {
        str(p.relative_to(folder)): None if p.is_dir() else p.read_bytes() for p in sorted(folder.rglob("*"))
    }


def restore(content: Snapshot, folder: Path) -> Path:
    folder.mkdir(parents=True)
    for name, data in content.items():
        if data is None:
            (folder / name).mkdir(exist_ok=True)
        else:
            (folder / name).write_bytes(data)
    return folder


@contextmanager
def every_moment(folder: Path) -> Iterator[list[Snapshot]]:
    """The states that a folder is in while the block runs, in order, each once."""
    global _installed
    if not _installed:  # hooks cannot be removed
        sys.addaudithook(_before)
        _installed = True
    moments: list[Snapshot] = []
    _watched.append((folder, moments))
    try:
        yield moments
        moments.append(snapshot(folder))
    finally:
        _watched.clear()


def _before(event: str, arguments: tuple[object, ...]) -> None:
    if not _watched or event not in _EVENTS:
        return
    folder, moments = _watched.pop()  # copying is no operation to be watched
    try:
        paths = [os.fsdecode(a) for a in arguments if isinstance(a, (str, bytes, os.PathLike))]
        if any(path.startswith(str(folder)) for path in paths) and folder.is_dir():
            now = snapshot(folder)
            if not moments or now != moments[-1]:
                moments.append(now)
    finally:
        _watched.append((folder, moments))
