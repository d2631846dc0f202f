"""Writes what ``stark verify`` certifies: every accepted state in double precision, and the part of the scene
that says which bodies must not pass through each other, what they weigh and what holds them together.

Layout, beside the frames::

    states/scene.json          bodies, contact distances, pairs without contact, joints, attachments
    states/mesh.npz            triangles_0000 (m, 3) and edges_0000 (k, 2) int32, masses_0000 (n,) [kg]
    states/chunk_000000.npz    times (k,), positions_0000 (k, n, 3) float64 [m]; poses_0000 (k, 4, 3) of rigid
                               bodies (position, then the rows of the rotation); frames_0000 (k, n, 3, 3) of
                               rods; angular_velocities_0000 (k, 3) [rad/s] of rigid bodies, (k, n, 3) of the
                               frames of rods; joints (k, j), attachments (k, p) and actuators (k, m): what
                                was enabled; actuator_values (k, v): those of all actuators in a row;
                                contact_regained (k, e): by exclusion of joints and attachments, 1 where
                                contact was back in the step that led to the state; placed (k, bodies): 1
                                where the user has put bodies elsewhere, or pushed them, since the step
                                before, in states that are recorded after that; placed_coordinates (k, c):
                                of all joints in such a state [m, rad], else 0; surface_motions_0000
                                (k, 2, 3): velocity [m/s] and spin [rad/s] of a moving surface in the next
                                step, before functions of the time; held_places (k, w), if
                               there are any: of what holds what it finds, where side a is on the carrier of
                               side b: position [m], of fixed joints then rows of the rotation;
                               chain (k, 32) uint8:
                                digests, see stark.recording.chain. With implicit_euler velocities_0000
                                (k, n, 3) [m/s] of bodies of points and rods without pins. With bdf2:
                                velocities_0000 and lags_0000
                                (k, n, 3) [m/s], of rigid bodies (k, 3); spins_0000 (k, 3, 3) [kg m^2/s] of
                                rigid bodies, (k, n, 3, 3) of rods: increments of the angular momentum by all
                                but contact, by contact, lags

A state takes 24 bytes a vertex, 48 with velocities, 72 with bdf2; a body that rests through a chunk is stored
once.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.body_kinds import has_frames, has_points, has_pose, row_of

from ..array_file import DamageError, make_folder, read_arrays, write_arrays, write_atomically
from ..files import LARGEST_TEXT, read_bytes
from . import chain
from .chain import RowChain
from .format import STATES, STATES_VERSION, RecordingError, shown_mesh
from .formulas import described_formula
from .masses import edge_lengths, point_masses, second_moments


def describe(sim: Any) -> dict[str, Any]:
    """What the checker has to know about the scene of a simulation, as JSON."""
    scene, settings = sim.scene._core, sim.settings
    bodies = [_body(scene, body, sim.contact_distance(body)) for body in sim.bodies]
    prescribed = _prescribed(bodies)
    return {
        "version": STATES_VERSION,
        "bodies": bodies,
        "contact_enabled": settings["contact.enabled"],
        "pairs_without_contact": _pairs_without_contact(scene, prescribed, settings["contact.self_contact"]),
        "pairs_prescribed": _pairs_prescribed(scene, prescribed),
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind,
                "built_in": joint.formula.residuals is None,
                "coordinates": joint.formula.coordinates,
                "formula": described_formula(joint.formula),
                "contact": scene.joint_contact(joint._index),
                **joint._given,
                **_held_place(sim._core.first_joint_place(joint._index)),
            }
            for joint in sim.joints
        ],
        "attachments": [
            {
                **a._given,
                "contact": scene.attachment_contact(a._index),
                "name": a.name,
                **_held_place(sim._core.first_held_place(a._index)),
            }
            for a in sim.attachments
        ],
        "energies": [energy.name for energy in sim.energies],
        "actuators": [_actuator(actuator) for actuator in sim.actuators],
    }


def _held_place(first: int) -> dict[str, int]:
    """Where the numbers of what holds what it finds begin in ``held_places``."""
    return {"held_place": first} if first >= 0 else {}


def _actuator(actuator: Any) -> dict[str, Any]:
    return {
        "name": actuator.name,
        "kind": actuator.kind,
        "built_in": actuator.formula.outputs is None,
        "rows": actuator.formula.row_count,
        "on": [(joint._index, coordinate) for joint, coordinate in actuator.coordinates],
        "values": list(actuator.units),
    }


def _body(scene: Any, body: Any, contact_distance: float) -> dict[str, Any]:
    entry = {
        "name": body.name,
        "kind": body.kind,
        "motion": body.motion,
        "vertex_count": len(body.positions),
        "contact_distance": contact_distance,
        "pins": [] if has_pose(body) else body.pins,
        "clamped": body.clamped if has_frames(body) else [],
    }
    if scene.surface_motion(body._index) is not None:
        entry["surface_moves"] = True
    return entry | ({"inertia": scene.inertia(body._index)} if has_pose(body) else {})


@dataclass(frozen=True)
class _Prescribed:
    """Of a scene of so many bodies those that are not dynamic, and their pairs (k,), a < b."""

    count: int
    a: NDArray[np.int64]
    b: NDArray[np.int64]
    moves: NDArray[np.bool_]  # (k,): one of both is scripted


def _prescribed(bodies: Sequence[Mapping[str, Any]]) -> _Prescribed:
    numbers = np.array([i for i, body in enumerate(bodies) if body["motion"] != "dynamic"], dtype=np.int64)
    scripted = np.array([bodies[i]["motion"] == "scripted" for i in numbers.tolist()], dtype=bool)
    a, b = np.triu_indices(len(numbers), 1)
    return _Prescribed(len(bodies), numbers[a], numbers[b], scripted[a] | scripted[b])


def _pairs_without_contact(scene: Any, prescribed: _Prescribed, self_contact: bool) -> NDArray[np.int64]:
    """Pairs (a <= b) of numbers of bodies (k, 2) that may pass through each other, but for those that joints
    and attachments keep apart: prescribed ones, those of which contact was disabled, bodies with themselves.
    Only these are asked for: of all pairs there may be millions."""
    count = prescribed.count
    asked = {*scene.pairs_without_contact(), *((a, a) for a in range(count))}
    apart = [
        a * count + b
        for a, b in asked
        if b < count and (not scene.contact_possible(a, b) or (a == b and not self_contact))
    ]
    codes = np.union1d(np.array(apart, dtype=np.int64), prescribed.a * count + prescribed.b)
    return np.stack(np.divmod(codes, count), axis=1)


def _pairs_prescribed(scene: Any, prescribed: _Prescribed) -> NDArray[np.int64]:
    """Pairs (a < b) of prescribed bodies (k, 2) that meet where one is moved into the other."""
    pairs = np.stack([prescribed.a, prescribed.b], axis=1)[prescribed.moves]
    matters = [scene.meeting_matters(a, b) for a, b in pairs.tolist()]
    return np.asarray(pairs[np.array(matters, dtype=bool)])


def _plain(value: Any) -> Any:
    """JSON with every digit; infinite numbers become null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist() if value.dtype.kind in "biu" else _plain(value.tolist())
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


