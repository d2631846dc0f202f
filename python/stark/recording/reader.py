"""Reads a run folder, checking everything before it is handed out."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import given_path, given_word, real_number, shown_value
from ..array_file import DamageError, read_arrays
from ..caller import warn
from ..files import read_text, resolved
from ..telemetry import Telemetry, TelemetryError
from .chain import ARRAY
from .fields import Contacts, FieldEntry, read_chunk, read_entries, row_of
from .format import (
    CHUNK_FRAMES,
    FORMAT_NAME,
    FORMAT_VERSION,
    MANIFEST,
    TELEMETRY,
    TOPOLOGY,
    BodyEntry,
    Frame,
    FrameBody,
    RecordingError,
    chunk_path,
    field_path,
)


def _read_npz(place: Path, path: Path) -> dict[str, np.ndarray]:
    """The arrays of a file at ``place``, which messages call ``path``."""
    try:
        return read_arrays(place)
    except FileNotFoundError:
        raise RecordingError(
            f"'{path}' is missing; copy the run folder again or run the scene anew"
        ) from None
    except DamageError as error:
        raise RecordingError(
            f"'{path}' is damaged or cut off ({error}); copy the run folder again"
        ) from error


def _strict_json(text: str) -> Any:
    """Without NaN and infinite numbers, which are no JSON, and which no recorder writes."""

    def number(word: str) -> float:
        value = float(word)
        if not math.isfinite(value):
            raise ValueError(f"{word[:20]} is no number of JSON")
        return value

    return json.loads(text, parse_float=number, parse_constant=number)


def _kept(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What later frames are read from: not to be written into."""
    for array in arrays.values():
        array.flags.writeable = False
    return arrays


def _check_entries(manifest: dict[str, Any]) -> None:
    """Raises what ``_take_manifest`` reports for entries that are of the wrong type or out of range."""
    if not 0 <= int(manifest["chunk_count"]) <= int(manifest["frame_count"]):
        raise ValueError("chunk_count must be in [0, frame_count]")
    for group in ("chain", "settings", "summary"):
        if not isinstance(manifest.get(group, {}), dict):
            raise TypeError(f"{group} must be an object")
    gravity = manifest.get("settings", {}).get("gravity", [0.0, 0.0, 0.0])
    is_vector = isinstance(gravity, list) and len(gravity) == 3 and None not in gravity
    if not is_vector or not all(map(_is_number, gravity)):
        raise TypeError("gravity must be a list of three numbers")
    observables = manifest.get("summary", {}).get("observables", {})
    if not isinstance(observables, dict) or not all(map(_is_number, observables.values())):
        raise TypeError("observables must be an object of numbers")
    if not isinstance(manifest.get("resumed", []), list):
        raise TypeError("resumed must be a list")
    size = manifest.get("chunk_frames", CHUNK_FRAMES)
    if type(size) is not int or size < 1:
        raise ValueError(f"chunk_frames = {size} must be an integer >= 1")


