"""Compresses a recording for the page, and the matching decoder that the tests compare with.

Three kinds of bodies:

* ``fixed``: the surface never moves; its vertices are stored once as float32.
* ``rigid``: vertices of the first frame as float32, then per frame a rotation (quaternion w, x, y, z) and a
  translation as float32, x = R X + t, found by the least-squares fit of [Kabsch 1976] and kept only when it
  reproduces every vertex within ``_RIGID_TOLERANCE`` of the body's size.
* ``mesh``: positions on a grid of 65535 steps over the longest side of the body's bounding box, taken over
  a range of ``RANGE_FRAMES`` frames. The first frame of a range holds differences to the previous vertex,
  the others differences in time (second differences from the third frame on), all modulo 65536. Low and
  high bytes are stored apart, which the deflate that follows likes better.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from stark.body_kinds import has_pose

from ..arguments import real_number, shown_value
from ..palette import body_colors
from ..recording import Recording, RecordingError
from ..recording.reader import given_recording
from ..render.camera import up_of
from .encode_fields import encode_contacts, encode_fields, split_bytes

RANGE_FRAMES = 64
#: Bytes of one vertex and frame after compression, measured on cloth; used to choose the frame stride.
_BYTES_PER_VERTEX = 4.0
_RIGID_TOLERANCE = 2e-6
PAGE_FORMAT = 1


@dataclass
class EncodedReplay:
    """``header`` is JSON for the page; ``blocks`` are raw-deflate streams that the header refers to by
    index."""

    header: dict[str, Any]
    blocks: list[bytes]

    @property
    def size(self) -> int:
        """Length of the encoded data [bytes]."""
        return sum(len(block) for block in self.blocks)


def _deflate(data: bytes) -> bytes:
    compressor = zlib.compressobj(6, zlib.DEFLATED, -15)
    return compressor.compress(data) + compressor.flush()


def _inflate(data: bytes) -> bytes:
    return zlib.decompress(data, -15)


#: Coordinates that can be displayed are smaller [m]; their squares have to be finite in single precision.
_LARGEST = 1e18


def choose_stride(recording: Recording, max_megabytes: float) -> int:
    """Smallest frame stride whose estimated page size stays below ``max_megabytes``."""
    if not real_number(max_megabytes, "replay: max_megabytes") > 0.0:
        raise RecordingError(f"replay: max_megabytes = {max_megabytes}: must be > 0")
    vertices = sum(body.vertex_count for body in recording.bodies if not has_pose(body))
    estimate = vertices * len(recording) * _BYTES_PER_VERTEX
    for entry in recording.fields:
        estimate += sum(recording.bodies[i].vertex_count for i in entry.bodies) * len(recording)
    estimate *= 4.0 / 3.0  # base64 adds a third
    return max(1, int(np.ceil(estimate / (max_megabytes * 1e6))))


def _fit_rigid(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Rotations (k, 3, 3) and translations (k, 3) that carry the first of ``positions`` (k, n, 3) to each,
    or None."""
    rest = positions[0]
    center = rest.mean(axis=0)
    arms = rest - center
    centers = positions.mean(axis=1)
    u, s, vt = np.linalg.svd(np.einsum("kni,nj->kij", positions - centers[:, None], arms))
    sign = np.ones_like(s)
    sign[:, 2] = np.sign(np.linalg.det(u @ vt))
    rotations = (u * sign[:, None, :]) @ vt
    translations = centers - np.einsum("kij,j->ki", rotations, center)
    fitted = np.einsum("kij,nj->kni", rotations, rest) + translations[:, None]
    size = float(np.abs(arms).max(initial=0.0)) + float(np.abs(positions).max(initial=0.0))
    if np.abs(fitted - positions).max(initial=0.0) > _RIGID_TOLERANCE * max(size, 1e-12):
        return None
    return rotations, translations