class StateWriter:
    """Writes ``folder/states``. ``write(sim)`` adds the state of a simulation as it is. All chunks but the
    last hold ``chunk_states`` states, whenever they are written."""

    def __init__(self, folder: Path, sim: Any, chunk_states: int) -> None:
        self._begin(folder, chunk_states)
        make_folder(self._folder)
        text = _description_text(sim)
        write_atomically(self._folder / "scene.json", lambda file: file.write(text))
        write_arrays(self._folder / "mesh.npz", _mesh(sim))

    def _begin(self, folder: Path, chunk_states: int) -> None:
        #: False where a recording of an older version goes on, which lacks what bdf2 remembers.
        self._with_history = True
        self._folder = folder / STATES
        self._chunk_states = chunk_states
        self._pending: list[dict[str, np.ndarray]] = []
        self._written, self._full_chunks, self._synced = 0, 0, 0
        self._chain: RowChain | None = None
        #: Digest of the last state that is on disk.
        self.head: str = ""

    def begin_chain(self, seed: str) -> None:
        """Before the first state."""
        self._chain = RowChain(seed, "states")
        self.head = self._chain.head

    @classmethod
    def resume(cls, folder: Path, sim: Any, chunk_states: int, states: int, *, chained: bool) -> StateWriter:
        """Goes on after so many states of a recording of the same scene; what follows them is dropped.
        ``chained``: whether states have digests."""
        writer = cls.__new__(cls)
        writer._begin(folder, chunk_states)
        try:
            same = read_bytes(writer._folder / "scene.json", LARGEST_TEXT) == _description_text(sim)
            mesh = read_arrays(writer._folder / "mesh.npz")
        except (OSError, DamageError) as error:
            raise RecordingError(f"'{writer._folder}' is damaged ({error}); run the scene anew") from error
        if not same or not _equal(mesh, _mesh(sim)):
            raise RecordingError(
                f"'{writer._folder}' describes another scene, or other contact distances: a run with "
                f"--certify goes on with what it began with"
            )
        writer._full_chunks, rest = divmod(states, chunk_states)
        writer._written = states - rest
        last = writer._folder / f"chunk_{(states - 1) // chunk_states:06d}.npz"
        writer._with_history = _has_history(last)
        rows = _rows(last, rest or chunk_states, chained, _state_of(sim, with_history=writer._with_history))
        writer._pending = rows if rest else []
        if chained:
            row = rows[-1]
            writer._chain = RowChain.after(row[chain.ARRAY].tobytes().hex())
            writer.head = writer._chain.head
        writer._synced = states
        return writer

    @property
    def count(self) -> int:
        """States so far, on disk or not."""
        return self._written + len(self._pending)

    @property
    def manifest(self) -> dict[str, int]:
        """What is on disk."""
        with_last = self._synced > self._written
        return {
            "count": max(self._synced, self._written),
            "chunk_count": self._full_chunks + (1 if with_last else 0),
        }

    def write(self, sim: Any) -> bool:
        """Adds a state; returns whether that wrote a chunk."""
        state = _state_of(sim, with_history=self._with_history)
        if self._chain is not None:
            state[chain.ARRAY] = self._chain.add_arrays(state)
        self._pending.append(state)
        if len(self._pending) < self._chunk_states:
            return False
        self.sync()
        self._written += len(self._pending)
        self._full_chunks += 1
        self._pending = []
        return True

    def sync(self) -> None:
        """Writes the states held in memory as the last chunk, which may be written again with more."""
        if self.count == self._synced:
            return
        arrays = {}
        for name in self._pending[0]:
            track = [state[name] for state in self._pending]
            still = name != "times" and chain.is_still(track)
            arrays[name] = np.stack(track[:1] if still else track)
        write_arrays(self._path(), arrays)
        self._synced = self.count
        if self._chain is not None:
            self.head = self._chain.head

    def _path(self) -> Path:
        """Of the chunk that is not full yet."""
        return self._folder / f"chunk_{self._full_chunks:06d}.npz"