class Recording:
    """A recorded run. Frames are read chunk by chunk, so a long recording need not fit into memory."""

    def __init__(self, folder: str | PathLike[str]) -> None:
        self.folder: Path = given_path(folder, "recording: folder")
        self._place = resolved(self.folder)  # where it is read, whatever the current folder will be
        self.manifest: dict[str, Any] = self._read_manifest()
        frame_count, chunk_count = self._take_manifest()
        self._triangles = self._read_topology()
        self._cache: dict[int, dict[str, np.ndarray]] = {}
        self._field_cache: dict[int, dict[str, np.ndarray]] = {}
        self._telemetry: tuple[tuple[int, int, int], Telemetry] | None = None
        self._read_times(frame_count, chunk_count)

    def _take_manifest(self) -> tuple[int, int]:
        """Takes what the manifest says; returns its numbers of frames and of chunks."""
        try:
            _check_entries(self.manifest)
            self.bodies: list[BodyEntry] = [_body(entry) for entry in self.manifest["bodies"]]
            self.scene: str = str(self.manifest["scene"])
            self.status: str = str(self.manifest["status"])
            #: Fields that were recorded, and whether contacts were.
            self.fields: list[FieldEntry]
            self.has_contacts: bool
            self.fields, self.has_contacts = read_entries(self.manifest, len(self.bodies))
            return int(self.manifest["frame_count"]), int(self.manifest["chunk_count"])
        except (KeyError, TypeError, ValueError, OverflowError, AttributeError) as error:
            raise RecordingError(f"'{self.folder / MANIFEST}' lacks or breaks an entry: {error}") from error

    def _read_times(self, frame_count: int, chunk_count: int) -> None:
        times = [self._chunk(index)["times"] for index in range(chunk_count)]
        if self.status == "running" and times:
            # The last chunk grows at checkpoints; frames that the manifest does not count yet are not there.
            times[-1] = times[-1][: max(0, frame_count - sum(map(len, times[:-1])))]
        self._starts = np.cumsum([0] + [len(t) for t in times])
        #: Time of each frame [s], shape (frames,).
        self.times: np.ndarray = np.concatenate(times) if times else np.zeros(0)
        self.times.flags.writeable = False
        if len(self.times) != frame_count:
            raise RecordingError(
                f"'{self.folder}' holds {len(self.times)} frames, its manifest says {frame_count}; "
                "copy the run folder again"
            )
        if np.any(np.diff(self.times) < 0.0):
            at = int(np.argmax(np.diff(self.times) < 0.0))
            raise RecordingError(
                f"'{self.folder}': times of frames decrease, {self.times[at]:.9g} s is followed by "
                f"{self.times[at + 1]:.9g} s; the recording is damaged, or an older Stark recorded on after "
                f"sim.reset(): record each episode into a folder of its own"
            )

    def __repr__(self) -> str:
        until = f", until {self.times[-1]:.6g} s" if len(self.times) else ""
        return (
            f"<stark.recording.Recording of {self.scene!r} in {str(self.folder)!r}: {len(self.times)} frames"
            f"{until}, {self.status}>"
        )

    def _read_manifest(self) -> dict[str, Any]:
        path = self.folder / MANIFEST
        if not self._place.is_dir():
            raise RecordingError(
                f"'{self.folder}' is not a run folder: no such folder; check the path, stark run prints it"
            )
        try:
            manifest = _strict_json(read_text(self._place / MANIFEST))
        except FileNotFoundError:
            raise RecordingError(
                f"'{self.folder}' is not a run folder: it has no {MANIFEST}, which stark run and "
                f"stark.recording.Recorder write"
            ) from None
        except (OSError, ValueError, RecursionError) as error:
            raise RecordingError(f"'{path}' is damaged: {error}") from error
        if not isinstance(manifest, dict) or manifest.get("format") != FORMAT_NAME:
            raise RecordingError(
                f"'{path}' is not the manifest of a Stark recording (format must be {FORMAT_NAME!r})"
            )
        if manifest.get("version") != FORMAT_VERSION:
            raise RecordingError(
                f"'{path}' has format version {manifest.get('version')}; this Stark reads {FORMAT_VERSION}: "
                "use the Stark that wrote it"
            )
        return manifest

    def _read_topology(self) -> list[np.ndarray]:
        path = self.folder / TOPOLOGY
        arrays = _read_npz(self._place / TOPOLOGY, path)
        triangles = []
        for i, body in enumerate(self.bodies):
            array = arrays.get(f"triangles_{i:04d}")
            if array is None or array.dtype.kind != "i" or array.shape != (body.triangle_count, 3):
                raise RecordingError(
                    f"'{path}': triangles of body '{body.name}' are missing or have a wrong shape"
                )
            if array.size and (array.min() < 0 or array.max() >= body.vertex_count):
                raise RecordingError(
                    f"'{path}': a triangle of body '{body.name}' names a vertex that it does not have"
                )
            triangles.append(array.astype(np.int32))
            triangles[-1].flags.writeable = False
        return triangles

    def _chunk(self, index: int) -> dict[str, np.ndarray]:
        if index in self._cache:
            return self._cache[index]
        path = self.folder / chunk_path(index)
        arrays = _read_npz(self._place / chunk_path(index), path)
        times = arrays.get("times")
        if times is None or times.ndim != 1 or times.dtype != np.float64 or not np.isfinite(times).all():
            raise RecordingError(f"'{path}' has no valid times")
        digests = arrays.get(ARRAY)
        if digests is not None and (digests.shape != (len(times), 32) or digests.dtype != np.uint8):
            raise RecordingError(f"'{path}': digests have a wrong shape")
        for i, body in enumerate(self.bodies):
            positions = arrays.get(f"positions_{i:04d}")
            if (
                positions is None
                or positions.dtype != np.float32
                or positions.shape[1:] != (body.vertex_count, 3)
                or len(positions)
                not in (
                    1,
                    len(times),
                )
            ):
                raise RecordingError(
                    f"'{path}': positions of body '{body.name}' are missing or have a wrong shape"
                )
        if len(self._cache) >= 4:
            self._cache.pop(next(iter(self._cache)))
        self._cache[index] = _kept(arrays)
        return arrays

    def __len__(self) -> int:
        return len(self.times)

    @property
    def settings(self) -> dict[str, Any]:
        """The settings of the run by dotted name."""
        settings: dict[str, Any] = self.manifest.get("settings", {})
        return settings

    @property
    def telemetry(self) -> Telemetry:
        """The numbers of every step, read again when the file has changed. An unfinished last line is allowed
        only in a run that was killed."""
        file = self._place / TELEMETRY
        try:
            found = os.stat(file)
            stamp = (found.st_ino, found.st_size, found.st_mtime_ns)
        except OSError:  # which reading then reports
            stamp = (0, 0, 0)
        if self._telemetry is None or self._telemetry[0] != stamp:
            try:
                read = Telemetry.read(file, tolerate_cut_line=self.status == "running")
            except TelemetryError as error:
                raise RecordingError(str(error)) from error
            self._telemetry = stamp, read
        return self._telemetry[1]

    def body_index(self, body: str | int) -> int:
        """Index of a body given by name or index."""
        if isinstance(body, (int, np.integer)):
            if 0 <= body < len(self.bodies):
                return int(body)
            raise RecordingError(f"'{self.folder}' has {len(self.bodies)} bodies, no body {body}")
        names = [entry.name for entry in self.bodies]
        if not isinstance(body, str) or body not in names:
            raise RecordingError(
                f"'{self.folder}' has no body {shown_value(body)}; it has: {', '.join(names)}"
            )
        return names.index(body)

    def triangles(self, body: str | int) -> np.ndarray:
        """Triangles of a body, (m, 3) int32."""
        return self._triangles[self.body_index(body)].copy()

    def positions(self, body: str | int, frames: slice | int = slice(None)) -> np.ndarray:
        """Positions of a body in the world [m]: (n, 3) for one frame, (frames, n, 3) for a slice, float32."""
        which = self.body_index(body)
        if not isinstance(frames, slice):
            return self._positions_at(which, self._frame_index(frames)).copy()
        indices = range(*frames.indices(len(self)))
        if not indices:
            return np.zeros((0, self.bodies[which].vertex_count, 3), dtype=np.float32)
        return np.stack([self._positions_at(which, index) for index in indices])

    def _frame_index(self, index: int) -> int:
        count = len(self)
        if not isinstance(index, (int, np.integer)):
            raise RecordingError(f"'{self.folder}': frame = {index!r}: must be a whole number or a slice")
        if not -count <= index < count:
            raise RecordingError(f"'{self.folder}' has {count} frames, no frame {index}")
        return int(index) % count

    def _positions_at(self, which: int, index: int) -> np.ndarray:
        chunk, row = self._place_of(index)
        positions = self._chunk(chunk)[f"positions_{which:04d}"]
        frame: np.ndarray = positions[0 if len(positions) == 1 else row]
        return frame

    def _place_of(self, frame: int) -> tuple[int, int]:
        """Number of the chunk of a frame, and the frame's number in it."""
        chunk = int(np.searchsorted(self._starts, frame, side="right")) - 1
        return chunk, frame - int(self._starts[chunk])

    def field_row(self, frame: int) -> dict[str, np.ndarray]:
        """Fields and contacts of a frame as they are stored, see ``stark.recording.fields``."""
        index, row = self._place_of(self._frame_index(frame))
        if index not in self._field_cache:
            path, counts = self.folder / field_path(index), [body.vertex_count for body in self.bodies]
            length = int(self._starts[index + 1] - self._starts[index])
            chunk = read_chunk(self._place / field_path(index), path, self.manifest, counts, length)
            if len(self._field_cache) >= 2:
                self._field_cache.pop(next(iter(self._field_cache)))
            self._field_cache[index] = _kept(chunk)
        return row_of(self._field_cache[index], row)

    def field(self, name: str, frame: int) -> dict[str, np.ndarray]:
        """A recorded field in a frame: values (n,) float32 at the drawn vertices, by name of body. Raises
        RecordingError for fields that were not recorded."""
        name = given_word(name, "recording: field: name")
        numbers = [k for k, entry in enumerate(self.fields) if entry.name == name]
        if not numbers:
            known = ", ".join(entry.name for entry in self.fields) or "none"
            raise RecordingError(
                f"'{self.folder}' has no field '{name}'; it has: {known}. Record it: stark run --fields "
                f"{name}, or Recorder(fields=('{name}',))"
            )
        row = self.field_row(frame)
        return {
            self.bodies[i].name: row[f"values_{numbers[0]:02d}_{i:04d}"].copy()
            for i in self.fields[numbers[0]].bodies
        }

    def contacts(self, frame: int) -> Contacts:
        """Contacts of a frame; RecordingError if they were not recorded."""
        if not self.has_contacts:
            raise RecordingError(f"'{self.folder}' has no contacts: record them, Recorder(contacts=True)")
        row = self.field_row(frame)
        names = ("contact_points", "contact_forces", "contact_bodies", "body_forces")
        return Contacts(*(row[name] for name in names))

    def digest(self, frame: int) -> np.ndarray:
        """Digest of a frame and all before it (32,) uint8, see ``stark.recording.chain``."""
        index, row = self._place_of(self._frame_index(frame))
        chunk = self._chunk(index)
        if ARRAY not in chunk:
            raise RecordingError(f"'{self.folder}': frame {frame} lacks its digest; run the scene anew")
        digest: np.ndarray = chunk[ARRAY][row]
        return digest

    def frame(self, index: int) -> Frame:
        """All bodies of one frame; negative indices count from the end."""
        index = self._frame_index(index)
        bodies = tuple(
            FrameBody(b.name, b.kind, b.motion, self._positions_at(i, index), self._triangles[i], b.color)
            for i, b in enumerate(self.bodies)
        )
        return Frame(index, float(self.times[index]), bodies, self)

    def frames(self) -> Iterator[Frame]:
        """All frames in order of time."""
        return (self.frame(index) for index in range(len(self)))

    def nearest(self, time: float) -> int:
        """Index of the frame nearest to ``time`` [s]; the last one for infinity."""
        if not len(self):
            raise RecordingError(f"'{self.folder}' has no frames")
        time = real_number(time, f"'{self.folder}': time")
        if math.isnan(time):
            raise RecordingError(f"'{self.folder}': time = {time}: must be a time [s]; it has {self._span()}")
        return int(np.argmin(np.abs(self.times - np.clip(time, self.times[0], self.times[-1]))))

    def _span(self) -> str:
        return f"frames from {self.times[0]:g} s to {self.times[-1]:g} s"

    def beyond(self, time: float) -> str:
        """What to say of a time [s] before the first frame or after the last one; empty for others, and for
        infinity, which is the end."""
        time = real_number(time, f"'{self.folder}': time")
        if not len(self) or not math.isfinite(time) or self.times[0] - 1e-6 <= time <= self.times[-1] + 1e-6:
            return ""
        return f"the recording has {self._span()}, the nearest of them is taken for {time:g} s"

    def still(self, time: float, **options: Any) -> np.ndarray:
        """Picture of the frame nearest to ``time`` [s], the last one for infinity: (height, width, 3) uint8;
        options as ``stark.render.render``. Warns of times that the recording does not have."""
        from ..render.picture import render

        frame = self.frame(self.nearest(time))
        if message := self.beyond(time):
            warn(f"still: {message}")
        return render(frame, **options)


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, (int, float)) and abs(value) <= 1e308)


def _body(entry: dict[str, Any]) -> BodyEntry:
    """An entry of a manifest. Raises TypeError or ValueError for what a writer never writes."""
    color = tuple(float(c) for c in entry["color"]) if entry.get("color") else None
    body = BodyEntry(**{**entry, "color": color})
    texts, counts = (body.name, body.kind, body.motion), (body.vertex_count, body.triangle_count)
    if not all(isinstance(text, str) for text in texts):
        raise TypeError(f"name, kind and motion of a body must be texts, not {texts}")
    if not all(type(count) is int and count >= 0 for count in counts):
        raise ValueError(f"body '{body.name}' has {counts} vertices and triangles")
    if color is not None and (len(color) != 3 or not all(0.0 <= c <= 1.0 for c in color)):
        raise ValueError(f"body '{body.name}' has the colour {color}")
    return body


def given_recording(value: Any, what: str) -> Recording:
    """A recording. Raises RecordingError for anything else, such as the path of one."""
    if not isinstance(value, Recording):
        raise RecordingError(
            f"{what}: recording = {value!r}: must be a stark.recording.Recording, "
            f"made of the path of a run folder"
        )
    return value
