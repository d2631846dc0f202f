"""Frames for display, against the states: what pictures and the replay show is what was certified."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .certificate import INCONCLUSIVE, NOT_RECORDED, VERIFIED, VIOLATED, Claim
from .chain import ChainCheck
from .files import need, read_npz
from .run import Body, Run, State

Floats = NDArray[np.float64]

_SINGLE = 2.0**-23  # rounding of float32


@dataclass(frozen=True)
class Drawn:
    """A body or layer as it is displayed."""

    name: str
    vertex_count: int
    triangles: NDArray[np.int64]


@dataclass
class FrameCheck:
    """``run()`` goes through all frames, then ``claim()``."""

    run: Run
    chain: ChainCheck
    count: int = 0
    without_state: int = 0
    layers: int = 0  # drawn besides bodies
    wrong: list[dict[str, Any]] = field(default_factory=list)
    worst: float = 0.0  # [m]

    def check(self) -> None:
        drawn = _drawn(self.run)
        shown = [_Shown.of(d, b) for d, b in zip(drawn, self.run.bodies, strict=False)]
        self.layers = len(drawn) - len(shown)
        for d, of_body in zip(drawn, shown, strict=False):
            if of_body is None:
                self.wrong.append({"bodies": [d.name], "what": "another mesh is displayed"})
        for index, time, row, digest in _frames(self.run, drawn):
            self.chain.row("frames", index, row, digest)
            self.count += 1
            if self.run.has_states:
                self._compare(index, time, row, shown)

    def _compare(
        self, index: int, time: float, row: dict[str, np.ndarray], shown: list[_Shown | None]
    ) -> None:
        at = int(np.searchsorted(self.run.times, time))
        if at == len(self.run.times) or self.run.times[at] != time:
            self.without_state += 1
            return
        state = self.run.state(at)
        if _is_exact(row, shown, state):
            return
        # Bodies may have been placed at that time, before the frame was recorded or after.
        for other in range(at + 1, len(self.run.times)):
            if self.run.times[other] != time or self._shows(row, shown, state):
                break
            state = self.run.state(other)
        for i, of_body in enumerate(shown):
            if of_body is None:
                continue
            off = of_body.difference(row[f"positions_{i:04d}"], state, i)
            if not off <= 0.0:
                self.worst = max(self.worst, off)
                self.wrong.append(
                    {"time": time, "frame": index, "bodies": [of_body.name], "what": f"is off by {off:.3g} m"}
                )

    @staticmethod
    def _shows(row: dict[str, np.ndarray], shown: list[_Shown | None], state: State) -> bool:
        return all(
            of_body is None or of_body.difference(row[f"positions_{i:04d}"], state, i) <= 0.0
            for i, of_body in enumerate(shown)
        )

    def claim(self) -> Claim:
        name, basis = "display", "frames against states"
        statement = "bodies are displayed where the states have them"
        if not self.run.has_states:
            detail = "there are no states to compare with"
            return Claim(name, statement, NOT_RECORDED, basis, detail=detail, required=False)
        if self.wrong:
            first = self.wrong[0]
            at = f" in frame {first['frame']}" if "frame" in first else ""
            detail = f"'{first['bodies'][0]}': {first['what']}{at}; {len(self.wrong)} times"
            return Claim(
                name, statement, VIOLATED, basis, self.worst, 0.0, "m", first, detail, required=False
            )
        parts = [f"{self.count} frames"]
        parts += [f"{self.layers} layers are not compared"] if self.layers else []
        parts += [f"{self.without_state} are at times without a state"] if self.without_state else []
        status = INCONCLUSIVE if self.without_state else VERIFIED
        return Claim(name, statement, status, basis, 0.0, 0.0, "m", detail="; ".join(parts), required=False)


@dataclass(frozen=True)
class _Shown:
    """How a displayed body follows from a state: its vertices, a tube around a chain of edges, or a mesh
    that moves with a rigid body."""

    name: str
    vertices: NDArray[np.int64]
    sides: int = 0  # of a tube
    local: Floats | None = None  # of the mesh of a rigid body, in its frame [m]

    @classmethod
    def of(cls, drawn: Drawn, body: Body) -> _Shown | None:
        """None where the mesh is that of something else."""
        if len(body.edges):
            nodes = body.vertex_count
            sides = (drawn.vertex_count - 2) // nodes if nodes else 0
            fits = sides >= 3 and drawn.vertex_count == sides * nodes + 2
            return cls(body.name, np.arange(nodes), sides) if fits else None
        if body.shown is not None and body.has_pose:
            fits = len(body.shown) == drawn.vertex_count
            same = fits and np.array_equal(drawn.triangles, np.asarray(body.shown_triangles))
            return cls(body.name, np.arange(0), local=body.shown) if same else None
        vertices, triangles = np.arange(body.vertex_count), body.triangles.astype(np.int64)
        if drawn.vertex_count != body.vertex_count or body.has_inside:
            vertices, renumbered = np.unique(triangles, return_inverse=True)
            triangles = renumbered.reshape(triangles.shape)
        same = drawn.vertex_count == len(vertices) and np.array_equal(drawn.triangles, triangles)
        return cls(body.name, vertices) if same else None

    def difference(self, frame: np.ndarray, state: State, body: int) -> float:
        """Largest distance from where the state has it, 0 where rounding explains it [m]."""
        positions, pose = state.positions[body], state.poses[body]
        if not np.isfinite(frame).all():
            return float("inf")
        if self.local is not None and pose is not None:
            largest = _largest(frame - (self.local @ pose[1:].T + pose[0]))
            size = float(np.abs(frame).max(initial=0.0))
            return 0.0 if largest <= 2.0 * _SINGLE * size else largest
        if not self.sides:
            exact = positions[self.vertices].astype(np.float32)
            return 0.0 if np.array_equal(frame, exact) else _largest(frame - positions[self.vertices])
        rings = frame[:-2].astype(np.float64).reshape(-1, self.sides, 3)
        off = np.concatenate([rings.mean(axis=1) - positions, frame[-2:] - positions[[0, -1]]])
        size = float(np.abs(frame).max(initial=0.0))
        largest = _largest(off)
        return 0.0 if largest <= 2.0 * _SINGLE * size else largest


def _is_exact(row: dict[str, np.ndarray], shown: list[_Shown | None], state: State) -> bool:
    """Whether all bodies are displayed by their vertices, exactly where a state has them; together, since
    there may be thousands."""
    if any(of_body is None or of_body.sides or of_body.local is not None for of_body in shown):
        return False
    vertices = [of_body.vertices for of_body in shown if of_body is not None]
    frame = np.concatenate([row[f"positions_{i:04d}"] for i in range(len(shown))])
    with np.errstate(over="ignore"):
        exact = np.concatenate([x[v] for x, v in zip(state.positions, vertices, strict=False)])
        same = frame == exact.astype(np.float32)
    return bool(same.all() and np.isfinite(frame).all())


def _largest(off: Floats) -> float:
    return float(np.linalg.norm(off, axis=1).max(initial=0.0))


def _drawn(run: Run) -> list[Drawn]:
    """What the manifest lists, with the triangles of the topology."""
    path = run.folder / "frames/topology.npz"
    arrays = read_npz(path)
    drawn = []
    entries = run.manifest.get("bodies")
    need(isinstance(entries, list), f"'{run.folder / 'manifest.json'}': bodies must be a list")
    for i, entry in enumerate(entries or []):
        triangles = arrays.get(f"triangles_{i:04d}")
        fits = triangles is not None and triangles.ndim == 2 and triangles.dtype.kind == "i"
        need(fits, f"'{path}': triangles of body {i} are missing or have a wrong shape")
        assert triangles is not None
        drawn.append(Drawn(str(entry["name"]), int(entry["vertex_count"]), triangles.astype(np.int64)))
    return drawn


def _frames(
    run: Run, drawn: list[Drawn]
) -> Iterator[tuple[int, float, dict[str, np.ndarray], np.ndarray | None]]:
    """Number, time, arrays and digest of each frame that the manifest counts."""
    total, index = run.frame_count, 0
    for chunk in range(run.frame_chunks):
        path = run.folder / f"frames/chunk_{chunk:06d}.npz"
        arrays = read_npz(path)
        times, digests = arrays.get("times", np.zeros(0)), arrays.get("chain")
        need(times.ndim == 1 and times.dtype == np.float64, f"'{path}' has no valid times")
        need(
            digests is None or (digests.shape == (len(times), 32) and digests.dtype == np.uint8),
            f"'{path}': digests have a wrong shape",
        )
        tracks = {}
        for i, body in enumerate(drawn):
            track = arrays.get(f"positions_{i:04d}")
            fits = (
                track is not None
                and track.dtype == np.float32
                and track.shape[1:] == (body.vertex_count, 3)
                and len(track) in (1, len(times))
            )
            need(fits, f"'{path}': positions of body '{body.name}' are missing or have a wrong shape")
            assert track is not None
            tracks[f"positions_{i:04d}"] = track
        for k, time in enumerate(times):
            if index == total and run.manifest.get("status") == "running":
                return
            row = {name: track[0 if len(track) == 1 else k] for name, track in tracks.items()}
            yield index, float(time), {"times": time, **row}, None if digests is None else digests[k]
            index += 1
    need(index == total, f"'{run.folder}' holds {index} frames, its manifest says {total}")
