"""Opening files that others may have made: pipes, links and sizes are looked at before anything is read, and
text is made fit for a terminal before it is shown.

A path that a file names, or a folder that was copied from somewhere, may hold a pipe that never ends, a link
to a file of the user, or characters that a terminal obeys. What opens such files goes through here."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

#: Largest JSON file that is read, a manifest or the description of a scene [bytes].
LARGEST_TEXT = 1 << 28

#: Longest line of a file of lines [bytes].
LONGEST_LINE = 1 << 24


class NotAFile(OSError):  # noqa: N818 (says what it is)
    """What is there is a folder, a pipe, a device or a socket; or it is too large for what it should be."""


def open_regular(path: str | os.PathLike[str]) -> BinaryIO:
    """Opens a regular file for reading. Raises NotAFile for pipes and devices, instead of waiting for them,
    and the OSError of the system for the rest."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        require_regular(descriptor)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def require_regular(descriptor: int) -> None:
    """Raises NotAFile for an open descriptor that is no regular file."""
    mode = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a device, pipe or socket"
        raise NotAFile(errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL, f"it is {what}, not a file")


def read_bytes(path: str | os.PathLike[str], limit: int | None = None) -> bytes:
    """All of a regular file of at most ``limit`` bytes."""
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        if limit is not None and size > limit:
            raise NotAFile(errno.EFBIG, f"it has {size} bytes, more than {limit}")
        return file.read()


def read_text(path: str | os.PathLike[str]) -> str:
    """A JSON file as text. Raises OSError, and UnicodeDecodeError if it is not text."""
    return read_bytes(path, LARGEST_TEXT).decode("utf-8")


def resolved(path: Path) -> Path:
    """The same place whatever the current folder will be. Links stay as they are named."""
    return Path(os.path.abspath(path))


def plain_name(text: str, otherwise: str) -> str:
    """A text from a file as part of the name of a file: one that leads to no other folder."""
    name = "".join(c if c.isalnum() or c in "_-.+ " else "_" for c in text).strip(" .")
    return name[:100] or otherwise


def printable(text: str) -> str:
    """A text without what a terminal obeys: control characters, escapes, marks of direction. Lines stay."""
    return "".join(c if c.isprintable() or c == "\n" else _escaped(c) for c in text)


def _escaped(character: str) -> str:
    return character.encode("unicode_escape", "backslashreplace").decode("ascii")