def _state_of(sim: Any, *, with_history: bool = True) -> dict[str, np.ndarray]:
    """A state as it is recorded; ``with_history``: with what the integrator remembers."""
    state: dict[str, Any] = {"times": np.float64(sim.time)}
    core, bodies = sim._core, list(sim.bodies)
    if with_history and sim.settings["time.integrator"] == "bdf2":
        state |= _history_of(sim, bodies)
    if with_history and sim.settings["time.integrator"] == "implicit_euler":
        state |= _velocities_of(bodies)
    turning = core.state.arrays()["body_angular_velocity"]
    poses = _poses_of(sim, bodies)
    for i, (body, place) in enumerate(zip(bodies, core.places(), strict=True)):
        state[f"positions_{i:04d}"] = core.positions(i)
        if has_points(body):
            continue
        rows = turning[place[2] : place[2] + place[3]]
        if i not in poses:
            state[f"angular_velocities_{i:04d}"] = rows
            state[f"frames_{i:04d}"] = np.asarray(body.frames)
            continue
        state[f"angular_velocities_{i:04d}"] = rows[0]
        state[f"poses_{i:04d}"] = poses[i]
        if (motion := core.surface_motion(i)) is not None:
            state[f"surface_motions_{i:04d}"] = np.array(motion[:2], dtype=np.float64)
    state["joints"] = np.array([joint.enabled for joint in sim.joints], dtype=np.int8)
    status = [sim._core.attachment_status(k) for k in range(len(sim.attachments))]
    state["attachments"] = np.concatenate([*status, np.zeros(0)]).astype(np.int8)
    regained = sim._core.state.arrays()["contact_regained"]
    state["contact_regained"] = np.isin(np.arange(sim._core.exclusion_count), regained).astype(np.int8)
    placed = sim._core.placed_bodies
    state["placed"] = np.isin(np.arange(len(bodies)), placed).astype(np.int8)
    coordinates = [sim._core.joint_coordinates(k) for k in range(len(sim.joints))]
    state["placed_coordinates"] = np.concatenate([*coordinates, np.zeros(0)]) * float(len(placed) > 0)
    state["actuators"] = np.array([actuator.enabled for actuator in sim.actuators], dtype=np.int8)
    values = [value for actuator in sim.actuators for value in actuator.parameters.values()]
    state["actuator_values"] = np.array(values, dtype=np.float64)
    if len(places := sim._core.held_places):
        state["held_places"] = places
    return state


