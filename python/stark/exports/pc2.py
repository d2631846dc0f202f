"""PC2 point caches: a file for each body that moves, for modifiers of modelling programs, which put the
positions on a mesh of their own: materials and texture coordinates stay."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stark._core import InvalidArgument
from stark.array_file import write_atomically
from stark.files import plain_name
from stark.point_cache import header

from .shots import Shot

_EVEN = 1e-3  # by which steps between shots may differ, over the first one


class Pc2Writer:
    """Writes ``fall_cape.pc2`` and so on for ``fall.pc2``, with ``fps`` frames a second."""

    def __init__(self, path: Path, fps: float) -> None:
        self._path, self._fps = path, fps
        self._times: list[float] = []
        self._names: list[str] = []
        self._frames: list[list[bytes]] = []

    def add(self, shot: Shot) -> None:
        """Takes note of a time. Raises InvalidArgument where steps are uneven."""
        moving = [body for body in shot.bodies if body.motion != "fixed"]
        self._times.append(shot.time)
        if len(self._times) == 1:
            self._names, self._frames = [body.name for body in moving], [[] for _ in moving]
        if len(self._times) > 2:
            first, last = self._times[1] - self._times[0], self._times[-1] - self._times[-2]
            if abs(last - first) > _EVEN * first:
                raise InvalidArgument(
                    f"export '{self._path}': the record at {shot.time:.6g} s comes {last:.6g} s after the "
                    f"one before, the second one {first:.6g} s after the first: frames of a point cache "
                    f"must be evenly spaced; record at equal times"
                )
        for frames, body in zip(self._frames, moving, strict=True):
            frames.append(np.ascontiguousarray(body.positions, dtype="<f4").tobytes())

    def finish(self) -> list[Path]:
        """Writes the files."""
        rate = (self._times[1] - self._times[0]) * self._fps if len(self._times) > 1 else 1.0
        start = self._times[0] * self._fps if self._times else 0.0
        files: list[Path] = []
        for name, frames in zip(self._names, self._frames, strict=True):
            file = self._path.with_name(f"{self._path.stem}_{plain_name(name, 'body')}.pc2")
            stem, count = file.stem, 1
            while file in files:
                count += 1
                file = file.with_name(f"{stem}_{count}.pc2")
            _write(file, header(len(frames[0]) // 12, start, rate, len(frames)) + b"".join(frames))
            files.append(file)
        return files

    def abandon(self) -> None:
        """Nothing has been written yet."""


def _write(file: Path, data: bytes) -> None:
    write_atomically(file, lambda out: out.write(data))
