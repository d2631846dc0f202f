"""A run folder belongs to one writer at a time.

The lock is an flock on ``run.lock``, which the system lifts when its process ends in whatever way. What the
file says, process, host and time, is for messages only; a file that a killed process left is taken over."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import socket
import time as clock
import weakref
from contextlib import suppress
from pathlib import Path

from ..array_file import naming
from ..files import printable, require_regular
from .format import LOCK, RecordingError

_LONGEST = 4096  # bytes of the file that are read


class FolderLock:
    """Holds the lock of a folder, which must exist, until ``release()``. Raises RecordingError where somebody
    else has it."""

    def __init__(self, folder: Path) -> None:
        self.path: Path = folder / LOCK
        with naming(self.path):
            descriptor = self._acquire()
        self._release = weakref.finalize(self, _let_go, descriptor, self.path, os.getpid())
        text = {"pid": os.getpid(), "host": socket.gethostname(), "since": _now()}
        with naming(self.path):
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, json.dumps(text).encode() + b"\n", 0)

    def release(self) -> None:
        """Lifts the lock and removes its file."""
        self._release()

    def _acquire(self) -> int:
        """A descriptor of the file that is at the path, locked: its owner removes it when done, and what was
        opened before would lock a file that nobody sees."""
        while True:
            flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
            descriptor = os.open(self.path, flags, 0o644)
            try:
                require_regular(descriptor)
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if _is_at(descriptor, self.path):
                    return descriptor
            except BlockingIOError:
                owner = _owner(descriptor)
                os.close(descriptor)
                raise RecordingError(
                    f"run folder '{self.path.parent}' is in use {owner}: two writers would spoil it; wait "
                    f"for that run or stop it, or choose another folder"
                ) from None
            except OSError as error:
                os.close(descriptor)
                if error.errno in (errno.ENOLCK, errno.ENOTSUP):  # a file system without locks
                    raise RecordingError(
                        f"run folder '{self.path.parent}' cannot be locked: {error.strerror}; choose a "
                        f"folder on a file system with locks"
                    ) from error
                raise
            os.close(descriptor)


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        there = os.stat(path, follow_symlinks=False)
    except FileNotFoundError:
        return False
    return os.path.samestat(os.fstat(descriptor), there)


def _let_go(descriptor: int, path: Path, owner: int) -> None:
    """A forked child of the owner has the descriptor, too, but not the lock."""
    with suppress(OSError):
        if os.getpid() == owner and _is_at(descriptor, path):
            os.unlink(path)
    with suppress(OSError):
        os.close(descriptor)


def _owner(descriptor: int) -> str:
    """Who says to have locked it."""
    try:
        text = json.loads(os.pread(descriptor, _LONGEST, 0))
        return printable(f"by process {text['pid']} on {text['host']} since {text['since']}")
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return "by another process"


def _now() -> str:
    return clock.strftime("%Y-%m-%dT%H:%M:%SZ", clock.gmtime())