def _poses_of(sim: Any, bodies: Sequence[Any]) -> dict[int, np.ndarray]:
    """Of rigid bodies, by number: position, then the rows of the rotation (4, 3)."""
    rigid = [i for i, body in enumerate(bodies) if has_pose(body)]
    if not rigid:
        return {}
    positions, rotations = sim._core.poses(rigid)
    return dict(
        zip(rigid, np.concatenate([positions[:, None], rotations.reshape(-1, 3, 3)], axis=1), strict=True)
    )


def _velocities_of(bodies: Sequence[Any]) -> dict[str, np.ndarray]:
    """Of the bodies that may turn as a whole: there they are no differences of places."""
    return {
        f"velocities_{i:04d}": np.array(body.velocities, dtype=np.float64)
        for i, body in enumerate(bodies)
        if not has_pose(body) and len(body.pins) == 0
    }


def _history_of(sim: Any, bodies: Sequence[Any]) -> dict[str, np.ndarray]:
    """What the next step of bdf2 knows of the ones before, by body."""
    arrays, found = sim._core.state.arrays(), {}
    spins = [arrays[f"body_spin_{name}"] for name in ("increment", "contact_increment", "lag")]
    for i, (body, place) in enumerate(zip(bodies, sim._core.places(), strict=True)):
        turns = not has_points(body)
        first, count = place[2:4] if turns else place[0:2]
        rows = first if has_pose(body) else slice(first, first + count)
        of = "body" if turns else "point"
        found[f"velocities_{i:04d}"] = arrays[f"{of}_velocity"][rows]
        found[f"lags_{i:04d}"] = arrays[f"{of}_lag"][rows]
        if turns:
            found[f"spins_{i:04d}"] = np.stack([values[rows] for values in spins], axis=-2)
    return found


def _has_history(path: Path) -> bool:
    """Whether the states of a chunk have what the integrator remembers; yes where it cannot be read."""
    try:
        names = read_arrays(path)
    except (OSError, DamageError):
        return True
    return any(name.startswith("velocities_") for name in names)


def _rows(
    path: Path, count: int, chained: bool, like: Mapping[str, np.ndarray]
) -> list[dict[str, np.ndarray]]:
    """The first states of a chunk, with or without their digests, of the arrays of a state ``like`` them."""
    try:
        arrays = read_arrays(path)
        length = len(arrays["times"])
        if length < count or any(len(array) not in (1, length) for array in arrays.values()):
            raise DamageError(f"it must hold {count} states")
        digests = arrays.get(chain.ARRAY)
        if chained and (digests is None or digests.shape != (length, 32) or digests.dtype != np.uint8):
            raise DamageError("it lacks digests")
        if not chained:
            arrays.pop(chain.ARRAY, None)
        for name in sorted((arrays.keys() - {chain.ARRAY}) | like.keys()):
            found, expected = arrays.get(name), like.get(name)
            if (
                found is None
                or expected is None
                or found.dtype != expected.dtype
                or found.shape[1:] != expected.shape
            ):
                raise DamageError(f"{name} do not fit the scene")
    except (OSError, DamageError, KeyError, TypeError) as error:
        raise RecordingError(f"'{path}' is missing or damaged ({error}); run the scene anew") from error
    return [{name: a[0 if len(a) == 1 else k] for name, a in arrays.items()} for k in range(count)]


def _equal(a: Mapping[str, np.ndarray], b: Mapping[str, np.ndarray]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(a[name], b[name]) for name in a)


def _description_text(sim: Any) -> bytes:
    return json.dumps(_plain(describe(sim)), separators=(",", ":"), allow_nan=False).encode() + b"\n"


def _mesh(sim: Any) -> dict[str, np.ndarray]:
    """Topology and masses of all bodies, by number."""
    arrays: dict[str, np.ndarray] = {}
    for i, body in enumerate(sim.bodies):
        arrays[f"triangles_{i:04d}"] = np.asarray(body.triangles, dtype=np.int32).reshape(-1, 3)
        own_edges = np.zeros((0, 2)) if row_of(body).has_triangles else body.mesh.edges
        arrays[f"edges_{i:04d}"] = np.asarray(own_edges, dtype=np.int32)
        if (shown := shown_mesh(body)) is not None:
            arrays[f"shown_{i:04d}"] = shown.vertices
            arrays[f"shown_triangles_{i:04d}"] = shown.triangles.astype(np.int32)
        for name, values in (
            ("masses", point_masses(body)),
            ("second_moments", second_moments(body)),
            ("edge_lengths", edge_lengths(body)),
        ):
            if values is not None:
                arrays[f"{name}_{i:04d}"] = values
    return arrays
