"""PNG files of 8-bit RGB pictures with nothing but zlib. [ISO/IEC 15948]"""

from __future__ import annotations

import struct
import zlib
from os import PathLike
from pathlib import Path

import numpy as np

from .._core import InvalidArgument
from ..arguments import as_array, given_path
from ..array_file import write_atomically
from ..files import read_bytes

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
#: Suffixes of pictures that are not PNG: a file with one of them could not be opened.
_OTHERS = (".jpg", ".jpeg", ".webp", ".gif", ".bmp", ".tif", ".tiff", ".svg", ".pdf")


def png_path(path: object, what: str) -> Path:
    """The path of a picture. Raises InvalidArgument where its suffix promises another format."""
    target = given_path(path, what)
    if target.suffix.lower() in _OTHERS:
        name = target.with_suffix(".png").name
        raise InvalidArgument(f"{what} = '{target}': must be a PNG file; name it '{name}'")
    return target


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_bytes(picture: np.ndarray) -> bytes:
    """A (height, width, 3) uint8 picture as PNG; each row is stored as differences to the row above."""
    picture = as_array(picture, "picture")
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3 or not picture.size:
        raise InvalidArgument(
            f"picture has shape {picture.shape} and type {picture.dtype}; must be (h, w, 3) uint8"
        )
    height, width = picture.shape[:2]
    rows = picture.reshape(height, -1)
    up = np.diff(rows, axis=0, prepend=np.zeros_like(rows[:1]))  # uint8 differences wrap, as filter 2 asks
    filtered = np.concatenate([np.full((height, 1), 2, dtype=np.uint8), up], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        _SIGNATURE
        + _chunk(b"IHDR", header)
        + _chunk(b"IDAT", zlib.compress(filtered.tobytes(), 6))
        + _chunk(b"IEND", b"")
    )


def write_png(path: str | PathLike[str], picture: np.ndarray) -> None:
    """Writes a (height, width, 3) uint8 picture. Raises InvalidArgument for a name like "a.jpg"."""
    target = png_path(path, "write_png: path")
    data = png_bytes(picture)
    write_atomically(target, lambda file: file.write(data))


def read_png(path: str | PathLike[str]) -> np.ndarray:
    """Reads a picture that ``write_png`` wrote; (height, width, 3) uint8."""
    file = given_path(path, "read_png: path")
    try:
        data = read_bytes(file)
    except OSError as error:
        raise InvalidArgument(
            f"read_png: '{file}': {error.strerror or error}: must be a readable picture"
        ) from None
    if data[:8] != _SIGNATURE:
        raise InvalidArgument(f"'{path}' is not a PNG file")
    try:
        rows, height, width = _rows(data, file)
    except InvalidArgument:
        raise
    except (struct.error, zlib.error, ValueError) as error:
        raise InvalidArgument(f"read_png: '{file}' is damaged: {error}; write it again") from None
    if np.any(rows[:, 0] != 2):
        raise InvalidArgument(f"'{path}' was not written by Stark: it uses other row filters")
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(height, width, 3)


def _rows(data: bytes, path: Path) -> tuple[np.ndarray, int, int]:
    """Rows with their filters, height and width, of the bytes of a PNG file."""
    at, body, width, height = 8, b"", 0, 0
    while at < len(data):
        (length,), kind = struct.unpack_from(">I", data, at), data[at + 4 : at + 8]
        content = data[at + 8 : at + 8 + length]
        if struct.unpack_from(">I", data, at + 8 + length)[0] != zlib.crc32(kind + content):
            raise InvalidArgument(f"'{path}': block {kind.decode('ascii', 'replace')} is damaged")
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack_from(">IIBB", content)
            if (depth, color) != (8, 2):
                raise InvalidArgument(f"'{path}': only 8-bit RGB pictures are read")
        elif kind == b"IDAT":
            body += content
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(body), dtype=np.uint8).reshape(height, 1 + 3 * width)
    return rows, height, width
