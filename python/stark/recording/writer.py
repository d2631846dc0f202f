"""Writes a run folder while the simulation runs."""

from __future__ import annotations

import json
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import given_flag, given_path
from ..array_file import WriteError, make_folder, write_arrays, write_atomically
from ..files import resolved
from ..telemetry import SERIES, TelemetryWriter, _plain, digest_of_last, first_lines
from . import chain
from .chain import RowChain
from .fields import Arrays, FieldWriter, check_given, given_fields, write_chunk
from .folder import drop_chunks_after, prepare, require_same_settings, tidy
from .format import (
    CHUNK_FRAMES,
    FIELDS,
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
from .latest import remember
from .lock import FolderLock
from .order import Forward
from .reader import Recording

if TYPE_CHECKING:
    from .states import StateWriter


def _now() -> str:
    return clock.strftime("%Y-%m-%dT%H:%M:%SZ", clock.gmtime())


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


@dataclass(frozen=True)
class _Pending:
    """A frame that is not in a full chunk yet. ``digest`` (32,) is None in recordings without a chain."""

    time: float  # [s]
    positions: list[np.ndarray]
    digest: np.ndarray | None
    values: dict[str, np.ndarray] = field(default_factory=dict)  # fields and contacts


class Recorder:
    """Records the surfaces of all bodies of ``sim``, and its layers, into ``folder``.

    ``record(sim)`` adds a frame, ``report(step_report, measured={...})`` adds the numbers of a step and
    your own, ``close()`` completes the folder; a ``with`` block does that for you. The recorder replaces
    an existing recording in ``folder``; ``Recorder.resume`` goes on with it. It raises RecordingError for
    any other folder that is not empty, and for one that another recorder is writing. ``settings`` are by
    default those of ``sim``. With ``certify=True``, call ``record_state(sim)`` at the start and after
    every accepted step; then ``stark verify`` can check the run. Times go forward: what comes after
    ``sim.reset()``, or another jump back in time, is refused and belongs to another recorder with a
    folder of its own.

    ``fields`` lets replays, pictures and exports colour the bodies: "stress", "strain", "pressure",
    "contact_force" or "speed" at the vertices of moving bodies, with every frame
    (``stark.render.field_values`` defines them). ``arrays`` adds fields of your own: for each name, with its
    unit in brackets, a function of the simulation that returns values (n,) at the vertices of some bodies,
    always the same ones: ``{"height [m]": lambda sim: {"jelly": sim["jelly"].positions[:, 2]}}``.
    ``contacts=True`` keeps points and forces of contact, per frame the 1000 with the largest forces.
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
        fields: Sequence[str] = (),
        arrays: Mapping[str, Arrays] | None = None,
        contacts: bool = False,
    ) -> None:
        certify = given_flag(certify, "recording: certify")
        contacts = given_flag(contacts, "recording: contacts")
        if type(chunk_frames) is not int or chunk_frames < 1:
            raise RecordingError(f"chunk_frames = {chunk_frames!r}: must be a whole number, at least 1")
        check_given(sim, scene, stark_version, settings, arrays)
        self.folder: Path = resolved(given_path(folder, "recording: folder"))
        self._written = 0
        self._chunk_frames = chunk_frames
        self._chunk_index = 0
        #: Frames of the chunk that is not full yet: time [s], positions of each body, digest.
        self._pending: list[_Pending] = []
        self._times = Forward(self.folder)
        self._closed = False
        self._synced = 0
        bodies = drawn(sim)
        self._entries = [self._entry(body) for body in bodies]
        self._manifest: dict[str, Any] = {
            "format": FORMAT_NAME,
            "version": FORMAT_VERSION,
            "stark_version": stark_version,
            "scene": scene,
            "created": _now(),
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
        self._states: StateWriter | None = None
        self._fields: FieldWriter | None = None
        fields = given_fields(fields)
        if fields or arrays or contacts:
            self._fields = FieldWriter(sim, fields, arrays or {}, contacts)
            self._manifest["fields"] = self._fields.manifest
        self._telemetry: TelemetryWriter | None = None
        self._kept_lines = 0
        try:
            self._lock = prepare(self.folder)
        except WriteError as error:
            raise RecordingError(f"recording {error}") from error
        try:
            self._begin(sim, bodies, certify)
        except BaseException:
            self._lock.release()
            raise
        remember(sim, self, self._manifest["created"])

    def _begin(self, sim: Any, bodies: list[Any], certify: bool) -> None:
        """The files that do not change, between two manifests: with the first one the folder is known as that
        of a recording, with the second one it can be read."""
        self._write_manifest()
        make_folder(self.folder / "frames")
        triangles = {f"triangles_{i:04d}": surface(b)[1].astype(np.int32) for i, b in enumerate(bodies)}
        write_arrays(self.folder / TOPOLOGY, triangles)
        still = [TOPOLOGY]
        if certify:
            from .states import StateWriter

            self._states = StateWriter(self.folder, sim, self._chunk_frames)
            still += [f"{STATES}/scene.json", f"{STATES}/mesh.npz"]
        seed = chain.seed(self.folder, still)
        self._manifest["chain"] = {"version": chain.VERSION, "seed": seed}
        self._frame_chain: RowChain | None = RowChain(seed, "frames")
        self._line_chain: RowChain | None = RowChain(seed, "telemetry")
        #: Digests of the frames that are on disk, up to the last one.
        self._frame_head = self._frame_chain.head
        if self._states is not None:
            self._states.begin_chain(seed)
        self._telemetry = TelemetryWriter(self.folder / TELEMETRY, chain=self._line_chain)
        self._write_manifest()

    @classmethod
    def resume(
        cls,
        folder: str | PathLike[str],
        sim: Any,
        *,
        frames: int,
        lines: int,
        states: int = 0,
        lock: FolderLock | None = None,
    ) -> Recorder:
        """Goes on with the recording in ``folder`` after its first ``frames`` frames, ``lines`` lines of
        telemetry and ``states`` states, if it is one for certification; what follows them is dropped. The
        folder ends up as if it had been recorded at once, the times of resuming in its manifest apart. The
        counts are those that ``sync()`` returned when the checkpoint was written. ``lock``: that of the
        folder, if the caller has it."""
        place = resolved(given_path(folder, "recording: folder"))
        held = FolderLock(place) if lock is None else lock
        try:
            return cls._resumed(place, sim, frames, lines, states, held)
        except BaseException:
            held.release()
            raise

    @classmethod
    def _resumed(
        cls, folder: Path, sim: Any, frames: int, lines: int, states: int, lock: FolderLock
    ) -> Recorder:
        recording = Recording(folder)
        certified = "states" in recording.manifest
        if certified != (states > 0):
            raise RecordingError(
                f"'{folder}' and its checkpoint disagree about --certify; run the scene anew"
            )
        if not chain.is_unchanged(recording.manifest):
            raise RecordingError(f"'{folder / MANIFEST}' was changed by others; run the scene anew")
        if certified:
            require_same_settings(folder, recording.settings, sim.settings.to_dict())
        if not 1 <= frames <= len(recording):
            raise RecordingError(f"'{folder}' holds {len(recording)} frames: must have {frames} to go on")
        recorder = cls.__new__(cls)
        recorder.folder, recorder._lock = folder, lock
        recorder._manifest = {
            "created": _now(),  # where the manifest does not say
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
        recorder._fields = FieldWriter.resumed(sim, recording)
        recorder._take_up_frames(recording, frames, float(sim.time))
        recorder._states = None
        if certified:
            from .states import StateWriter

            recorder._states = StateWriter.resume(
                folder, sim, recorder._chunk_frames, states, chained="chain" in recorder._manifest
            )
        tidy(folder)
        recorder._closed = False
        recorder._go_on(lines)
        remember(sim, recorder, str(recorder._manifest["created"]))
        return recorder

    def _take_up_frames(self, recording: Recording, frames: int, now: float) -> None:
        """The frames of the chunk that is not full, to be written again with more; ``now``: the time [s]
        from which the simulation goes on."""
        self._chunk_index, rest = divmod(frames, self._chunk_frames)
        self._written, self._synced = frames - rest, frames
        chained = "chain" in self._manifest
        self._pending = [
            _Pending(
                float(recording.times[k]),
                [recording.positions(i, k) for i in range(len(recording.bodies))],
                recording.digest(k) if chained else None,
                {} if self._fields is None else recording.field_row(k),
            )
            for k in range(frames - rest, frames)
        ]
        self._times = Forward(self.folder, frame=float(recording.times[frames - 1]), step=now)
        self._frame_chain = self._line_chain = None
        self._frame_head = ""
        if chained:
            self._frame_chain = RowChain.after(recording.digest(frames - 1).tobytes().hex())
            self._frame_head = self._frame_chain.head
            self._line_chain = RowChain(str(self._manifest["chain"].get("seed")), "telemetry")

    def _go_on(self, lines: int) -> None:
        """The manifest goes first: what it counts is there at any moment, so a run that is killed here can be
        resumed once more."""
        kept = first_lines(self.folder / TELEMETRY, lines)
        if self._line_chain is not None and kept:
            self._line_chain.head = digest_of_last(kept)
        self._telemetry, self._kept_lines = None, lines
        self._write_manifest()
        self._telemetry = TelemetryWriter(self.folder / TELEMETRY, kept=kept, chain=self._line_chain)
        drop_chunks_after(self.folder / "frames", self._chunks_on_disk())
        if self._states is not None:
            drop_chunks_after(self.folder / STATES, self._states.manifest["chunk_count"])
        if self._fields is not None:
            drop_chunks_after(self.folder / FIELDS, self._chunks_on_disk())

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
        at = self._times.require("frame", float(sim.time if time is None else time))
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
        values = {} if self._fields is None else self._fields.take(sim)
        row: dict[str, Any] = {
            "times": np.float64(at),
            **{f"positions_{i:04d}": x for i, x in enumerate(frame)},
        }
        digest = None if self._frame_chain is None else self._frame_chain.add_arrays(row)
        self._pending.append(
            _Pending(at, frame, digest, values)
        )  # at once: an interrupt leaves no half frame
        self._times.note("frame", at)
        if len(self._pending) >= self._chunk_frames:
            self._flush_frames()
            self._write_manifest()

    def record_state(self, sim: Any) -> None:
        """Adds the state of ``sim`` in double precision, if the recording is one for certification: after
        every step, and after bodies were placed."""
        if self._closed:
            raise RecordingError(f"recording '{self.folder}' is closed; states can no longer be added")
        if self._states is None:
            return
        at = self._times.require("state", float(sim.time))
        full = self._states.write(sim)
        self._times.note("state", at)
        if full:
            self._write_manifest()

    def report(self, step_report: Any, **extra: float | Mapping[str, float]) -> None:
        """Adds one line of telemetry; ``extra`` are further numbers, or groups of them, in SI units."""
        if self._closed:
            raise RecordingError(f"recording '{self.folder}' is closed; reports can no longer be added")
        assert self._telemetry is not None
        if not hasattr(step_report, "newton_iterations"):
            raise RecordingError(f"report: {step_report!r}: must be the report that sim.step() returned")
        at = self._times.require("step", float(step_report.time))
        self._telemetry.write(step_report, **extra)
        self._times.note("step", at)

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

    def sync(self) -> dict[str, int]:
        """Writes all that was recorded, so that a killed run has it, and returns what ``resume`` needs to go
        on from here: keep it in the ``memory`` of a checkpoint. The last chunk is written again when it has
        grown: where frames are stored does not depend on when this is called."""
        if self.frame_count > self._synced and self._pending:
            self._write_chunk()
        if self._states is not None:
            self._states.sync()
        assert self._telemetry is not None
        self._telemetry.sync()
        self._write_manifest()
        return {"frames": self.frame_count, "lines": self.line_count, "states": self.state_count}

    def sync_if_open(self) -> None:
        """``sync()``, unless it is closed."""
        if not self._closed:
            self.sync()

    def _write_chunk(self) -> None:
        """A body that did not move in the chunk is stored once."""
        times = [frame.time for frame in self._pending]
        arrays: dict[str, np.ndarray] = {"times": np.array(times, dtype=np.float64)}
        for i in range(len(self._entries)):
            track = [frame.positions[i] for frame in self._pending]
            arrays[f"positions_{i:04d}"] = np.stack(track[:1] if chain.is_still(track) else track)
        digests = [frame.digest for frame in self._pending if frame.digest is not None]
        if digests:
            arrays[chain.ARRAY] = np.stack(digests)
            self._frame_head = digests[-1].tobytes().hex()
        if self._fields is not None:
            write_chunk(self.folder, self._chunk_index, [frame.values for frame in self._pending])
        write_arrays(self.folder / chunk_path(self._chunk_index), arrays)
        self._synced = self.frame_count

    @property
    def last_time(self) -> float:
        """Time of the last frame [s], minus infinity before the first."""
        return self._times.last_frame

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
        return self._kept_lines if self._telemetry is None else self._telemetry.line_count

    def _chunks_on_disk(self) -> int:
        return self._chunk_index + (1 if self._synced > self._written else 0)

    def _write_manifest(self) -> None:
        """Counts what is on disk, never less than an earlier manifest did: a checkpoint may rest on that."""
        self._manifest["frame_count"] = max(self._synced, self._written)
        self._manifest["chunk_count"] = self._chunks_on_disk()
        if self._states is not None:
            self._manifest["states"] = self._states.manifest
        if "chain" in self._manifest:
            assert self._line_chain is not None
            self._manifest["chain"] |= {
                "frames": self._frame_head,
                "lines": self.line_count,
                "telemetry": self._line_chain.head,
            }
            if self._states is not None:
                self._manifest["chain"]["states"] = self._states.head
        whole = chain.sealed(self._manifest) if "chain" in self._manifest else self._manifest
        text = json.dumps(whole, indent=1, allow_nan=False) + "\n"
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
        assert self._telemetry is not None
        try:
            self._telemetry.sync()
            self.flush()
        finally:
            self._telemetry.close()
            self._lock.release()

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
