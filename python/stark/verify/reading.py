"""Reads what the checker needs of a run folder, with code of its own: nothing here is shared with what wrote
it."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .body_kinds import row_of
from .files import UnreadableRecording, file_digest, need, read_json, read_lines, read_npz
from .run import Body, Floats, Integers, Run

_READABLE, _READABLE_STATES = 1, 2  # versions of recordings and of their states


def read(folder: Path, progress: Callable[[float, str], None] = lambda done, text: None) -> Run:
    """Reads and checks a run folder; UnreadableRecording names what is wrong. Chunks of states are read in
    turn."""
    manifest = _manifest(folder)
    rows = _rows(folder, manifest)
    accepted = [row for row in rows if row.get("status") in ("accepted", "retried")]
    run = Run(folder, manifest, accepted, len(rows))
    states = manifest.get("states")
    chunk_count = 0 if states is None else _read_states(run, states, progress)
    run.frame_count = _count(manifest, "frame_count", folder)
    run.frame_chunks = _count(manifest, "chunk_count", folder)
    run.files = _digests(folder, run.frame_chunks, chunk_count, states is not None)
    return run


def _manifest(folder: Path) -> dict[str, Any]:
    need(
        folder.is_dir(),
        f"'{folder}' is not a run folder: no such folder; check the path, stark run prints it",
    )
    file = folder / "manifest.json"
    need(
        file.exists(),
        f"'{folder}' is not a run folder: it has no manifest.json, which stark run and Recorder write",
    )
    manifest = read_json(file)
    need(
        manifest.get("format") == "stark-recording" and manifest.get("version") == _READABLE,
        f"'{file}' is not the manifest of a Stark recording of version {_READABLE}",
    )
    need(isinstance(manifest.get("settings"), dict), f"'{file}' has no settings")
    return manifest


def _rows(folder: Path, manifest: dict[str, Any]) -> list[dict[str, Any]]:
    """Lines of the telemetry."""
    running = manifest.get("status") == "running"
    rows = _telemetry(folder / "telemetry.jsonl", cut_allowed=running)
    if running and isinstance(manifest.get("chain"), dict) and "lines" in manifest["chain"]:
        # Lines are written at once; of a run that is killed while it is resumed, some are to be written anew.
        rows = rows[: _count(manifest["chain"], "lines", folder, "chain.")]
    return rows


def _read_states(run: Run, states: Any, progress: Callable[[float, str], None]) -> int:
    """Reads the scene, and the states chunk by chunk; returns the number of chunks."""
    folder = run.folder
    count, chunk_count = (_count(states, name, folder, "states.") for name in ("count", "chunk_count"))
    need(
        chunk_count <= count,
        f"'{folder / 'manifest.json'}': states.chunk_count is more than states.count",
    )
    _read_scene(run)
    times, placed = [], []
    for index in range(chunk_count):
        chunk = run.chunk(index)
        times.append(chunk["times"])
        placed.append(_placed(chunk))
        progress((index + 1) / chunk_count, "reading")
    if run.manifest.get("status") == "running" and times:
        # The last chunk grows; states that the manifest does not count yet are not there.
        left = max(0, count - sum(map(len, times[:-1])))
        times[-1], placed[-1] = times[-1][:left], placed[-1][:left]
    run._starts = np.cumsum([0, *(len(t) for t in times)])
    run.times = np.concatenate([np.zeros(0), *times])
    run.placed = np.concatenate([np.zeros(0, dtype=bool), *placed])
    run.placed[:1] = False
    need(count > 0, f"'{folder}' has no states: call recorder.record_state(sim) after each step")
    need(
        len(run.times) == count,
        f"'{folder}' holds {len(run.times)} states, its manifest says {count}",
    )
    return chunk_count


def _placed(chunk: dict[str, np.ndarray]) -> NDArray[np.bool_]:
    """By state of a chunk: whether bodies were placed; nowhere in recordings of older versions."""
    count = len(chunk["times"])
    if "placed" not in chunk:
        return np.zeros(count, dtype=bool)
    return np.array(np.broadcast_to((chunk["placed"] != 0).any(axis=1), (count,)))


def _count(entry: Any, name: str, folder: Path, where: str = "") -> int:
    """A count that a manifest claims. Files are opened one by one: the first that is missing ends it."""
    value = entry.get(name) if isinstance(entry, dict) else None
    good = isinstance(value, int) and not isinstance(value, bool) and value >= 0
    need(good, f"'{folder / 'manifest.json'}': {where}{name} is not a count")
    return int(value)  # type: ignore[arg-type]


def _telemetry(path: Path, cut_allowed: bool) -> list[dict[str, Any]]:
    rows = []
    for number, line in read_lines(path):
        if not line.endswith(b"\n"):
            need(cut_allowed, f"'{path}' line {number} is cut off")
            break
        try:
            row = json.loads(line.decode("utf-8"))
        except (ValueError, RecursionError) as error:
            what = getattr(error, "msg", error)
            raise UnreadableRecording(f"'{path}' line {number} is not JSON: {what}") from error
        need(isinstance(row, dict), f"'{path}' line {number} must be a JSON object")
        rows.append(row)
    return rows


def _read_scene(run: Run) -> None:
    path = run.folder / "states/scene.json"
    scene = read_json(path)
    version = scene.get("version")
    need(version == _READABLE_STATES, f"'{path}' has version {version}, not {_READABLE_STATES}")
    arrays = read_npz(run.folder / "states/mesh.npz")
    try:
        run.bodies = [_body(entry, i, arrays) for i, entry in enumerate(scene["bodies"])]
        for name in ("joints", "attachments", "energies", "actuators", "pairs_without_contact"):
            need(isinstance(scene[name], list), f"'{path}': {name} must be a list")
        pairs = np.array(scene["pairs_without_contact"], dtype=np.int64).reshape(-1, 2)
    except (KeyError, TypeError, ValueError) as error:
        raise UnreadableRecording(f"'{path}' lacks or breaks an entry: {error}") from error
    need(
        bool(run.bodies) and bool(((pairs >= 0) & (pairs < len(run.bodies))).all()),
        f"'{path}' has no bodies, or a pair of bodies that it does not have",
    )
    enabled = scene.get("contact_enabled")
    need(isinstance(enabled, bool), f"'{path}': contact_enabled = {enabled!r} must be true or false")
    setting = run.settings.get("contact.enabled", enabled)
    need(
        setting is enabled,
        f"'{path}': contact_enabled = {enabled!r} must be contact.enabled of the manifest, {setting!r}",
    )
    run.scene = scene


def _body(entry: dict[str, Any], i: int, arrays: dict[str, np.ndarray]) -> Body:
    count, name = int(entry["vertex_count"]), str(entry["name"])
    triangles, edges = arrays[f"triangles_{i:04d}"], arrays[f"edges_{i:04d}"]
    for rows, width in ((triangles, 3), (edges, 2)):
        need(
            rows.ndim == 2 and rows.shape[1] == width and rows.dtype.kind in "iu",
            f"body '{name}': topology of the type {rows.dtype} and the shape {rows.shape}: must be rows of "
            f"{width} integers",
        )
        inside = rows.size == 0 or (rows.min() >= 0 and rows.max() < count)
        need(bool(inside), f"body '{name}': its topology names a vertex that it does not have")
    distance = float(entry["contact_distance"])
    need(
        0.0 <= distance < math.inf, f"body '{name}': contact_distance = {distance} m must be finite and >= 0"
    )
    masses, moments = arrays.get(f"masses_{i:04d}"), arrays.get(f"second_moments_{i:04d}")
    kind = str(entry["kind"])
    fits = row_of(kind).moved_by != "pose" or isinstance(entry["inertia"], dict)
    need(fits, f"body '{name}': breaks an entry: inertia must be an object")
    need(masses is None or masses.shape == (count,), f"body '{name}': masses of the wrong shape")
    return Body(
        name,
        kind,
        str(entry["motion"]),
        count,
        distance,
        triangles.astype(np.int32),
        edges.astype(np.int32),
        np.array(entry["pins"], dtype=np.int32),
        np.array(entry["clamped"], dtype=np.int32),
        masses,
        moments,
        _edge_lengths(name, edges, arrays.get(f"edge_lengths_{i:04d}")),
        entry.get("inertia"),
        *_shown(name, i, arrays),
    )


def _edge_lengths(name: str, edges: Integers, lengths: Floats | None) -> Floats | None:
    """Of a rod, whose edges lead from each of its nodes to the next."""
    if lengths is None:
        return None
    is_chain = bool((edges == np.arange(len(edges))[:, None] + [0, 1]).all())
    fits = lengths.shape == (len(edges),) and bool((lengths > 0.0).all())
    need(is_chain and fits, f"body '{name}': edge_lengths of the wrong shape or value")
    return lengths


def _shown(name: str, i: int, arrays: dict[str, np.ndarray]) -> tuple[Floats | None, Integers | None]:
    """The mesh that a rigid body shows instead of its surface."""
    vertices, triangles = arrays.get(f"shown_{i:04d}"), arrays.get(f"shown_triangles_{i:04d}")
    if vertices is None or triangles is None:
        need(
            vertices is None and triangles is None,
            f"body '{name}': half of the mesh that it shows is missing",
        )
        return None, None
    fits = vertices.ndim == 2 and vertices.shape[1] == 3 and vertices.dtype == np.float64
    need(fits and bool(np.isfinite(vertices).all()), f"body '{name}': shows vertices that are none")
    fits = triangles.ndim == 2 and triangles.shape[1] == 3 and triangles.dtype.kind == "i"
    need(fits, f"body '{name}': shows triangles that are none")
    return vertices, triangles.astype(np.int32)


def _digests(folder: Path, frame_chunks: int, state_chunks: int, has_states: bool) -> dict[str, str]:
    """sha256 of every file of the recording, by its path in the folder."""

    def names() -> Iterator[str]:
        yield from ("manifest.json", "telemetry.jsonl", "frames/topology.npz")
        yield from (f"frames/chunk_{k:06d}.npz" for k in range(frame_chunks))
        yield from ("states/scene.json", "states/mesh.npz") if has_states else ()
        yield from (f"states/chunk_{k:06d}.npz" for k in range(state_chunks))

    return {name: file_digest(folder / name) for name in names()}


def digest(files: dict[str, str]) -> str:
    """One sha256 of a recording: that of the lines ``digest  path`` of its files, sorted by path."""
    lines = "".join(f"{value}  {name}\n" for name, value in sorted(files.items()))
    return hashlib.sha256(lines.encode()).hexdigest()
