"""PC2 files: positions of the vertices of one mesh over time, as modelling programs keep them. Little-endian:
a header of 32 bytes, then frames of float32 positions."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.files import read_bytes

_HEADER = struct.Struct("<12siiffi")
_SIGNATURE, _VERSION = b"POINTCACHE2\0", 1


@dataclass(frozen=True)
class PointCache:
    """Frames ``start``, ``start + rate``, ..., of positions (k, n, 3) [m]."""

    start: float
    rate: float
    positions: NDArray[Any]


def header(points: int, start: float, rate: float, count: int) -> bytes:
    """What a file begins with: ``count`` frames of ``points``, ``rate`` apart from ``start`` on."""
    return _HEADER.pack(_SIGNATURE, _VERSION, points, start, rate, count)


def read_point_cache(path: Path) -> PointCache:
    """Raises InvalidArgument for files that are missing or damaged."""
    try:
        data = read_bytes(path)
    except OSError as error:
        raise InvalidArgument(
            f"'{path}': {error.strerror or error}: must be a readable point cache"
        ) from None
    if len(data) < _HEADER.size or not data.startswith(_SIGNATURE):
        raise InvalidArgument(f"'{path}' is no PC2 point cache: must begin with POINTCACHE2 and a header")
    _, version, points, start, rate, count = _HEADER.unpack_from(data)
    if version != _VERSION or points < 1 or count < 1 or not (np.isfinite(start) and 0 < rate < np.inf):
        raise InvalidArgument(
            f"'{path}': its header says version {version}, {points} points, {count} frames, {rate:g} apart: "
            f"must be version {_VERSION} with at least one point and one frame, at a rate above 0"
        )
    if len(data) != _HEADER.size + 12 * points * count:
        raise InvalidArgument(
            f"'{path}' has {len(data)} bytes: must have {_HEADER.size + 12 * points * count} for {count} "
            f"frames of {points} points; it was cut off or is damaged"
        )
    rows = np.frombuffer(data, "<f4", offset=_HEADER.size).reshape(count, points, 3)
    return PointCache(start, rate, rows.astype(np.float64))
