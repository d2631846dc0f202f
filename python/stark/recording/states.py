"""Writes what ``stark verify`` certifies: every accepted state in double precision, and the part of the scene
that says which bodies must not pass through each other, what they weigh and what holds them together.

Layout, beside the frames::

    states/scene.json          bodies, contact distances, pairs without contact, joints, attachments
    states/mesh.npz            triangles_0000 (m, 3) and edges_0000 (k, 2) int32, masses_0000 (n,) [kg]
    states/chunk_000000.npz    times (k,), positions_0000 (k, n, 3) float64 [m]; poses_0000 (k, 4, 3) of rigid
                               bodies (position, then the rows of the rotation); frames_0000 (k, n, 3, 3) of
                               rods; joints (k, j) and attachments (k, p): what was enabled

A state takes 24 bytes a vertex; a body that rests through a chunk is stored once.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..array_file import write_atomically
from .format import STATES, STATES_VERSION
from .masses import point_masses, second_moments


def describe(sim: Any) -> dict[str, Any]:
    """What the checker has to know about the scene of a simulation, as JSON."""
    scene, settings = sim.scene._core, sim.settings
    bodies = [
        _body(scene, body, scene.contact_distance_in(body._index, settings._core)) for body in sim.bodies
    ]
    return {
        "version": STATES_VERSION,
        "bodies": bodies,
        "contact_enabled": settings["contact.enabled"],
        "pairs_without_contact": _pairs_without_contact(scene, len(bodies), settings["contact.self_contact"]),
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind,
                "built_in": joint.formula.residuals is None,
                **joint._given,
            }
            for joint in sim.joints
        ],
        "attachments": [{**attachment._given, "name": attachment.name} for attachment in sim.attachments],
        "energies": [energy.name for energy in sim.energies],
        "actuators": [actuator.name for actuator in sim.actuators],
    }


def _body(scene: Any, body: Any, contact_distance: float) -> dict[str, Any]:
    entry = {
        "name": body.name,
        "kind": body.kind,
        "motion": body.motion,
        "vertex_count": len(body.positions),
        "contact_distance": contact_distance,
        "pins": [] if body.kind == "rigid" else body.pins,
        "clamped": body.clamped if body.kind == "rod" else [],
    }
    return entry | ({"inertia": scene.inertia(body._index)} if body.kind == "rigid" else {})


def _pairs_without_contact(scene: Any, count: int, self_contact: bool) -> list[tuple[int, int]]:
    """Pairs (a <= b) of numbers of bodies that may pass through each other."""
    return [
        (a, b)
        for a in range(count)
        for b in range(a, count)
        if not scene.contact_enabled(a, b) or (a == b and not self_contact)
    ]


def _plain(value: Any) -> Any:
    """JSON with every digit; infinite numbers become null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


class StateWriter:
    """Writes ``folder/states``. ``write(sim)`` adds the state of a simulation as it is."""

    def __init__(self, folder: Path, sim: Any, chunk_states: int) -> None:
        self._folder = folder / STATES
        self._folder.mkdir(parents=True, exist_ok=True)
        self._chunk_states = chunk_states
        self._pending: list[dict[str, np.ndarray]] = []
        #: States and chunks that are on disk.
        self.count, self.chunk_count = 0, 0
        text = json.dumps(_plain(describe(sim)), separators=(",", ":"), allow_nan=False) + "\n"
        write_atomically(self._folder / "scene.json", lambda file: file.write(text.encode()) and None)
        arrays = _mesh(sim)
        write_atomically(self._folder / "mesh.npz", lambda file: np.savez(file, **arrays))

    def write(self, sim: Any) -> bool:
        """Adds a state; returns whether a chunk is full and should be flushed."""
        state: dict[str, np.ndarray] = {"times": np.float64(sim.time)}
        for i, body in enumerate(sim.bodies):
            state[f"positions_{i:04d}"] = np.asarray(body.positions, dtype=np.float64)
            if body.kind == "rigid":
                position, rotation = body.pose
                state[f"poses_{i:04d}"] = np.vstack([position, rotation])
            if body.kind == "rod":
                state[f"frames_{i:04d}"] = np.asarray(body.frames)
        state["joints"] = np.array([joint.enabled for joint in sim.joints], dtype=np.int8)
        status = [sim._core.attachment_status(k) for k in range(len(sim.attachments))]
        state["attachments"] = np.concatenate([*status, np.zeros(0)]).astype(np.int8)
        self._pending.append(state)
        return len(self._pending) >= self._chunk_states

    def flush(self) -> None:
        """Writes the states held in memory as one chunk."""
        if not self._pending:
            return
        arrays = {}
        for name in self._pending[0]:
            track = [state[name] for state in self._pending]
            still = name != "times" and all(np.array_equal(track[0], other) for other in track[1:])
            arrays[name] = np.stack(track[:1] if still else track)
        path = self._folder / f"chunk_{self.chunk_count:06d}.npz"
        write_atomically(path, lambda file: np.savez(file, **arrays))
        self.chunk_count += 1
        self.count += len(self._pending)
        self._pending = []


def _mesh(sim: Any) -> dict[str, np.ndarray]:
    """Topology and masses of all bodies, by number."""
    arrays: dict[str, np.ndarray] = {}
    for i, body in enumerate(sim.bodies):
        arrays[f"triangles_{i:04d}"] = np.asarray(body.triangles, dtype=np.int32).reshape(-1, 3)
        rod_edges = body.mesh.edges if body.kind == "rod" else np.zeros((0, 2))
        arrays[f"edges_{i:04d}"] = np.asarray(rod_edges, dtype=np.int32)
        for name, values in (("masses", point_masses(body)), ("second_moments", second_moments(body))):
            if values is not None:
                arrays[f"{name}_{i:04d}"] = values
    return arrays
