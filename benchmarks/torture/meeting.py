"""Who may be in whom: what joints and attachments keep from contact, what they have released and is not apart
yet, and prescribed bodies, which nothing keeps apart. All else that meets is an error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import ipctk
import numpy as np
from numpy.typing import NDArray

import stark
from stark.recording.masses import edge_lengths
from stark.recording.states import describe
from stark.verify.geometry import GeometryCheck
from stark.verify.run import Body, Run, State

Floats = NDArray[np.float64]
Pairs = set[tuple[int, int]]  # numbers of bodies, the smaller first


def described(sim: stark.Simulation) -> Run:
    """What the search of ``stark.verify`` needs of a recording."""
    bodies = []
    for body in sim.bodies:
        edges = body.mesh.edges if body.kind == "rod" else np.zeros((0, 2))
        inertia = {"center_of_mass": body.center_of_mass} if isinstance(body, stark.RigidBody) else None
        bodies.append(
            Body(
                name=body.name,
                kind=body.kind,
                motion=body.motion,
                vertex_count=len(body.positions),
                contact_distance=sim.contact_distance(body),
                triangles=np.asarray(body.triangles).reshape(-1, 3),
                edges=np.asarray(edges),
                pins=np.zeros(0, dtype=np.int64),
                clamped=np.zeros(0, dtype=np.int64),
                masses=None,
                second_moments=None,
                edge_lengths=edge_lengths(body),
                inertia=inertia,
            )
        )
    return Run(Path(), manifest={}, rows=[], all_rows=0, bodies=bodies, scene=describe(sim))


def state_of(sim: stark.Simulation) -> State:
    """Places of everything, as a recording has them."""
    poses = [
        np.vstack([body.position, body.rotation]) if isinstance(body, stark.RigidBody) else None
        for body in sim.bodies
    ]
    positions = [np.array(body.positions) for body in sim.bodies]
    none = np.zeros(0, dtype=np.int8)
    nothing: list[None] = [None] * len(poses)
    regained = np.isin(np.arange(sim._core.exclusion_count), sim.state.arrays()["contact_regained"])
    return State(
        0, sim.time, positions, poses, nothing, nothing, none, none, regained=regained.astype(np.int8)
    )


class Meeting:
    """Of one simulation. Predicates are those of ipctk, floating point and not exact."""

    def __init__(self, sim: stark.Simulation) -> None:
        self._sim = sim
        self.run = described(sim)
        self.check = GeometryCheck(self.run)
        surface = self.check.surface
        surface.watch(state_of(sim).regained)
        self._prescribed = {(int(a), int(b)) for a, b in self.run.scene["pairs_prescribed"]}

    def watch(self, state: State) -> None:
        """From now on the exclusions are those of a state."""
        self.check.surface.watch(state.regained)

    def pairs(self, x: Floats) -> tuple[Pairs, Pairs]:
        """Bodies that meet and must not, and prescribed ones that meet, at positions of all vertices."""
        surface = self.check.surface
        wrong, prescribed = Pairs(), Pairs()
        for e, t in _boxes_meet(x, surface.edges, surface.triangles):
            edge, triangle = surface.edges[e], surface.triangles[t]
            if set(edge.tolist()) & set(triangle.tolist()):
                continue
            a, b = int(surface.body_of[edge[0]]), int(surface.body_of[triangle[0]])
            pair = (min(a, b), max(a, b))
            if pair in wrong or pair in prescribed or not self._counts(edge, triangle, a, b, pair):
                continue
            if ipctk.is_edge_intersecting_triangle(*x[edge], *x[triangle]):
                (prescribed if pair in self._prescribed else wrong).add(pair)
        return wrong, prescribed

    def _counts(self, edge: Any, triangle: Any, a: int, b: int, pair: tuple[int, int]) -> bool:
        surface = self.check.surface
        if pair in self._prescribed:
            return True
        if not surface.allowed[a, b]:
            return False
        kept = surface.kept
        return kept is None or not (kept[edge, b].any() or kept[triangle, a].any())

    def names(self, pairs: Pairs) -> str:
        bodies = self._sim.bodies
        return ", ".join(f"'{bodies[a].name}' and '{bodies[b].name}'" for a, b in sorted(pairs))


def _boxes_meet(x: Floats, edges: Any, triangles: Any) -> NDArray[np.int64]:
    """Numbers of edges and triangles (k, 2) whose boxes overlap."""
    low_e, high_e = x[edges].min(axis=1), x[edges].max(axis=1)
    low_t, high_t = x[triangles].min(axis=1), x[triangles].max(axis=1)
    meet = np.ones((len(edges), len(triangles)), dtype=bool)
    for k in range(3):
        meet &= low_e[:, None, k] <= high_t[None, :, k]
        meet &= high_e[:, None, k] >= low_t[None, :, k]
    return np.argwhere(meet)
