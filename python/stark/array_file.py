"""Files of named arrays that others may have written, cut off or changed: NPZ, read with every size checked
before memory is taken for it.

``numpy.load`` trusts the shapes that a file claims and fails in many ways on others. Here a file gives its
arrays or a ``DamageError``, and never takes more memory than a few times its own size."""

from __future__ import annotations

import errno
import math
import os
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ._core import Error
from .files import open_regular

if TYPE_CHECKING:
    import zipfile

Array = NDArray[np.generic]

#: Longest header of an array in bytes; those of the arrays that are written have 128.
_LONGEST_HEADER = 4096
#: Header of an array as NumPy writes it, version 1.0 [numpy.lib.format].
_HEADER = re.compile(
    rb"\{'descr': '(?P<type>[<|][biuf][1248])', 'fortran_order': (?P<fortran>True|False), "
    rb"'shape': \((?P<shape>(?:\d{1,18}, ?)*(?:\d{1,18})?)\), \} *\n"
)
_MAGIC = b"\x93NUMPY\x01\x00"
#: Members of an archive that are not compressed [zipfile.ZIP_STORED].
_STORED = 0
#: Characters of what is said of damage.
_LONGEST = 300


class DamageError(ValueError):
    """What is wrong with a file, without its name."""


class WriteError(Error, OSError):
    """A file or folder that cannot be written: names it, the reason and a remedy; ``errno`` is that of the
    system."""


#: Errors of a disk, not of what was asked for.
DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
_REMEDIES = {
    errno.ENOSPC: "make room, or choose another disk",
    errno.EDQUOT: "make room, or choose another disk",
    errno.ENOENT: "choose a folder that exists and takes files",
}


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Turns what goes wrong with writing ``path`` into a WriteError."""
    try:
        yield
    except WriteError:
        raise
    except OSError as error:
        reason, remedy = error.strerror or str(error), _REMEDIES.get(error.errno or 0, "choose another place")
        named = WriteError(f"'{path}' cannot be written: {reason}; {remedy}")
        named.errno = error.errno
        raise named from error


def refuse_special(path: Path) -> None:
    """Raises WriteError for what exists and is no regular file: moving one into its place would do away with
    a device, a pipe or a socket that others use."""
    if path.exists() and not path.is_file():
        what = "a folder" if path.is_dir() else "a device, pipe or socket"
        refused = WriteError(f"'{path}' cannot be written: it is {what}, not a file; choose another name")
        refused.errno = errno.EISDIR if path.is_dir() else errno.EEXIST
        raise refused


def refuse_link(folder: Path) -> None:
    """Raises WriteError for a folder within a run folder that is a link: what is written there would come to
    lie somewhere else."""
    if folder.is_symlink():
        refused = WriteError(
            f"'{folder}' cannot be written: it is a link that leads out of its folder; remove it, or choose "
            f"another folder"
        )
        refused.errno = errno.ELOOP
        raise refused


def make_folder(folder: Path) -> None:
    """A folder within a run folder, and no link to another."""
    with naming(folder):
        refuse_link(folder)
        folder.mkdir(parents=True, exist_ok=True)


def read_arrays(path: Path) -> dict[str, Array]:
    """All arrays of an NPZ file by name. Raises FileNotFoundError, or DamageError for everything else."""
    import zipfile  # half of the time that the import of this module would take

    try:
        with open_regular(path) as file, zipfile.ZipFile(file) as archive:
            members = archive.infolist()
            _check_sizes(members, os.fstat(file.fileno()).st_size)
            return {member.filename.removesuffix(".npy"): _read(archive, member) for member in members}
    except (FileNotFoundError, DamageError):
        raise
    except Exception as error:  # the decoder meets damage in ways that have no common base
        # The error of an archive whose directory is damaged quotes a name of up to 64 kB.
        raise DamageError(f"{type(error).__name__}: {error}"[:_LONGEST]) from error


def check_format(header: Any, noun: str, name: str, version: int) -> dict[str, Any]:
    """The header of a file if it is one of this format and version. Raises DamageError for others."""
    if not isinstance(header, dict) or header.get("format") != name:
        raise DamageError(f"is no {noun} of Stark (format must be '{name}')")
    if header.get("version") != version:
        raise DamageError(
            f"has format version {header.get('version')!r}; this Stark reads {version}: use "
            f"the Stark that wrote it ({header.get('stark_version')!r})"
        )
    return header


def write_arrays(path: Path, arrays: Mapping[str, Array]) -> None:
    """Writes an NPZ file, whole or not at all. Equal arrays make equal files."""
    write_atomically(path, lambda file: np.savez(file, **arrays))  # type: ignore[arg-type]


def write_atomically(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Calls ``write`` with a file beside ``path`` and moves it into place only when all of it is on disk. A
    link is replaced, never followed. Raises WriteError, also if the place is not that of a file."""
    with naming(path):
        refuse_special(path)
        temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
        try:
            temporary.unlink(missing_ok=True)
            with open(temporary, "xb") as file:
                write(file)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        finally:
            with suppress(OSError):  # where it could not be made, it cannot be removed either
                temporary.unlink(missing_ok=True)


def remove_leftovers(folder: Path) -> None:
    """Removes what write_atomically() left half-written in a folder when its process was killed."""
    for path in folder.glob(".*.tmp"):
        if is_leftover(path):
            path.unlink(missing_ok=True)


def is_leftover(path: Path) -> bool:
    """Whether write_atomically() gives such a name to a file that it has not moved into place."""
    return re.fullmatch(r"\..+\.\d+\.tmp", path.name) is not None


def _check_sizes(members: list[zipfile.ZipInfo], file_size: int) -> None:
    names = [member.filename for member in members]
    if len(set(names)) < len(names):
        raise DamageError("an array occurs twice")
    for member in members:
        if not member.filename.endswith(".npy"):
            raise DamageError(f"'{member.filename[:80]}' is not an array")
        if member.compress_type != _STORED or member.compress_size != member.file_size:
            raise DamageError(f"array '{member.filename[:80]}' is compressed; arrays are stored as they are")
    if sum(member.file_size for member in members) > file_size:
        raise DamageError("arrays claim to be larger than the file")


def _read(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Array:
    data = archive.read(member)  # compares the CRC-32
    name = member.filename[:80]
    start = len(_MAGIC) + 2
    if not data.startswith(_MAGIC) or len(data) < start:
        raise DamageError(f"'{name}' is not an array of NumPy's format 1.0")
    end = start + int.from_bytes(data[start - 2 : start], "little")
    header = _HEADER.fullmatch(data[start:end]) if end - start <= _LONGEST_HEADER else None
    if header is None:
        raise DamageError(f"'{name}' has a header that is not one of plain numbers")
    dtype = np.dtype(header["type"].decode())
    shape = tuple(int(extent) for extent in header["shape"].replace(b" ", b"").split(b",") if extent)
    if math.prod(shape) * dtype.itemsize != len(data) - end:
        raise DamageError(f"'{name}' claims the shape {shape}, which is not what it holds")
    flat = np.frombuffer(data, dtype=dtype, offset=end).copy()
    return flat.reshape(shape[::-1]).T if header["fortran"] == b"True" else flat.reshape(shape)
