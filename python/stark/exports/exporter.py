"""Writes results while a simulation runs, or from a recording. A file is written whole or not at all: under
another name first, then moved into place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

from stark._core import InvalidArgument
from stark.arguments import given_path, is_iterable, real_number
from stark.array_file import naming
from stark.files import plain_name, resolved
from stark.recording.export import chosen_frames, export, remove_earlier
from stark.recording.format import RecordingError
from stark.recording.reader import given_recording

from .series import write_series
from .shots import MOTION, Camera, Shot, check_fields, frames_of

#: What ``export_recording`` and ``stark export`` write.
FORMATS = ("vtu", "ply", "obj", "vtkhdf", "usd", "glb", "pc2", "parquet", "mcap")
#: Without fields, and of one frame each.
_PLAIN = ("ply", "obj")
#: A file of each frame, with its number, of those that are written here.
_NUMBERED = ("vtu", "glb")
#: The numbers of every step.
_SERIES = ("parquet", "mcap")
_WITHOUT_FIELDS = (*_PLAIN, *_SERIES, "pc2")
#: With frames, or time codes, a second.
_WITH_RATE = ("usd", "pc2")
_FPS = 60.0
_BY_SUFFIX = {
    ".usd": "usd",
    ".usda": "usd",
    ".usdc": "usd",
    ".vtkhdf": "vtkhdf",
    ".pvd": "vtu",
    ".glb": "glb",
    ".pc2": "pc2",
}
_SUFFIX = {"usd": ".usdc", "vtkhdf": ".vtkhdf", "vtu": ".pvd", "glb": ".glb", "pc2": ".pc2"}


class Writer(Protocol):
    """Writes one format."""

    def add(self, shot: Shot) -> None:
        """Adds a time."""

    def finish(self) -> list[Path]:
        """Moves what was written into place."""

    def abandon(self) -> None:
        """Leaves nothing behind."""


class Exporter:
    """Writes a simulation to ``path`` while it runs::

        with stark.exports.Exporter("fall.usdc", sim, fields=("stress",)) as export:
            export.record(sim)
            for step in sim.run(until=1.0):
                export.record(sim)

    The suffix says the format: .usd, .usda, .usdc (USD), .vtkhdf (one file for ParaView), .pvd (an index for
    ParaView, with a .vtu file beside it for each record), .glb (glTF, the last record), .pc2 (a point cache
    of each body that moves, without fields, its name after that of the file). ``fields`` are
    ``displacement`` (since the first record), ``velocity`` (mean since the record before), and those of
    ``sim.picture``: stress, strain, pressure, contact_force, speed. ``fps``: time codes a second of USD,
    frames of PC2. The file is there after ``close()``; if what is in the ``with`` block raises, there is
    none. Raises InvalidArgument for other suffixes and fields, and ImportError that names the extra of a
    package that is missing."""

    def __init__(
        self, path: str | PathLike[str], sim: Any, *, fields: Sequence[str] = (), fps: float = _FPS
    ) -> None:
        file = resolved(given_path(path, "export: path"))
        self.path: Path = file
        self._camera = Camera(check_fields(fields, live=hasattr(sim, "contacts")))
        format = _format_of(file)
        _refuse_fields(fields, format)
        rate = _rate(fps)
        if format not in _WITH_RATE and rate != _FPS:
            raise InvalidArgument(
                f"export '{file}': fps = {fps!r}: must be left out: only USD and PC2 have frames a second; "
                f"other formats keep the time of each frame"
            )
        self._writer: Writer | None = _writer(file, format, rate)
        self._count, self._last = 0, -float("inf")

    def record(self, sim: Any) -> None:
        """Adds the simulation as it is now; its time must be later than that of the record before."""
        if self._writer is None:
            raise InvalidArgument(f"export '{self.path}': record() after close(): must be open")
        time = float(sim.time)
        if not time > self._last:
            raise InvalidArgument(
                f"export '{self.path}': record at {time:g} s after one at {self._last:g} s: must be later; "
                f"begin another export after a reset"
            )
        self._writer.add(self._camera.take(sim, time, self._count))
        self._count, self._last = self._count + 1, time

    def close(self) -> list[Path]:
        """Completes the file; returns what was written."""
        writer, self._writer = self._writer, None
        if writer is None:
            return []
        if self._count == 0:
            writer.abandon()
            raise InvalidArgument(
                f"export '{self.path}': nothing was recorded: call record(sim) before close()"
            )
        written = writer.finish()
        if self.path.suffix.lower() == ".pvd":
            remove_earlier(self.path.with_suffix(""), "vtu", written)
        return written

    def __enter__(self) -> Exporter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        elif self._writer is not None:
            writer, self._writer = self._writer, None
            writer.abandon()


def export_recording(
    recording: Any,
    folder: str | PathLike[str],
    format: str = "usd",
    *,
    frames: Iterable[int] | None = None,
    fields: Sequence[str] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> list[Path]:
    """Writes frames of a recording (all if left out) into ``folder`` and returns the files. ``fields`` are
    displacement and velocity, which positions give, and those that were recorded; all of them if left out.
    PLY, OBJ and PC2 have none. "parquet" and "mcap" are the
    numbers of every step. ``progress(done, total)`` is called after each frame. An export of all frames
    removes those of an earlier one, of more frames, which programs would take for its end. Raises
    RecordingError for unknown formats, empty recordings, and frames out of order or given twice."""
    given_recording(recording, "export_recording")
    if not isinstance(format, str) or format not in FORMATS:
        swapped = "; the folder comes first" if isinstance(folder, str) and folder in FORMATS else ""
        raise RecordingError(f"format '{format}' is unknown; choose one of {', '.join(FORMATS)}{swapped}")
    _refuse_fields(fields, format)
    if frames is not None and format in _SERIES:
        raise RecordingError(
            f"export: frames are given, and '{format}' has the numbers of every step: leave them out"
        )
    if format in _PLAIN:
        return export(recording, folder, format, frames=frames)
    chosen = chosen_frames(recording, frames)
    if not chosen:
        raise RecordingError(f"'{recording.folder}' has no frames; there is nothing to export")
    place = resolved(given_path(folder, "export: folder"))
    with naming(place):
        place.mkdir(parents=True, exist_ok=True)
    stem = plain_name(recording.scene, "run")
    if format in _SERIES:
        return [write_series(recording.telemetry, place / f"{stem}.{format}")]
    path = place / f"{stem}{_SUFFIX[format]}"
    recorded = [entry.name for entry in recording.fields]
    names = check_fields([*MOTION, *recorded] if fields is None else fields, live=False, recorded=recorded)
    writer = _writer(path, format, _FPS, each=True)
    try:
        for done, shot in enumerate(frames_of(recording, chosen, names), start=1):
            writer.add(shot)
            if progress is not None:
                progress(done, len(chosen))
    except BaseException:
        writer.abandon()
        raise
    written = writer.finish()
    if frames is None and format in _NUMBERED:
        remove_earlier(place / stem, format, written)
    return written


def _writer(path: Path, format: str, fps: float, *, each: bool = False) -> Writer:
    """``each``: a still of each time, not of the last one."""
    if format == "usd":
        from .usd import UsdWriter

        return UsdWriter(path, fps)
    if format == "vtkhdf":
        from .vtkhdf import VtkHdfWriter

        return VtkHdfWriter(path)
    if format == "vtu":
        from .vtu import VtuWriter

        return VtuWriter(path)
    if format == "pc2":
        from .pc2 import Pc2Writer

        return Pc2Writer(path, fps)
    from .gltf import GltfWriter

    return GltfWriter(path, each=each)


def _format_of(path: Path) -> str:
    if path.suffix.lower() not in _BY_SUFFIX:
        raise InvalidArgument(f"export '{path}': its suffix must be one of {', '.join(_BY_SUFFIX)}")
    return _BY_SUFFIX[path.suffix.lower()]


def _refuse_fields(fields: Sequence[str] | None, format: str) -> None:
    if format in _WITHOUT_FIELDS and fields is not None and (not is_iterable(fields) or list(fields) != []):
        raise InvalidArgument(
            f"export: fields = {fields!r}: '{format}' has none: leave them out, or choose usd or vtkhdf"
        )


def _rate(fps: float) -> float:
    rate = real_number(fps, "export: fps")
    if not 0.0 < rate < float("inf"):
        raise InvalidArgument(f"export: fps = {fps}: must be > 0 and finite")
    return rate
