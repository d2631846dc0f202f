"""Compresses recorded fields and contacts for the page.

A field of a body is a number of ``LEVELS`` steps between the least and the largest value of the field in all
frames, as differences in time modulo 65536, low and high bytes apart. Contacts of a frame are those of the
largest forces, points and forces as float32, pairs of bodies as uint16.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..recording import Recording

#: Steps between the limits of a field.
LEVELS = 4095
#: Contacts of a frame that the page shows.
MOST_CONTACTS = 300
#: Colours end at this share of the values, where few are much larger.
_SHARE = 0.98

Add = Callable[[bytes], int]


def encode_fields(
    recording: Recording, kept: Sequence[int], add: Add, deflate: Callable[[bytes], bytes]
) -> list[dict[str, Any]]:
    """Entries of the header, one a field. ``kept`` are the frames of the page; ``add`` stores a block."""
    result = []
    for entry in recording.fields:
        if not entry.bodies:
            continue
        frames = [recording.field(entry.name, k) for k in kept]
        names = [recording.bodies[i].name for i in entry.bodies]
        tracks = [np.stack([frame[name] for frame in frames]).astype(np.float64) for name in names]
        low = min(float(track.min(initial=0.0)) for track in tracks)
        high = max(float(track.max(initial=low)) for track in tracks)
        step = (high - low) / LEVELS or 1.0
        blocks = {}
        for i, track in zip(entry.bodies, tracks, strict=True):
            q = np.rint((track - low) / step).astype(np.int64)
            q[1:] = np.diff(q, axis=0)
            blocks[str(i)] = add(deflate(split_bytes(q & 0xFFFF)))
        result.append(
            {
                "name": entry.name,
                "label": entry.label,
                "unit": entry.unit,
                "low": low,
                "step": step,
                "limits": _limits(tracks, low, high),
                "blocks": blocks,
            }
        )
    return result


def _limits(tracks: Sequence[np.ndarray], low: float, high: float) -> list[float]:
    """Of the colours: those of the values, but for a few that are much larger than all others."""
    every = np.concatenate([track.ravel() for track in tracks])
    every = every[every != 0.0]
    if len(every) and low >= 0.0:
        usual = float(np.quantile(every, _SHARE, method="lower"))
        high = usual if high > 1.5 * usual > 0.0 else high
    return [low, high if high > low else low + 1.0]


def decode_field(data: bytes, low: float, step: float, vertex_count: int) -> np.ndarray:
    """Values (frames, n) of a body, from the inflated block: what the page shows."""
    planes = np.frombuffer(data, dtype=np.uint8).reshape(2, -1).astype(np.uint16)
    delta = (planes[0] | (planes[1] << 8)).reshape(-1, vertex_count)
    return low + step * np.cumsum(delta, axis=0, dtype=np.uint16).astype(np.float64)


def encode_contacts(
    recording: Recording, kept: Sequence[int], add: Add, deflate: Callable[[bytes], bytes]
) -> dict[str, Any] | None:
    """The entry of the header, None where contacts were not recorded or there are none."""
    if not recording.has_contacts:
        return None
    counts, points, forces, pairs, sums = [], [], [], [], []
    for k in kept:
        found = recording.contacts(k)
        largest = np.argsort(-np.linalg.norm(found.forces, axis=1), kind="stable")[:MOST_CONTACTS]
        counts.append(len(largest))
        points.append(found.points[largest])
        forces.append(found.forces[largest])
        pairs.append(found.bodies[largest])
        sums.append(found.body_forces)
    if not sum(counts):
        return None
    lengths = np.linalg.norm(np.concatenate(forces), axis=1)
    return {
        "counts": counts,
        "largest": float(lengths.max()),
        "usual": float(np.quantile(lengths[lengths > 0.0], 0.98)) if np.any(lengths > 0.0) else 0.0,
        "bodies": int(sums[0].shape[0]),
        "points": add(deflate(np.concatenate(points).astype("<f4").tobytes())),
        "forces": add(deflate(np.concatenate(forces).astype("<f4").tobytes())),
        "pairs": add(deflate(np.concatenate(pairs).astype("<u2").tobytes())),
        "sums": add(deflate(np.stack(sums).astype("<f4").tobytes())),
    }


def split_bytes(values: np.ndarray) -> bytes:
    """Low bytes of 16-bit numbers, then the high ones."""
    values = np.ascontiguousarray(values, dtype="<u2").reshape(-1)
    return (values & 255).astype(np.uint8).tobytes() + (values >> 8).astype(np.uint8).tobytes()
