"""The chain of digests of a recording: what was written, in the order in which it was written.

Frames, states and lines of telemetry have a chain each. The digest of a row is the SHA-256 of the digest of
the row before and of the row itself, so a row that is changed, left out or exchanged does not fit what
follows. The first row follows the seed, the digest of the files that do not change. The manifest holds the
last digest of each chain, and a digest of itself. docs/verify.md says what that shows and what it does not;
the checker has a reading of its own (stark.verify.chain)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..files import open_regular

VERSION = 1

#: A digest in arrays of chunks, and in lines of telemetry.
ARRAY = "chain"
KEY = "chain"


def seed(folder: Path, names: list[str]) -> str:
    """Digest of the files that do not change: of the lines ``sha256  path``, sorted by path."""
    lines = []
    for name in sorted(names):
        with open_regular(folder / name) as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()  # type: ignore[arg-type]
        lines.append(f"{digest}  {name}\n")
    return hashlib.sha256("".join(lines).encode()).hexdigest()


class RowChain:
    """The chain of one kind of rows. ``head`` is the digest of the last one, in hexadecimal digits."""

    def __init__(self, seed: str, kind: str) -> None:
        self.head: str = hashlib.sha256(f"stark {kind} {seed}".encode()).hexdigest()

    @classmethod
    def after(cls, head: str) -> RowChain:
        """Goes on after a row of this digest."""
        chain = cls.__new__(cls)
        chain.head = head
        return chain

    def add_arrays(self, row: Mapping[str, np.ndarray]) -> np.ndarray:
        """Digest of a row of arrays, as (32,) uint8: of names, types, shapes and bytes, sorted by name."""
        digest = hashlib.sha256(self.head.encode())
        for name in sorted(row):
            array = np.asarray(row[name], order="C")
            digest.update(f"\n{name} {array.dtype.str} {array.shape}\n".encode())
            digest.update(array.tobytes())
        self.head = digest.hexdigest()
        return np.frombuffer(digest.digest(), dtype=np.uint8)

    def add_line(self, text: str) -> str:
        """A JSON object on one line, with its digest as the last entry."""
        self.head = hashlib.sha256(f"{self.head}\n{text}".encode()).hexdigest()
        return f'{text[:-1]},"{KEY}":"{self.head}"}}'


def is_still(track: list[np.ndarray]) -> bool:
    """Whether all arrays have the same bytes, and can be stored once. Equal numbers would not do: the digest
    of -0 is not that of 0."""
    first = track[0].tobytes()
    return all(array.tobytes() == first for array in track[1:])


def sealed(manifest: dict[str, Any]) -> dict[str, Any]:
    """The manifest with a digest of all of its other entries."""
    chain = {key: value for key, value in manifest["chain"].items() if key != "manifest"}
    open_manifest = {**manifest, "chain": chain}
    return {**open_manifest, "chain": {**chain, "manifest": _digest(open_manifest)}}


def is_unchanged(manifest: dict[str, Any]) -> bool:
    """Whether the manifest is as it was written; that of a recording without a chain may be anything."""
    chain = manifest.get("chain")
    if chain is None:
        return True
    return isinstance(chain, dict) and chain.get("manifest") == sealed(manifest)["chain"]["manifest"]


def _digest(manifest: dict[str, Any]) -> str:
    text = json.dumps(manifest, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
