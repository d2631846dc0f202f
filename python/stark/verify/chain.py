"""The chain of digests: whether a recording is what was written, row by row.

Computed here once more from the rows themselves. Whoever edits a recording can compute all digests anew: the
chain shows damage, exchange and careless edits, and gives one number, the digest of the manifest, that stands
for the whole recording when it is kept elsewhere (docs/verify.md)."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .certificate import NOT_RECORDED, VERIFIED, VIOLATED, Claim
from .files import need, read_lines
from .run import Run

_VERSION = 1
_DIGEST = re.compile(rb',"chain":"([0-9a-f]{64})"\}\n?\Z')
_LISTED = 4  # problems named in a certificate


@dataclass
class ChainCheck:
    """``row()`` for each state and each frame, in order, and ``lines()``; then ``claim()``."""

    run: Run
    problems: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        given = self.run.manifest.get("chain")
        need(
            given is None or isinstance(given, dict),
            f"'{self.run.folder}/manifest.json': chain must be an object",
        )
        self.given: dict[str, Any] = given or {}
        self.recorded: bool = given is not None
        seed = _seed(self.run.files)
        #: The recorded one where it differs: rows are judged on their own.
        self.seed: str = str(self.given.get("seed", seed))
        self.heads: dict[str, str] = {
            kind: _start(kind, self.seed) for kind in ("states", "frames", "telemetry")
        }
        self._broken: set[str] = set()
        if not self.recorded:
            return
        version = self.given.get("version")
        need(
            version == _VERSION,
            f"'{self.run.folder}/manifest.json': chain has version {version!r}, not {_VERSION}",
        )
        if self.seed != seed:
            self.problems.append("meshes or the description of the scene are not those of the recording")
        if self.given.get("manifest") != _digest_of_manifest(self.run.manifest):
            self.problems.append("the manifest was changed")

    def row(self, kind: str, index: int, row: dict[str, np.ndarray], digest: np.ndarray | None) -> None:
        """A row of arrays and the digest that is recorded with it."""
        if kind in self._broken or (not self.recorded and digest is None):
            return
        if digest is None or not self.recorded:
            self._break(kind, f"{kind[:-1]} {index} lacks its digest" if self.recorded else "")
            return
        hashed = hashlib.sha256(self.heads[kind].encode())
        for name in sorted(row):
            array = np.asarray(row[name], order="C")
            hashed.update(f"\n{name} {array.dtype.str} {array.shape}\n".encode())
            hashed.update(array.tobytes())
        self.heads[kind] = hashed.hexdigest()
        if digest.tobytes() != hashed.digest():
            self._break(kind, f"{kind[:-1]} {index} is not the one that was recorded there")

    def _break(self, kind: str, problem: str) -> None:
        self._broken.add(kind)
        self.problems.append(problem or f"{kind} have digests, the manifest has none")

    def lines(self) -> None:
        """Lines of telemetry, as they are written."""
        counted, count = None, 0
        for number, line in read_lines(self.run.folder / "telemetry.jsonl"):
            found = _DIGEST.search(line)
            if not line.endswith(b"\n") or (found is None and not self.recorded):
                continue
            if found is None or not self.recorded:
                self._break(
                    "telemetry", f"line {number} of telemetry lacks its digest" if self.recorded else ""
                )
                return
            text = self.heads["telemetry"].encode() + b"\n" + line[: found.start()] + b"}"
            self.heads["telemetry"] = hashlib.sha256(text).hexdigest()
            if self.heads["telemetry"].encode() != found[1]:
                self._break("telemetry", f"line {number} of telemetry is not the one that was recorded there")
                return
            count = number
            if number == self.given.get("lines"):
                counted = self.heads["telemetry"]
        if not self.recorded:
            return
        counted = _start("telemetry", self.seed) if self.given.get("lines") == 0 else counted
        ended = self.run.manifest.get("status") != "running"
        if counted != self.given.get("telemetry") or (ended and count != self.given.get("lines")):
            self._break(
                "telemetry", f"telemetry has {count} lines, recorded were {self.given.get('lines')!r}"
            )

    def claim(self) -> Claim:
        name, basis = "chain", "digests of states, frames, telemetry and manifest"
        statement = "nothing was changed, left out or exchanged since it was recorded, digests being genuine"
        if not self.recorded and not self.problems:
            detail = "no chain: recorded by an older version"
            return Claim(name, statement, NOT_RECORDED, basis, detail=detail, required=False)
        kinds = ["frames", *(["states"] if self.run.has_states else [])]
        for kind in kinds:
            if kind not in self._broken and self.recorded and self.heads[kind] != self.given.get(kind):
                self._break(kind, f"{kind} do not end as they did when they were recorded")
        more = f" and {len(self.problems) - _LISTED} more" if len(self.problems) > _LISTED else ""
        detail = "; ".join(self.problems[:_LISTED]) + more
        status = VIOLATED if self.problems else VERIFIED
        return Claim(name, statement, status, basis, detail=detail, required=False)


def _seed(files: dict[str, str]) -> str:
    """Digest of the files that do not change while a run is recorded."""
    still = ("frames/topology.npz", "states/scene.json", "states/mesh.npz")
    lines = "".join(f"{files[name]}  {name}\n" for name in sorted(still) if name in files)
    return hashlib.sha256(lines.encode()).hexdigest()


def _start(kind: str, seed: str) -> str:
    return hashlib.sha256(f"stark {kind} {seed}".encode()).hexdigest()


def _digest_of_manifest(manifest: dict[str, Any]) -> str:
    chain = {key: value for key, value in manifest["chain"].items() if key != "manifest"}
    text = json.dumps({**manifest, "chain": chain}, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
