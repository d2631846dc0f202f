"""Writes a run folder while the simulation runs."""

from __future__ import annotations

import json
import shutil
import time as clock
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from ..array_file import WriteError, naming, remove_leftovers, write_arrays, write_atomically
from ..telemetry import SERIES, TelemetryWriter, _plain
from .format import (
    CHECKPOINT,
    CHUNK_FRAMES,
    FORMAT_NAME,
    FORMAT_VERSION,
    MANIFEST,
    STATES,
    TELEMETRY,
    TOPOLOGY,
    BodyEntry,
    RecordingError,
    chunk_path,
    drawn,
    surface,
)
from .reader import Recording

if TYPE_CHECKING:
    from .states import StateWriter


def body_color(body: Any) -> tuple[float, float, float] | None:
    """The colour of a body as three floats in [0, 1], or None when it has none."""
    color = getattr(body, "color", None)
    if color is None:
        return None
    red, green, blue = (min(1.0, max(0.0, float(c))) for c in tuple(color)[:3])
    return (red, green, blue)


def _word(value: Any) -> str:
    return str(getattr(value, "name", value)).lower()


def _settings_of(sim: Any) -> dict[str, Any]:
    """Those of the simulation; none of what only looks like one."""
    settings = getattr(sim, "settings", None)
    return {} if settings is None else dict(settings.to_dict())


def _require_same_settings(
    folder: str | PathLike[str], before: Mapping[str, Any], now: Mapping[str, Any]
) -> None:
    """Claims of a certificate are about one set of settings."""
    plain = _plain(dict(now))
    changed = [
        name for name in plain if before.get(name) != plain[name] and not name.startswith("execution.")
    ]
    if changed:
        raise RecordingError(
            f"'{folder}' was recorded for certification: settings must stay as they were, {changed[0]} = "
            f"{before.get(changed[0])}; resume it without changes, or run the scene anew"
        )


