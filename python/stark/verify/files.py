"""Reading files that others may have made: no pipes, no sizes that a file only claims, nothing that a
terminal obeys."""

from __future__ import annotations

import ast
import hashlib
import json
import math
import os
import stat
import zipfile
import zlib
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO, Literal

import numpy as np

LARGEST_JSON = 1 << 28  # bytes
LONGEST_LINE = 1 << 24  # bytes
#: Characters of what is said of damage.
_LONGEST = 300
_LONGEST_NAME = 255  # of one file or folder [bytes]
_LONGEST_HEADER = 4096  # bytes
_MAGIC = b"\x93NUMPY\x01\x00"


class UnreadableRecording(ValueError):  # noqa: N818 (says what happened)
    """A recording that cannot be checked: names the file and the defect."""


def need(holds: bool, message: str) -> None:
    if not holds:
        raise UnreadableRecording(message)


def as_path(value: Any, what: str) -> Path:
    """A path, which need not exist."""
    try:
        text = os.fspath(value)
        usable = isinstance(text, str) and bool(text) and b"\0" not in os.fsencode(text)
        usable = usable and all(len(name) <= _LONGEST_NAME for name in os.fsencode(text).split(b"/"))
    except (TypeError, UnicodeEncodeError):
        usable = False
    need(usable, f"{what} = {value!r}: must be a path: a non-empty text or a pathlib.Path")
    return Path(value)


def open_file(path: Path) -> BinaryIO:
    """Opens a regular file. OSError for all others, without waiting for what a pipe may bring."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError("it is a folder, device, pipe or socket, not a file")
    return os.fdopen(descriptor, "rb")


def read_json(path: Path) -> dict[str, Any]:
    try:
        with open_file(path) as file:
            size = os.fstat(file.fileno()).st_size
            need(size <= LARGEST_JSON, f"'{path}' is damaged: it has more than {LARGEST_JSON} bytes")
            data = file.read()
        value = json.loads(data.decode("utf-8"))
    except FileNotFoundError:
        raise UnreadableRecording(f"'{path}' is missing") from None
    except UnreadableRecording:
        raise
    except (OSError, ValueError, RecursionError) as error:
        raise UnreadableRecording(f"'{path}' is damaged: {error}") from error
    need(isinstance(value, dict), f"'{path}' must be a JSON object")
    read: dict[str, Any] = value
    return read


def read_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Lines with their ends, by number from 1; the last one may lack it."""
    try:
        with open_file(path) as file:
            number = 0
            while line := file.readline(LONGEST_LINE):
                number += 1
                need(len(line) < LONGEST_LINE, f"'{path}' line {number} has more than {LONGEST_LINE} bytes")
                yield number, line
    except OSError as error:
        raise UnreadableRecording(f"'{path}' cannot be read: {error}") from error


def read_npz(path: Path) -> dict[str, np.ndarray]:
    """All arrays of a file; none takes more memory than the file is large."""
    try:
        with open_file(path) as file, zipfile.ZipFile(file) as archive:
            members = archive.infolist()
            size = os.fstat(file.fileno()).st_size
            stored = all(m.compress_type == zipfile.ZIP_STORED for m in members)
            need(stored, f"'{path}' is damaged or cut off (arrays must be stored without compression)")
            fits = sum(m.file_size for m in members) <= size
            need(fits, f"'{path}' is damaged or cut off (arrays claim to be larger than the file)")
            return {m.filename.removesuffix(".npy"): _array(archive.read(m), m.filename) for m in members}
    except FileNotFoundError:
        raise UnreadableRecording(f"'{path}' is missing") from None
    except UnreadableRecording:
        raise
    except (
        OSError,
        ValueError,
        EOFError,
        LookupError,
        TypeError,
        SyntaxError,
        RuntimeError,
        MemoryError,
        NotImplementedError,
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        # The error of an archive whose directory is damaged quotes a name of up to 64 kB.
        raise UnreadableRecording(f"'{path}' is damaged or cut off ({str(error)[:_LONGEST]})") from error


def _array(data: bytes, name: str) -> np.ndarray:
    """An array of NumPy's format 1.0, of plain numbers."""
    start = len(_MAGIC) + 2
    end = start + int.from_bytes(data[start - 2 : start], "little")
    if not data.startswith(_MAGIC) or end - start > _LONGEST_HEADER:
        raise ValueError(f"'{name[:80]}' is not an array of NumPy's format 1.0")
    dtype, shape, is_fortran = _header(data[start:end])
    count = math.prod(shape)
    plain = dtype.kind in "biuf" and all(extent >= 0 for extent in shape)
    if not plain or count * dtype.itemsize != len(data) - end:
        raise ValueError(f"'{name[:80]}' claims the shape {shape} of {dtype}, which is not what it holds")
    order: Literal["C", "F"] = "F" if is_fortran else "C"
    return np.frombuffer(data, dtype=dtype, offset=end).reshape(shape, order=order).copy()


@lru_cache(maxsize=64)  # those of the bodies of a scene are much the same
def _header(text: bytes) -> tuple[np.dtype[Any], tuple[int, ...], bool]:
    """Type, shape and whether the first index is the fastest."""
    header = ast.literal_eval(text.decode("ascii"))
    shape = tuple(int(extent) for extent in header["shape"])
    return np.dtype(str(header["descr"])), shape, bool(header["fortran_order"])


def file_digest(path: Path) -> str:
    try:
        with open_file(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()  # type: ignore[arg-type]
    except OSError as error:
        raise UnreadableRecording(f"'{path}' cannot be read: {error}") from error


def printable(text: str) -> str:
    """A text for a terminal: other characters than plain ones are written as their numbers."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)
