"""How far prescribed parts can still go before there is no room, by linear programming over the pairs that
ipctk finds: whatever is free may move as it likes, without friction and without stiffness. Where that is next
to nothing, a failed step with ``blocked_motion`` is right."""

from __future__ import annotations

from typing import Any

import ipctk
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

import stark

Floats = NDArray[np.float64]

#: Largest turn of a free rigid body for which gaps change linearly [rad].
_TURN = 0.3
#: Most that a free vertex moves, over the largest prescribed motion.
_FREEDOM = 50.0
#: Gaps that are looked at, over the largest prescribed motion, or over the largest contact distance.
_REACH = 3.0, 4.0


class _Unknowns:
    """Of everything free: six of a rigid body, three of a vertex; and how vertices follow."""

    def __init__(self, sim: stark.Simulation, step: float) -> None:
        self.count = 0
        self.x = np.zeros((0, 3))
        self.motion = np.zeros((0, 3))  # of what is prescribed
        self.turns: list[int] = []
        self._blocks: list[tuple[int, Floats | None]] = []  # of each vertex: first unknown, lever
        self.pinned: set[int] = set()
        bodies: list[Any] = list(sim.bodies)
        for body in bodies:
            x = np.array(body.positions)
            self.x = np.concatenate([self.x, x])
            self.motion = np.concatenate([self.motion, _prescribed(sim, body, x, step)])
            if body.kind == "rigid":
                self._add_rigid(body, x)
            else:
                self._add_vertices(len(x), set(np.asarray(body.pins).tolist()))

    def _add_rigid(self, body: Any, x: Floats) -> None:
        if body.motion != "dynamic":
            self._blocks += [(-1, None)] * len(x)
            return
        centre = x.mean(axis=0)
        self._blocks += [(self.count, point - centre) for point in x]
        self.turns += range(self.count + 3, self.count + 6)
        self.count += 6

    def _add_vertices(self, count: int, pins: set[int]) -> None:
        for vertex in range(count):
            if vertex in pins:
                self.pinned.add(len(self._blocks))
            self._blocks.append((-1 if vertex in pins else self.count, None))
            self.count += 0 if vertex in pins else 3

    def row(self, vertices: list[int], gradient: Floats) -> Floats:
        """Change of a gap by the unknowns, and at last by all of the prescribed motion."""
        row = np.zeros(self.count + 1)
        for vertex, g in zip(vertices, gradient, strict=True):
            first, lever = self._blocks[vertex]
            row[-1] += g @ self.motion[vertex]
            if first >= 0:
                row[first : first + 3] += g
                if lever is not None:
                    row[first + 3 : first + 6] += np.cross(lever, g)
        return row


def _prescribed(sim: stark.Simulation, body: Any, x: Floats, step: float) -> Floats:
    """Motion of the vertices of a body within ``step`` [s], as far as it is prescribed."""
    followers = sim._scene._followers.get(body._index, [])
    motion = np.zeros_like(x)
    if body.kind == "rigid":
        if body.motion != "scripted":
            return motion
        turned, place = step * np.array(body.angular_velocity), body.position + step * np.array(body.velocity)
        angle = float(np.linalg.norm(turned))
        rotation = (stark.rotation(axis=turned, angle=angle) if angle > 0.0 else np.eye(3)) @ body.rotation
        for follower in followers:
            place, rotation = follower.pose(sim.time + step)
        return np.asarray(place + (x - body.position) @ body.rotation @ np.asarray(rotation).T - x)
    for follower in followers:
        vertices = np.asarray(body.pins)[follower.rows]
        motion[vertices] = follower.positions(sim.time + step) - x[vertices]
    return motion


def _mesh(sim: stark.Simulation, x: Floats) -> tuple[Any, NDArray[np.int64]]:
    """Of all surfaces and rods, and its vertices among all."""
    edges, triangles, first = [np.zeros((0, 2), dtype=int)], [np.zeros((0, 3), dtype=int)], 0
    bodies: list[Any] = list(sim.bodies)
    for body in bodies:
        corners = np.asarray(body.triangles, dtype=int).reshape(-1, 3) + first
        triangles.append(corners)
        edges += [corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]
        if body.kind == "rod":
            edges.append(np.asarray(body.mesh.edges, dtype=int) + first)
        first += len(body.positions)
    all_edges = np.unique(np.sort(np.concatenate(edges), axis=1), axis=0)
    all_triangles = np.concatenate(triangles)
    used = np.unique(np.append(all_edges.ravel(), all_triangles.ravel()))
    e, t = (np.searchsorted(used, corners).astype(np.int32) for corners in (all_edges, all_triangles))
    return ipctk.CollisionMesh(x[used], e, t), used


def room(sim: stark.Simulation, step: float) -> float | None:
    """Part of the prescribed motion within ``step`` [s] that there is room for; None where there is none."""
    unknowns = _Unknowns(sim, step)
    scale = float(np.abs(unknowns.motion).max())
    if scale == 0.0:
        return None
    mesh, used = _mesh(sim, unknowns.x)
    reach = max(_REACH[0] * scale, _REACH[1] * max(sim.contact_distance(body) for body in sim.bodies))
    near = ipctk.NormalCollisions()
    near.build(mesh, unknowns.x[used], dhat=reach)
    rows, gaps = [], []
    for k in range(len(near)):
        corners = [v for v in near[k].vertex_ids(mesh.edges, mesh.faces) if v >= 0]
        vertices = [int(used[v]) for v in corners]
        places = unknowns.x[vertices].ravel()
        gap = float(np.sqrt(near[k].compute_distance(places)))
        if gap == 0.0:
            continue  # prescribed parts in each other
        gradient = near[k].compute_distance_gradient(places).reshape(-1, 3) / (2.0 * gap)
        row = unknowns.row(vertices, gradient)
        if np.any(row[:-1]) or unknowns.pinned.intersection(vertices):  # scripted bodies may meet
            rows.append(-row)
            gaps.append(gap)
    if not rows:
        return 1.0
    matrix = np.array(rows)
    matrix[:, -1] /= scale
    bounds = [(-_FREEDOM, _FREEDOM)] * unknowns.count + [(0.0, 1.0)]
    for k in unknowns.turns:
        bounds[k] = (-_TURN / scale, _TURN / scale)
    aim = np.zeros(unknowns.count + 1)
    aim[-1] = -1.0
    found = linprog(aim, A_ub=matrix, b_ub=np.array(gaps) / scale, bounds=bounds, method="highs")
    return float(found.x[-1]) if found.x is not None else None
