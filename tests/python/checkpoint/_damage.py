"""Seeded damage to files: what disks, transfers and editors do to them, and worse."""

from __future__ import annotations

import contextlib
import json
import os
from typing import Any

import numpy as np

import stark

#: Mutations of each kind, always the same; STARK_NIGHTLY=1 draws more, and new ones.
NIGHTLY = os.environ.get("STARK_NIGHTLY") == "1"
COUNT = 4000 if NIGHTLY else 150
SEED = int.from_bytes(os.urandom(4), "little") if NIGHTLY else 11

_TYPES = ("f4", "i4", "u1", "i8", "?", "c16", "U4")
_ODD = (np.nan, np.inf, -1.0, 0.0, 1e300, 1e-300, 17.0)

STRANGE = (None, True, -1, 0, 7, 10**400, 1e308, float("nan"), "", "x" * 300, [], {}, [[]], {"$array": "no"})


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """The file cut off, with flipped bits, overwritten, shuffled or grown in places."""
    kind, size = rng.integers(8), len(data)
    at = int(rng.integers(size)) if size else 0
    span = int(rng.integers(1, 64))
    changed = bytearray(data)
    if kind == 0:
        return data[:at]
    if kind == 1:
        return data[at:]
    if kind in (2, 3) and size:
        for place in rng.integers(size, size=1 if kind == 2 else 20):
            changed[place] ^= 1 << int(rng.integers(8))
    elif kind == 4:
        changed[at : at + span] = rng.bytes(len(changed[at : at + span]))
    elif kind == 5:
        del changed[at : at + span]
    elif kind == 6:
        changed[at:at] = rng.bytes(span)
    else:  # the end of a zip file says where everything is
        tail = max(0, size - 1 - int(rng.integers(0, 400)))
        changed[tail : tail + 4] = rng.bytes(len(changed[tail : tail + 4]))
    return bytes(changed)


def strange_json(value: Any, rng: np.random.Generator) -> Any:
    """A copy of a JSON value with one node replaced, removed or doubled."""
    copied = json.loads(json.dumps(value))
    place: Any = copied
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            return copied
        key = keys[int(rng.integers(len(keys)))]
        if isinstance(place[key], (dict, list)) and place[key] and rng.random() < 0.6:
            place = place[key]
            continue
        action = rng.integers(4)
        if action == 0:
            del place[key]
        elif action == 1 and isinstance(place, list):
            place.append(place[key])
        else:
            place[key] = STRANGE[int(rng.integers(len(STRANGE)))]
        return copied


def strange_arrays(
    header: dict[str, Any], arrays: dict[str, np.ndarray], rng: np.random.Generator
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Header and arrays of a checkpoint, one array of another type, shape or value, with hashes that fit."""
    changed = {name: array.copy() for name, array in arrays.items()}
    chosen = list(changed)[int(rng.integers(len(changed)))]
    array, kind = changed[chosen], rng.integers(6)
    if kind == 0:
        del changed[chosen]
    elif kind == 1:
        changed[chosen] = array.astype(str(rng.choice(_TYPES)))
    elif kind == 2:
        changed[chosen] = array.reshape(-1)[:-1] if array.size else np.zeros(4)
    elif kind == 3:
        changed[chosen] = array[None]
    elif array.size and array.dtype.kind == "f":
        array.reshape(-1)[int(rng.integers(array.size))] = rng.choice(_ODD)
    mended = {**header}
    for folder, key in (("state", "state_hash"), ("before", "before_hash")):
        fields = {n.partition("/")[2]: a for n, a in changed.items() if n.startswith(folder + "/")}
        with contextlib.suppress(stark.Error):
            mended[key] = stark._core.State.of_arrays(fields).hash
    return mended, changed