def _quaternions(rotations: np.ndarray) -> np.ndarray:
    """Unit quaternions (k, 4) as w, x, y, z of rotations (k, 3, 3), neighbours in time on the same
    hemisphere.

    Each is the eigenvector of the largest eigenvalue of Bar-Itzhack's symmetric 4x4 matrix, so no case is
    special.
    """
    r = rotations
    m = np.zeros((len(r), 4, 4))
    m[:, 0, 0] = r[:, 0, 0] + r[:, 1, 1] + r[:, 2, 2]
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        m[:, 0, i + 1] = m[:, i + 1, 0] = r[:, k, j] - r[:, j, k]
        m[:, i + 1, i + 1] = r[:, i, i] - r[:, j, j] - r[:, k, k]
        m[:, j + 1, k + 1] = m[:, k + 1, j + 1] = r[:, j, k] + r[:, k, j]
    quaternions = np.linalg.eigh(m)[1][:, :, -1]
    for k in range(1, len(quaternions)):
        if np.dot(quaternions[k], quaternions[k - 1]) < 0.0:
            quaternions[k] *= -1.0
    return quaternions


def _join_bytes(data: bytes) -> np.ndarray:
    planes = np.frombuffer(data, dtype=np.uint8).reshape(2, -1).astype(np.uint16)
    joined: np.ndarray = planes[0] | (planes[1] << 8)
    return joined


def _encode_range(positions: np.ndarray) -> tuple[list[float], float, bytes]:
    """Lower corner [m], grid step [m] and compressed differences of ``positions`` (k, n, 3) float64."""
    low = positions.min(axis=(0, 1))
    extent = float((positions.max(axis=(0, 1)) - low).max())
    step = extent / 65535.0 if extent > 0.0 else 1.0
    q = np.rint((positions - low) / step).astype(np.int64)
    delta = np.empty_like(q)
    delta[0] = np.diff(q[0], axis=0, prepend=0)
    delta[1:] = np.diff(q, axis=0)
    if len(q) > 2:
        delta[2:] = np.diff(q, n=2, axis=0)
    return [float(value) for value in low], step, _deflate(split_bytes(delta & 0xFFFF))


def _decode_range(data: bytes, frame_count: int, vertex_count: int) -> np.ndarray:
    """Grid coordinates (k, n, 3) uint16 of one range; modular sums undo the differences."""
    delta = _join_bytes(_inflate(data)).reshape(frame_count, vertex_count, 3)
    q = np.empty_like(delta)
    q[0] = np.cumsum(delta[0], axis=0, dtype=np.uint16)
    for k in range(1, frame_count):
        q[k] = q[k - 1] + delta[k] if k == 1 else 2 * q[k - 1] - q[k - 2] + delta[k]
    return q


def encode(recording: Recording, *, stride: int | None = None, max_megabytes: float = 60.0) -> EncodedReplay:
    """Compresses every ``stride``-th frame and the last; ``stride`` None picks one for ``max_megabytes``."""
    given_recording(recording, "replay")
    if not len(recording):
        raise RecordingError(f"'{recording.folder}' has no frames; there is nothing to replay")
    if stride is None:
        stride = choose_stride(recording, max_megabytes)
    if not isinstance(stride, (int, np.integer)) or stride < 1:
        raise RecordingError(f"frame stride = {stride!r}; must be at least 1, and whole")
    stride = int(stride)
    kept = list(range(0, len(recording), stride))
    if kept[-1] != len(recording) - 1:
        kept.append(len(recording) - 1)

    blocks: list[bytes] = []

    def add(data: bytes) -> int:
        blocks.append(data)
        return len(blocks) - 1

    bodies = []
    colors = body_colors(recording.bodies)
    for i, body in enumerate(recording.bodies):
        entry: dict[str, Any] = {
            "name": body.name,
            "kind": body.kind,
            "motion": body.motion,
            "color": [round(float(c), 4) for c in colors[i]],
            "vertices": body.vertex_count,
            "triangles": body.triangle_count,
            "index": add(_deflate(recording.triangles(i).astype("<u4").tobytes())),
        }
        entry.update(_encode_body(recording, i, kept, add))
        bodies.append(entry)
    header = {
        "format": PAGE_FORMAT,
        "scene": recording.scene,
        "status": recording.status,
        "stark_version": str(recording.manifest.get("stark_version", "")),
        "created": str(recording.manifest.get("created", "")),
        "stride": stride,
        "times": [round(float(recording.times[k]), 9) for k in kept],
        "up": list(up_of(recording)),
        "bodies": bodies,
        "fields": encode_fields(recording, kept, add, _deflate),
        "contacts": encode_contacts(recording, kept, add, _deflate),
    }
    return EncodedReplay(header, blocks)