class Recorder:
    """Records the surfaces of all bodies of ``sim``, and its layers, into ``folder``.

    ``record(sim)`` adds a frame, ``report(step_report)`` adds a line of telemetry, ``close()`` completes
    the folder. An existing recording in ``folder`` is replaced; any other non-empty folder is refused.
    ``settings`` are those of ``sim`` when not given.
    With ``certify``, ``record_state(sim)`` has to be called at the start and after every accepted step, for
    ``stark verify``.
    """

    def __init__(
        self,
        folder: str | PathLike[str],
        sim: Any,
        *,
        scene: str = "",
        settings: Mapping[str, Any] | None = None,
        chunk_frames: int = CHUNK_FRAMES,
        stark_version: str = "",
        certify: bool = False,
    ) -> None:
        if chunk_frames < 1:
            raise RecordingError(f"chunk_frames = {chunk_frames}; must be at least 1")
        self.folder = Path(folder)
        self._written = 0
        self._chunk_frames = chunk_frames
        self._chunk_index = 0
        #: Frames of the chunk that is not full yet: time [s] and the positions of each body.
        self._pending: list[tuple[float, list[np.ndarray]]] = []
        #: Time of the last frame [s], minus infinity before the first.
        self.last_time = -np.inf
        self._closed = False
        self._synced = 0
        try:
            with naming(self.folder):
                self._prepare_folder()
        except WriteError as error:
            raise RecordingError(f"recording {error}") from error
        bodies = drawn(sim)
        self._entries = [self._entry(body) for body in bodies]
        self._manifest: dict[str, Any] = {
            "format": FORMAT_NAME,
            "version": FORMAT_VERSION,
            "stark_version": stark_version,
            "scene": scene,
            "created": clock.strftime("%Y-%m-%dT%H:%M:%SZ", clock.gmtime()),
            "status": "running",
            "message": "",
            "frame_count": 0,
            "chunk_count": 0,
            "chunk_frames": chunk_frames,
            "settings": _plain(_settings_of(sim) if settings is None else dict(settings)),
            "bodies": [entry.to_json() for entry in self._entries],
            "units": {"position": "m", **SERIES},
            "resumed": [],
            "summary": {},
        }
        triangles = {f"triangles_{i:04d}": surface(b)[1].astype(np.int32) for i, b in enumerate(bodies)}
        write_arrays(self.folder / TOPOLOGY, triangles)
        self._states: StateWriter | None = None
        if certify:
            from .states import StateWriter

            self._states = StateWriter(self.folder, sim, chunk_frames)
        self._telemetry = TelemetryWriter(self.folder / TELEMETRY)
        self._write_manifest()

    def _prepare_folder(self) -> None:
        if self.folder.exists():
            if not self.folder.is_dir():
                raise RecordingError(f"'{self.folder}' is a file; choose a folder for the recording")
            known = (self.folder / MANIFEST).exists()
            if any(self.folder.iterdir()) and not known:
                raise RecordingError(
                    f"folder '{self.folder}' is not empty and holds no recording; choose another folder"
                )
            if known:
                (self.folder / MANIFEST).unlink()
                shutil.rmtree(self.folder / "frames", ignore_errors=True)
                shutil.rmtree(self.folder / STATES, ignore_errors=True)
                (self.folder / "certificate.json").unlink(missing_ok=True)
                (self.folder / TELEMETRY).unlink(missing_ok=True)
                (self.folder / "replay.html").unlink(missing_ok=True)
                (self.folder / CHECKPOINT).unlink(missing_ok=True)
                remove_leftovers(self.folder)
        (self.folder / "frames").mkdir(parents=True, exist_ok=True)

    @classmethod
    def resume(
        cls, folder: str | PathLike[str], sim: Any, *, frames: int, lines: int, states: int = 0
    ) -> Recorder:
        """Goes on with the recording in ``folder`` after its first ``frames`` frames, ``lines`` lines of
        telemetry and ``states`` states, if it is one for certification; what follows them is dropped. The
        folder ends up as if it had been recorded at once, the times of resuming in its manifest apart."""
        recording = Recording(folder)
        certified = "states" in recording.manifest
        if certified != (states > 0):
            raise RecordingError(
                f"'{folder}' and its checkpoint disagree about --certify; run the scene anew"
            )
        if certified:
            _require_same_settings(folder, recording.settings, sim.settings.to_dict())
        if len(recording) < frames:
            raise RecordingError(f"'{folder}' holds {len(recording)} frames: must have {frames} to go on")
        recorder = cls.__new__(cls)
        recorder.folder = Path(folder)
        for place in (recorder.folder, recorder.folder / "frames", recorder.folder / STATES):
            remove_leftovers(place)
        recorder._manifest = {
            **recording.manifest,
            "status": "running",
            "message": "",
            "resumed": [*recording.manifest.get("resumed", []), float(sim.time)],
            "summary": {},
        }
        recorder._entries = [cls._entry(body) for body in drawn(sim)]
        if recorder._entries != recording.bodies:
            raise RecordingError(
                f"'{folder}' is a recording of other bodies; give the scene it was made with"
            )
        recorder._chunk_frames = int(recording.manifest.get("chunk_frames", CHUNK_FRAMES))
        recorder._states = None
        if certified:
            from .states import StateWriter

            size = recorder._chunk_frames
            recorder._states = StateWriter.resume(recorder.folder, sim, size, states)
        recorder._chunk_index, rest = divmod(frames, recorder._chunk_frames)
        recorder._written = recorder._synced = frames - rest
        recorder._pending = [
            (float(recording.times[k]), [recording.positions(i, k) for i in range(len(recording.bodies))])
            for k in range(frames - rest, frames)
        ]
        recorder.last_time = float(recording.times[frames - 1]) if frames else -np.inf
        recorder._closed = False
        recorder._telemetry = TelemetryWriter(recorder.folder / TELEMETRY, keep=lines)
        recorder.sync()
        return recorder

    @staticmethod
    def _entry(body: Any) -> BodyEntry:
        positions, triangles = surface(body)
        if positions.ndim != 2 or positions.shape[1] != 3:
            raise RecordingError(
                f"body '{body.name}': positions have shape {positions.shape}; must be (n, 3)"
            )
        if triangles.ndim != 2 or triangles.shape[1] != 3:
            raise RecordingError(
                f"body '{body.name}': triangles have shape {triangles.shape}; must be (m, 3)"
            )
        if triangles.size and (triangles.min() < 0 or triangles.max() >= len(positions)):
            raise RecordingError(
                f"body '{body.name}': a triangle names vertex {triangles.max()}; it has {len(positions)}"
            )
        return BodyEntry(
            name=str(body.name),
            kind=_word(body.kind),
            motion=_word(getattr(body, "motion", None) or "dynamic"),
            vertex_count=len(positions),
            triangle_count=len(triangles),
            color=body_color(body),
        )

    def record(self, sim: Any, time: float | None = None) -> None:
        """Adds one frame: the surfaces of bodies and layers at ``time`` [s], ``sim.time`` when not given."""
        if self._closed:
            raise RecordingError(f"recording '{self.folder}' is closed; frames can no longer be added")
        bodies = drawn(sim)
        if len(bodies) != len(self._entries):
            raise RecordingError(
                f"recording '{self.folder}' began with {len(self._entries)} bodies, now there are "
                f"{len(bodies)}; begin a new recording"
            )
        frame = []
        for body, entry in zip(bodies, self._entries, strict=True):
            positions = surface(body)[0].astype(np.float32)
            if positions.shape != (entry.vertex_count, 3):
                raise RecordingError(
                    f"body '{entry.name}': {positions.shape} positions, recorded as {(entry.vertex_count, 3)}"
                )
            frame.append(positions)
        at = float(sim.time if time is None else time)
        self._pending.append((at, frame))  # one operation: an interrupt cannot leave half a frame
        self.last_time = at
        if len(self._pending) >= self._chunk_frames:
            self._flush_frames()
            self._write_manifest()

    def record_state(self, sim: Any) -> None:
        """Adds the state of ``sim`` in double precision, if the recording is one for certification."""
        if self._closed:
            raise RecordingError(f"recording '{self.folder}' is closed; states can no longer be added")
        if self._states is not None and self._states.write(sim):
            self._write_manifest()

    def report(self, step_report: Any, **extra: float | Mapping[str, float]) -> None:
        """Adds one line of telemetry; ``extra`` are further numbers, or groups of them, in SI units."""
        self._telemetry.write(step_report, **extra)

    def flush(self) -> None:
        """Writes the frames held in memory as one chunk and begins the next one; writes the states."""
        if self._states is not None:
            self._states.sync()
        self._flush_frames()
        self._write_manifest()

    def _flush_frames(self) -> None:
        if self._pending:
            self._write_chunk()
            self._chunk_index += 1
            self._written += len(self._pending)
            self._pending = []

    def sync(self) -> None:
        """Writes all that was recorded, so that a killed run has it. The last chunk is written again when it
        has grown: where frames are stored does not depend on when this is called."""
        if self.frame_count > self._synced and self._pending:
            self._write_chunk()
        if self._states is not None:
            self._states.sync()
        self._synced = self.frame_count
        self._telemetry.sync()
        self._write_manifest(with_pending=True)

    def _write_chunk(self) -> None:
        """A body that did not move in the chunk is stored once."""
        times = [at for at, _ in self._pending]
        arrays: dict[str, np.ndarray] = {"times": np.array(times, dtype=np.float64)}
        for i in range(len(self._entries)):
            track = [frame[i] for _, frame in self._pending]
            still = all(np.array_equal(track[0], positions) for positions in track[1:])
            arrays[f"positions_{i:04d}"] = np.stack(track[:1] if still else track)
        write_arrays(self.folder / chunk_path(self._chunk_index), arrays)

    @property
    def frame_count(self) -> int:
        """Frames recorded so far, written or not."""
        return self._written + len(self._pending)

    @property
    def state_count(self) -> int:
        """States recorded so far, 0 in a recording that is not for certification."""
        return 0 if self._states is None else self._states.count

    @property
    def line_count(self) -> int:
        """Lines of telemetry so far."""
        return self._telemetry.line_count

    def _write_manifest(self, *, with_pending: bool = False) -> None:
        pending = len(self._pending) if with_pending else 0
        self._manifest["frame_count"] = self._written + pending
        self._manifest["chunk_count"] = self._chunk_index + (1 if pending else 0)
        if self._states is not None:
            self._manifest["states"] = self._states.manifest
        text = json.dumps(self._manifest, indent=1, allow_nan=False) + "\n"
        write_atomically(self.folder / MANIFEST, lambda file: file.write(text.encode()))

    def close(
        self, status: str = "complete", message: str = "", summary: Mapping[str, Any] | None = None
    ) -> None:
        """Completes the folder. ``status`` is ``complete``, ``failed`` or ``interrupted``."""
        if self._closed:
            return
        self._manifest["status"] = status
        self._manifest["message"] = message
        self._manifest["summary"] = _plain(dict(summary or {}))
        self._closed = True  # what cannot be written now is not tried again
        try:
            self.flush()
        finally:
            self._telemetry.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        elif issubclass(kind, KeyboardInterrupt):
            self.close("interrupted", "stopped by the user")
        else:
            self.close("failed", f"{kind.__name__}: {error}")
