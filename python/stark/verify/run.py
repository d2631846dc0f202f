"""What the checker knows of a run: its bodies, its states, which are read chunk by chunk, and its telemetry.
Nothing here is shared with what wrote it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .body_kinds import row_of
from .files import need, read_npz

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

_CACHED_CHUNKS = 2
#: Names of the arrays of states: those that bodies have, numbered, and others.
_OF_BODIES = ("positions", "poses", "frames", "angular_velocities", "velocities", "lags", "spins")
_OF_SCENES = (
    "joints",
    "attachments",
    "actuators",
    "actuator_values",
    "placed",
    "placed_coordinates",
    "held_places",
)
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
    def has_placed_bodies(self) -> bool:
        """Whether the user has placed bodies since the step before, or before the first one."""
        return self.placed is not None and bool(self.placed.any())

    @property
    def is_placed(self) -> bool:
        """Whether it is not the end of a step, but what the user has made of that; the first state, to which
        no step leads, is none."""
        return self.index > 0 and self.has_placed_bodies

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
    #: By state: whether the user has placed bodies in it; not in the first one, with which all begins.
    placed: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    files: dict[str, str] = field(default_factory=dict)  # sha256 by path
    frame_count: int = 0
    frame_chunks: int = 0
    _starts: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    _chunks: dict[int, dict[str, np.ndarray]] = field(default_factory=dict)
    _names: dict[str, list[str]] = field(default_factory=dict)

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
        return row is not None and bool(row.get("placed")) and not start.has_placed_bodies

    def state(self, index: int) -> State:
        chunk = int(np.searchsorted(self._starts, index, side="right")) - 1
        arrays = self.chunk(chunk)
        row = index - self._starts[chunk]
        now = {name: rows[0 if len(rows) == 1 else row] for name, rows in arrays.items()}
        if not self._names:
            count = range(len(self.bodies))
            self._names = {kind: [f"{kind}_{i:04d}" for i in count] for kind in _OF_BODIES}
        parts: dict[str, Any] = {name: now.get(name) for name in _OF_SCENES}
        for kind, names in self._names.items():
            parts[kind] = [now.get(name) for name in names]
        return State(
            index,
            float(self.times[index]),
            **parts,
            regained=now.get("contact_regained"),
            row={name: array for name, array in now.items() if name != "chain"},
            digest=now.get("chain"),
        )

    def chunk(self, index: int) -> dict[str, np.ndarray]:
        """Arrays of a file of states."""
        if index not in self._chunks:
            if len(self._chunks) >= _CACHED_CHUNKS:
                self._chunks.pop(next(iter(self._chunks)))
            self._chunks[index] = self._checked_chunk(index)
        return self._chunks[index]

    def _checked_chunk(self, index: int) -> dict[str, np.ndarray]:
        """Arrays of a file of states: what must be there is there, in shapes that fit the scene."""
        path = self.folder / f"states/chunk_{index:06d}.npz"
        arrays = read_npz(path)
        times = arrays.get("times", np.zeros(0))
        need(times.ndim == 1 and np.isfinite(times).all() and times.size > 0, f"'{path}' has no valid times")
        for i, body in enumerate(self.bodies):
            for name, shape in _shapes(body, i, arrays).items():
                rows = arrays.get(f"{name}_{i:04d}")
                need(
                    _fits(rows, shape, times) and rows is not None and rows.dtype == np.float64,
                    f"'{path}': {name} of body '{body.name}' are missing or have a wrong shape",
                )
        rows = arrays.get("placed")
        need(
            rows is None or _fits(rows, (len(self.bodies),), times),
            f"'{path}': placed has a wrong shape",
        )
        digests = arrays.get("chain")
        need(
            digests is None or (digests.shape == (len(times), 32) and digests.dtype == np.uint8),
            f"'{path}': digests have a wrong shape",
        )
        for name, count in self._counts():
            need(
                _fits(arrays.get(name), (count,), times),
                f"'{path}': {name} are missing or have a wrong shape",
            )
        for name, rows in arrays.items():
            fits = rows.ndim > 0 and len(rows) in (1, len(times))
            need(fits, f"'{path}': {name} are missing or have a wrong shape")
        return arrays

    def _counts(self) -> list[tuple[str, int]]:
        """Names and widths of what a state has of joints, attachments and actuators."""
        counts = [("joints", len(self.scene["joints"])), ("attachments", self.pair_count)]
        if all(isinstance(actuator, dict) for actuator in self.scene["actuators"]):
            values = sum(len(actuator["values"]) for actuator in self.scene["actuators"])
            counts += [("actuators", len(self.scene["actuators"])), ("actuator_values", values)]
        if self.held_place_count > 0:
            counts += [("held_places", self.held_place_count)]
        return counts

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


def stacked(rows: Sequence[Floats | None], numbers: Sequence[int]) -> Floats:
    """What a state has of rigid bodies with these numbers, in a row of numbers (k,)."""
    found = [row for i in numbers if (row := rows[i]) is not None]
    need(len(found) == len(numbers), "a state lacks what it must have of a rigid body")
    return np.concatenate([np.zeros(0), *(row.reshape(-1) for row in found)])


def _shapes(body: Body, i: int, arrays: dict[str, np.ndarray]) -> dict[str, tuple[int, ...]]:
    """Shapes of what a state has of body ``i``, by name."""
    n = body.vertex_count
    of_points = (3,) if body.has_pose else (n, 3)
    shapes: dict[str, tuple[int, ...]] = {"positions": (n, 3)}
    shapes |= {"poses": (4, 3), "angular_velocities": (3,)} if body.has_pose else {}
    shapes |= {"frames": (n, 3, 3), "angular_velocities": (n, 3)} if body.has_frames else {}
    if f"velocities_{i:04d}" in arrays:
        shapes |= {"velocities": of_points}
    if f"lags_{i:04d}" in arrays:
        shapes |= {"lags": of_points}
        shapes |= {"spins": (*of_points, 3)} if body.has_pose or body.has_frames else {}
    return shapes


def _fits(rows: np.ndarray | None, shape: tuple[int, ...], times: Floats) -> bool:
    """Whether there is a row of a shape for each time, or one for all."""
    return rows is not None and rows.shape[1:] == shape and len(rows) in (1, len(times))


def number(row: dict[str, Any], key: str) -> float:
    """A number of a row, NaN where there is none; JSON has integers that no float can hold."""
    value = row.get(key)
    try:
        return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else math.nan
    except OverflowError:
        return math.nan
