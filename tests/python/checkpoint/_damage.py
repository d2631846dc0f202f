"""Seeded damage to files: what disks, transfers and editors do to them, and worse."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

#: Mutations of each kind, always the same; STARK_NIGHTLY=1 draws more, and new ones.
NIGHTLY = os.environ.get("STARK_NIGHTLY") == "1"
COUNT = 4000 if NIGHTLY else 150
SEED = int.from_bytes(os.urandom(4), "little") if NIGHTLY else 11

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
