"""Names and values shared by the recording's writer and reader."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .._core import InvalidArgument

FORMAT_NAME = "stark-recording"
FORMAT_VERSION = 1
#: Frames in one chunk file; also the largest number of frames that a killed run loses between checkpoints.
CHUNK_FRAMES = 32
MANIFEST = "manifest.json"
TELEMETRY = "telemetry.jsonl"
TOPOLOGY = "frames/topology.npz"
STATES = "states"
FIELDS = "fields"
CERTIFICATE = "certificate.json"
PAGE = "replay.html"
#: Of ``stark run``: the last frame, and the step that failed (stark.reproducer).
PICTURE = "picture.png"
FAILURE = "failure"
#: What other commands make of a recording, under the names that they take where none is given.
MADE_LATER = (
    *("still.png", "video.mp4"),
    *("vtu", "ply", "obj", "vtkhdf", "usd", "glb", "pc2", "parquet", "mcap"),
)
#: Held by the process that writes the folder, see stark.recording.lock.
LOCK = "run.lock"
STATES_VERSION = 2
#: Where a run can be resumed from, see stark.checkpoint.
CHECKPOINT = "checkpoint.stark"


class RecordingError(InvalidArgument):
    """A recording that cannot be written or read: names folder or file, defect and remedy."""


@dataclass(frozen=True)
class BodyEntry:
    """One body of a recording. ``color`` is sRGB in [0, 1], or None for the viewer's palette."""

    name: str
    kind: str
    motion: str
    vertex_count: int
    triangle_count: int
    color: tuple[float, float, float] | None = None

    def to_json(self) -> dict[str, Any]:
        """The entry as the manifest has it: a dictionary."""
        return asdict(self)


@dataclass(frozen=True)
class FrameBody:
    """A body at one time: ``positions`` (n, 3) float32 [m] in the world, ``triangles`` (m, 3) int32."""

    name: str
    kind: str
    motion: str
    positions: np.ndarray
    triangles: np.ndarray
    color: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Frame:
    """All bodies at one time [s]."""

    index: int
    time: float
    bodies: tuple[FrameBody, ...]
    recorded: Any = None
    """The recording that it is of, which knows its fields and contacts."""


def chunk_path(index: int) -> str:
    return f"frames/chunk_{index:06d}.npz"


def field_path(index: int) -> str:
    return f"{FIELDS}/chunk_{index:06d}.npz"


def shown_mesh(body: Any) -> Any:
    """The mesh that a rigid body shows instead of the one that touches; None where there is none. Kinds that
    have no such attribute are not asked for it: they would look for what was meant, in 50 us."""
    return body.shown if hasattr(type(body), "shown") else None


def surface(body: Any) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3) [m] and triangles (m, 3) of the drawn surface of a body; a solid leaves out its inner
    vertices, a rigid body may have a mesh to be shown instead of that which touches."""
    shown = shown_mesh(body)
    if shown is not None:
        position, rotation = body.pose
        return shown.vertices @ rotation.T + position, shown.triangles
    positions = getattr(body, "surface_positions", None)  # hasattr() would compute them once more
    if positions is not None:
        return np.asarray(positions), np.asarray(body.surface_triangles)
    return np.asarray(body.positions), np.asarray(body.triangles)


def drawn(source: Any) -> list[Any]:
    """Bodies of a simulation or a frame, and the layers of bodies that are to be seen."""
    if not hasattr(source, "bodies") or isinstance(source, type):
        raise RecordingError(f"sim = {source!r}: must be a stark.Simulation")
    if hasattr(source, "telemetry"):
        raise RecordingError(
            f"{source!r} is a recording: must be a simulation, or a frame: recording.frame(-1)"
        )
    return [*source.bodies, *(layer for layer in getattr(source, "layers", ()) if layer._is_drawn())]