def _encode_body(recording: Recording, which: int, kept: list[int], add: Any) -> dict[str, Any]:
    for k in kept:
        if not np.abs(recording.positions(which, k)).max(initial=0.0) < _LARGEST:
            name = recording.bodies[which].name
            raise RecordingError(
                f"body '{name}': its positions in frame {k} are not finite, or beyond {_LARGEST:g} m; only "
                f"others can be displayed"
            )
    first = recording.positions(which, kept[0])
    if recording.bodies[which].vertex_count == 0:
        return {"mode": "fixed", "rest": add(_deflate(b""))}
    if all(np.array_equal(recording.positions(which, k), first) for k in kept[1:]):
        return {"mode": "fixed", "rest": add(_deflate(first.astype("<f4").tobytes()))}
    if has_pose(recording.bodies[which]):
        fit = _fit_rigid(np.stack([recording.positions(which, k) for k in kept]).astype(np.float64))
        if fit is not None:
            poses = np.concatenate([_quaternions(fit[0]), fit[1]], axis=1)
            return {
                "mode": "rigid",
                "rest": add(_deflate(first.astype("<f4").tobytes())),
                "poses": add(_deflate(poses.astype("<f4").tobytes())),
            }
    ranges = []
    for start in range(0, len(kept), RANGE_FRAMES):
        part = kept[start : start + RANGE_FRAMES]
        low, step, data = _encode_range(
            np.stack([recording.positions(which, k) for k in part]).astype(np.float64)
        )
        ranges.append({"start": start, "count": len(part), "low": low, "step": step, "block": add(data)})
    return {"mode": "mesh", "ranges": ranges}


def _number(given: Any, count: int, what: str) -> int:
    if isinstance(given, bool) or not isinstance(given, (int, np.integer)) or not 0 <= given < count:
        raise RecordingError(f"decode: {what} = {shown_value(given)}: must be a number in [0, {count})")
    return int(given)


def decode(replay: EncodedReplay, body: int, frame: int) -> np.ndarray:
    """Positions (n, 3) float64 [m] of a body at a frame of the page: what the page draws there."""
    if not isinstance(replay, EncodedReplay):
        raise RecordingError(f"decode: replay = {shown_value(replay)}: must be what encode returned")
    body = _number(body, len(replay.header["bodies"]), "body")
    frame = _number(frame, len(replay.header["times"]), "frame")
    entry = replay.header["bodies"][body]
    count = entry["vertices"]
    if entry["mode"] == "mesh":
        part = next(r for r in entry["ranges"] if r["start"] <= frame < r["start"] + r["count"])
        q = _decode_range(replay.blocks[part["block"]], part["count"], count)[frame - part["start"]]
        positions: np.ndarray = np.array(part["low"]) + part["step"] * q.astype(np.float64)
        return positions
    rest = (
        np.frombuffer(_inflate(replay.blocks[entry["rest"]]), dtype="<f4")
        .reshape(count, 3)
        .astype(np.float64)
    )
    if entry["mode"] == "fixed":
        return rest
    pose = (
        np.frombuffer(_inflate(replay.blocks[entry["poses"]]), dtype="<f4")
        .reshape(-1, 7)[frame]
        .astype(np.float64)
    )
    w, v = pose[0], pose[1:4]
    turned = rest + 2.0 * np.cross(v, np.cross(v, rest) + w * rest)
    placed: np.ndarray = turned + pose[4:]
    return placed
