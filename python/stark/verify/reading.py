"""Reads what the checker needs of a run folder, with code of its own: nothing here is shared with what wrote
it."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .body_kinds import row_of
from .files import UnreadableRecording, file_digest, need, read_json, read_lines, read_npz

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

_READABLE, _READABLE_STATES = 1, 2  # versions of recordings and of their states
_CACHED_CHUNKS = 2
_JOINT_WIDTHS = {"fixed": 12, "ball": 3}  # numbers of joints that hold what they find (held_places.py)


@dataclass(frozen=True)
class Body:
    """A body of the scene: all of its vertices, its surface and what it weighs."""

    name: str
    kind: str
    motion: str
    vertex_count: int
    contact_distance: float  # [m]
    triangles: Integers  # (m, 3)
    edges: Integers  # (k, 2), of rods
    pins: Integers
    clamped: Integers
    masses: Floats | None  # (n,) [kg]
    second_moments: Floats | None  # of rods (n, 2) [kg m^2]
    edge_lengths: Floats | None  # of rods at rest (k,) [m]; None if it is not recorded
    inertia: dict[str, Any] | None  # of rigid bodies
    shown: Floats | None = None  # of rigid bodies that show another mesh (n, 3), in their frame [m]
    shown_triangles: Integers | None = None

    @property
    def has_pose(self) -> bool:
        """Whether all vertices follow one position and rotation."""
        return row_of(self.kind).moved_by == "pose"

    @property
    def has_frames(self) -> bool:
        """Whether each vertex has a position and a rotation."""
        return row_of(self.kind).moved_by == "frames"

    @property
    def has_inside(self) -> bool:
        """Whether it has vertices that are not drawn."""
        return row_of(self.kind).has_inside


@dataclass(frozen=True)
class State:
    """An accepted state. Lists are by body, with None where a body has no such thing."""

    index: int
    time: float  # [s]
    positions: list[Floats]  # (n, 3) [m]
    poses: list[Floats | None]  # (4, 3): position, rows of the rotation
    frames: list[Floats | None]  # (n, 3, 3)
    angular_velocities: list[Floats | None]  # (3,) of rigid bodies, (n, 3) of the frames of rods [rad/s]
    joints: NDArray[np.int8]  # enabled
    attachments: NDArray[np.int8]  # 1 held, 0 released, -1 broken; pairs of all attachments in a row
    actuators: NDArray[np.int8] | None = None  # enabled; None in recordings of older versions
    actuator_values: Floats | None = None  # of all actuators in a row
    #: By exclusion (surface.exclusions): 1 where contact was back in the step that led here.
    regained: NDArray[np.int8] | None = None
    #: By body: 1 where the user has placed it since the step before; None in recordings of older versions.
    placed: NDArray[np.int8] | None = None
    placed_coordinates: Floats | None = None  # of all joints in a row, where bodies were placed
    #: Where side a is on the carrier of side b, of joints and attachments that hold what they find.
    held_places: Floats | None = None
    #: With bdf2 (multistep.py), None without and in recordings of older versions. By body: (n, 3), of rigid
    #: ones (3,) [m/s]; A, p and Q of angular momenta (n, 3, 3), of rigid ones (3, 3) [kg m^2/s].
    velocities: list[Floats | None] = field(default_factory=list)
    lags: list[Floats | None] = field(default_factory=list)
    spins: list[Floats | None] = field(default_factory=list)
    row: dict[str, np.ndarray] = field(default_factory=dict)  # as it is recorded
    digest: NDArray[np.uint8] | None = None  # (32,), None in recordings of older versions

    def points(self) -> Floats:
        """All vertices of all bodies (N, 3) [m]."""
        return np.concatenate(self.positions)

    @property
    def is_placed(self) -> bool:
        """Whether it is not the end of a step, but what the user has made of that."""
        return self.placed is not None and bool(self.placed.any())

    def parts(self) -> list[Floats]:
        """All arrays of numbers."""
        parts = (*self.positions, *self.poses, *self.frames, *self.angular_velocities)
        parts = (*parts, *self.velocities, *self.lags, *self.spins)
        return [a for a in parts if a is not None]


@dataclass
class Run:
    """A run folder. ``bodies`` is empty in a recording that was not made for certification."""

    folder: Path
    manifest: dict[str, Any]
    rows: list[dict[str, Any]]  # telemetry of accepted steps
    all_rows: int
    bodies: list[Body] = field(default_factory=list)
    scene: dict[str, Any] = field(default_factory=dict)
    times: Floats = field(default_factory=lambda: np.zeros(0))
    #: By state: whether the user has placed bodies in it.
    placed: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    files: dict[str, str] = field(default_factory=dict)  # sha256 by path
    frame_count: int = 0
    frame_chunks: int = 0
    _starts: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    _chunks: dict[int, dict[str, np.ndarray]] = field(default_factory=dict)

    @property
    def has_states(self) -> bool:
        return bool(self.bodies)

    @property
    def settings(self) -> dict[str, Any]:
        settings: dict[str, Any] = self.manifest.get("settings", {})
        return settings

    def bound(self, name: str) -> float | None:
        """A setting that bounds something; None where the recording lacks it. What cannot bound anything is
        damage: compared with it, everything would hold."""
        if name not in self.settings:
            return None
        value = self.settings[name]
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        need(
            is_number and math.isfinite(value) and value >= 0.0,
            f"'{self.folder / 'manifest.json'}': setting {name} = {value!r} must be a finite number >= 0",
        )
        return float(value)

    def lacks(self, *names: str) -> str:
        """What a claim says that needs settings which the recording lacks; empty when it has all."""
        missing = [name for name in names if name not in self.settings]
        return f"the recording lacks the setting {missing[0]}" if missing else ""

    def states(self) -> Iterator[State]:
        """All states in order of time."""
        return (self.state(k) for k in range(len(self.times)))

    @property
    def placed_count(self) -> int:
        """States in which the user has placed bodies, which no step led to."""
        return int(self.placed.sum())

    def row_of(self, state: State) -> dict[str, Any] | None:
        """Telemetry of the step that led to a state; None for the first one, placed ones, and without it."""
        row = state.index - 1 - int(self.placed[: state.index].sum())
        return self.rows[row] if 0 <= row < len(self.rows) and not state.is_placed else None

    def jumps(self, start: State, end: State) -> bool:
        """Whether bodies were placed before the step between two states, and none is recorded after that."""
        row = self.row_of(end)
        return row is not None and bool(row.get("placed")) and not start.is_placed

    def state(self, index: int) -> State:
        chunk = int(np.searchsorted(self._starts, index, side="right")) - 1
        arrays = self._chunk(chunk)

        def at(name: str) -> Any:
            rows = arrays.get(name)
            return None if rows is None else rows[0 if len(rows) == 1 else index - self._starts[chunk]]

        count = range(len(self.bodies))
        return State(
            index,
            float(self.times[index]),
            [at(f"positions_{i:04d}") for i in count],
            [at(f"poses_{i:04d}") for i in count],
            [at(f"frames_{i:04d}") for i in count],
            [at(f"angular_velocities_{i:04d}") for i in count],
            at("joints"),
            at("attachments"),
            at("actuators"),
            at("actuator_values"),
            at("contact_regained"),
            at("placed"),
            at("placed_coordinates"),
            at("held_places"),
            [at(f"velocities_{i:04d}") for i in count],
            [at(f"lags_{i:04d}") for i in count],
            [at(f"spins_{i:04d}") for i in count],
            {name: at(name) for name in arrays if name != "chain"},
            at("chain"),
        )

    def _chunk(self, index: int) -> dict[str, np.ndarray]:
        if index not in self._chunks:
            if len(self._chunks) >= _CACHED_CHUNKS:
                self._chunks.pop(next(iter(self._chunks)))
            self._chunks[index] = self._checked_chunk(index)
        return self._chunks[index]

    def _checked_chunk(self, index: int) -> dict[str, np.ndarray]:
        path = self.folder / f"states/chunk_{index:06d}.npz"
        arrays = read_npz(path)
        times = arrays.get("times", np.zeros(0))
        need(times.ndim == 1 and np.isfinite(times).all() and times.size > 0, f"'{path}' has no valid times")
        for i, body in enumerate(self.bodies):
            shapes: dict[str, tuple[int, ...]] = {"positions": (body.vertex_count, 3)}
            n = body.vertex_count
            shapes |= {"poses": (4, 3), "angular_velocities": (3,)} if body.has_pose else {}
            shapes |= {"frames": (n, 3, 3), "angular_velocities": (n, 3)} if body.has_frames else {}
            if f"velocities_{i:04d}" in arrays:
                shapes |= {"velocities": (3,) if body.has_pose else (n, 3)}
            if f"lags_{i:04d}" in arrays:
                of_points = (3,) if body.has_pose else (n, 3)
                shapes |= {"lags": of_points}
                shapes |= {"spins": (*of_points, 3)} if body.has_pose or body.has_frames else {}
            for name, shape in shapes.items():
                rows = arrays.get(f"{name}_{i:04d}")
                fits = rows is not None and rows.shape[1:] == shape and len(rows) in (1, len(times))
                need(
                    fits and rows is not None and rows.dtype == np.float64,
                    f"'{path}': {name} of body '{body.name}' are missing or have a wrong shape",
                )
        rows = arrays.get("placed")
        need(
            rows is None or (rows.shape[1:] == (len(self.bodies),) and len(rows) in (1, len(times))),
            f"'{path}': placed has a wrong shape",
        )
        digests = arrays.get("chain")
        need(
            digests is None or (digests.shape == (len(times), 32) and digests.dtype == np.uint8),
            f"'{path}': digests have a wrong shape",
        )
        counts = [("joints", len(self.scene["joints"])), ("attachments", self.pair_count)]
        if all(isinstance(actuator, dict) for actuator in self.scene["actuators"]):
            values = sum(len(actuator["values"]) for actuator in self.scene["actuators"])
            counts += [("actuators", len(self.scene["actuators"])), ("actuator_values", values)]
        if self.held_place_count > 0:
            counts += [("held_places", self.held_place_count)]
        for name, count in counts:
            rows = arrays.get(name)
            need(
                rows is not None and rows.shape[1:] == (count,) and len(rows) in (1, len(times)),
                f"'{path}': {name} are missing or have a wrong shape",
            )
        for name, rows in arrays.items():
            fits = rows.ndim > 0 and len(rows) in (1, len(times))
            need(fits, f"'{path}': {name} are missing or have a wrong shape")
        return arrays

    @property
    def pair_count(self) -> int:
        """Pairs of all attachments."""
        return sum(pair_count(attachment) for attachment in self.scene["attachments"])

    @property
    def held_place_count(self) -> int:
        """Numbers of the places of what holds what it finds."""
        return sum(place_width(part) for part in (*self.scene["joints"], *self.scene["attachments"]))


def pair_count(attachment: dict[str, Any]) -> int:
    """Pairs of an attachment: as many as points on its side a."""
    a = attachment["a"]
    return len(
        a["vertices"] if a["kind"] == "vertices" else a["supports" if a["kind"] == "embedded" else "local"]
    )


def place_width(part: dict[str, Any]) -> int:
    """Numbers of a joint or an attachment; 0 for one that holds what it was added with."""
    if "held_place" not in part:
        return 0
    return _JOINT_WIDTHS[part["kind"]] if "kind" in part else 3 * pair_count(part)


def read(folder: Path, progress: Callable[[float, str], None] = lambda done, text: None) -> Run:
    """Reads and checks a run folder; UnreadableRecording names what is wrong. Chunks of states are read in
    turn."""
    need(
        folder.is_dir(),
        f"'{folder}' is not a run folder: no such folder; check the path, stark run prints it",
    )
    there = (folder / "manifest.json").exists()
    need(
        there, f"'{folder}' is not a run folder: it has no manifest.json, which stark run and Recorder write"
    )
    manifest = read_json(folder / "manifest.json")
    need(
        manifest.get("format") == "stark-recording" and manifest.get("version") == _READABLE,
        f"'{folder / 'manifest.json'}' is not the manifest of a Stark recording of version {_READABLE}",
    )
    need(isinstance(manifest.get("settings"), dict), f"'{folder / 'manifest.json'}' has no settings")
    running = manifest.get("status") == "running"
    rows = _telemetry(folder / "telemetry.jsonl", cut_allowed=running)
    if running and isinstance(manifest.get("chain"), dict) and "lines" in manifest["chain"]:
        # Lines are written at once; of a run that is killed while it is resumed, some are to be written anew.
        rows = rows[: _count(manifest["chain"], "lines", folder, "chain.")]
    accepted = [row for row in rows if row.get("status") in ("accepted", "retried")]
    run = Run(folder, manifest, accepted, len(rows))
    states = manifest.get("states")
    chunk_count = 0
    if states is not None:
        chunk_count = _count(states, "chunk_count", folder, "states.")
        need(
            chunk_count <= _count(states, "count", folder, "states."),
            f"'{folder / 'manifest.json'}': states.chunk_count is more than states.count",
        )
        _read_scene(run)
        times, placed = [], []
        for index in range(chunk_count):
            chunk = run._checked_chunk(index)
            times.append(chunk["times"])
            placed.append(_placed(chunk))
            progress((index + 1) / chunk_count, "reading")
        if manifest.get("status") == "running" and times:
            # The last chunk grows; states that the manifest does not count yet are not there.
            left = max(0, _count(states, "count", folder, "states.") - sum(map(len, times[:-1])))
            times[-1], placed[-1] = times[-1][:left], placed[-1][:left]
        run._starts = np.cumsum([0, *(len(t) for t in times)])
        run.times = np.concatenate([np.zeros(0), *times])
        run.placed = np.concatenate([np.zeros(0, dtype=bool), *placed])
        count = _count(states, "count", folder, "states.")
        need(count > 0, f"'{folder}' has no states: call recorder.record_state(sim) after each step")
        need(
            len(run.times) == count,
            f"'{folder}' holds {len(run.times)} states, its manifest says {count}",
        )
    run.frame_count = _count(manifest, "frame_count", folder)
    run.frame_chunks = _count(manifest, "chunk_count", folder)
    run.files = _digests(folder, run.frame_chunks, chunk_count, states is not None)
    return run


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
        need(rows.ndim == 2 and rows.shape[1] == width, f"body '{name}': topology of the shape {rows.shape}")
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


def number(row: dict[str, Any], key: str) -> float:
    """A number of a row, NaN where there is none; JSON has integers that no float can hold."""
    value = row.get(key)
    try:
        return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else math.nan
    except OverflowError:
        return math.nan
