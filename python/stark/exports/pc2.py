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

_MOST_FRAMES = 100  # for a shot
_EVEN = 1e-3  # by which times may miss those of even frames, over the time between two of them


class Pc2Writer:
    """Writes ``fall_cape.pc2`` and so on for ``fall.pc2``, with ``fps`` frames a second. Frames of a cache
    follow each other at equal times: shots at others are interpolated, as modelling programs do it."""

    def __init__(self, path: Path, fps: float) -> None:
        self._path, self._fps = path, fps
        self._times: list[float] = []
        self._names: list[str] = []
        self._frames: list[list[bytes]] = []

    def add(self, shot: Shot) -> None:
        """Takes note of a time."""
        moving = [body for body in shot.bodies if body.motion != "fixed"]
        self._times.append(shot.time)
        if len(self._times) == 1:
            self._names, self._frames = [body.name for body in moving], [[] for _ in moving]
        for frames, body in zip(self._frames, moving, strict=True):
            frames.append(np.ascontiguousarray(body.positions, dtype="<f4").tobytes())

    def finish(self) -> list[Path]:
        """Writes the files."""
        start, step, places = self._even()
        files: list[Path] = []
        for name, frames in zip(self._names, self._frames, strict=True):
            file = self._path.with_name(f"{self._path.stem}_{plain_name(name, 'body')}.pc2")
            stem, count = file.stem, 1
            while file in files:
                count += 1
                file = file.with_name(f"{stem}_{count}.pc2")
            rate = step * self._fps if step > 0.0 else 1.0
            head = header(len(frames[0]) // 12, start * self._fps, rate, len(places))
            _write(file, head + b"".join(_at(frames, place) for place in places))
            files.append(file)
        return files

    def abandon(self) -> None:
        """Nothing has been written yet."""

    def _even(self) -> tuple[float, float, list[float]]:
        """The first of frames at equal times and the time between them [s], and where each is among the
        shots: 1.5 is half-way between the second and the third. The last frame is at the last shot, or by
        less than the time between two frames before it. Raises InvalidArgument if they would be too many."""
        times = self._times
        if len(times) < 2:
            return (times[0] if times else 0.0), 0.0, [float(k) for k in range(len(times))]
        step = times[1] - times[0]
        if np.abs(np.diff(times) - step).max() <= _EVEN * step:
            return times[0], step, [float(k) for k in range(len(times))]
        step = float(np.median(np.diff(times)))
        count = int((times[-1] - times[0]) / step + _EVEN) + 1
        if count > _MOST_FRAMES * len(times):
            raise InvalidArgument(
                f"export '{self._path}': frames at equal times would be {count} of {len(times)} records, "
                f"most of which are {step:.3g} s apart: must be at most {_MOST_FRAMES} for a record; record "
                f"at equal times"
            )
        frames = times[0] + step * np.arange(count)
        return times[0], step, [float(place) for place in np.interp(frames, times, np.arange(len(times)))]


def _at(frames: list[bytes], place: float) -> bytes:
    before = int(place)
    share = place - before
    if share == 0.0:
        return frames[before]
    one, other = (np.frombuffer(frames[k], "<f4").astype(float) for k in (before, before + 1))
    return bytes((one + share * (other - one)).astype("<f4"))


def _write(file: Path, data: bytes) -> None:
    write_atomically(file, lambda out: out.write(data))
