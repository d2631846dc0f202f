"""Looks at accepted states and at the ways between them, and knows nothing of Stark's collision detection:
ipctk says whether anything intersects and whether the straight way is clear; where it is not, the search of
``stark.verify`` for another way does."""

from __future__ import annotations

from enum import Enum
from pathlib import Path

import ipctk
import numpy as np
from numpy.typing import NDArray

import stark
from stark.verify.geometry import GeometryCheck
from stark.verify.reading import Body, Run, State

Floats = NDArray[np.float64]

#: Conservative advancement. Tight inclusion takes minutes over a pair of needles, whatever its limit says.
_CCD = ipctk.AdditiveCCD(max_iterations=20_000)


class Way(Enum):
    """From one state to the next."""

    STRAIGHT = "straight"  # of all vertices, clear
    AROUND = "around"  # arcs of rigid bodies, or a detour near the straight lines, clear
    OPEN = "open"  # none was found, which proves nothing
    THROUGH = "through"  # a vertex changed sides of a closed surface


class Judge:
    """Of one simulation; ask after each step. All surfaces must be in contact with each other.
    ``searching=False``: only straight ways count as clear, which is quicker."""

    def __init__(self, sim: stark.Simulation, searching: bool = True) -> None:
        self._sim, self._searching = sim, searching
        self._core = sim._core
        surface = self._core.surface()
        edges, triangles = np.array(surface["edges"]), np.array(surface["triangles"])
        # Only what touches: frames of rods and centres of mass are points of the simulation too.
        self._touching, index = np.unique(np.append(edges.ravel(), triangles.ravel()), return_inverse=True)
        edges, triangles = np.split(index.astype(np.int32), [edges.size])
        self._last = self.positions()
        self._mesh = ipctk.CollisionMesh(self._last, edges.reshape(-1, 2), triangles.reshape(-1, 3))
        self._last_state = self._state()

    def positions(self) -> Floats:
        """Of all vertices of surfaces and rods (n, 3) [m]."""
        return np.array(self._core.surface()["positions"])[self._touching]

    def intersects(self) -> bool:
        """Whether an edge is in a triangle now."""
        return bool(ipctk.has_intersections(self._mesh, self.positions()))

    def way(self) -> Way:
        """From where everything was at the last call (at first: at the start) to where it is."""
        before, self._last = self._last, self.positions()
        start, self._last_state = self._last_state, self._state()
        if ipctk.is_step_collision_free(self._mesh, before, self._last, narrow_phase_ccd=_CCD):
            return Way.STRAIGHT
        if not self._searching:
            return Way.OPEN
        check = GeometryCheck(self._run())
        check._follow(start, self._last_state)
        if check.passed:
            return Way.THROUGH
        return Way.OPEN if check.blocked or check.long_detours else Way.AROUND

    # --- what the search needs of a recording ---

    def _state(self) -> State:
        poses = [
            np.vstack([body.position, body.rotation]) if isinstance(body, stark.RigidBody) else None
            for body in self._sim.bodies
        ]
        positions = [np.array(body.positions) for body in self._sim.bodies]
        none = np.zeros(0, dtype=np.int8)
        nothing: list[None] = [None] * len(poses)
        return State(0, self._sim.time, positions, poses, nothing, nothing, none, none)

    def _run(self) -> Run:
        bodies = []
        for body in self._sim.bodies:
            distance = self._sim.contact_distance(body)
            edges = body.mesh.edges if body.kind == "rod" else np.zeros((0, 2))
            inertia = None
            if isinstance(body, stark.RigidBody):
                local = body.rotation.T @ (body.center_of_mass - body.position)
                inertia = {"center_of_mass": local}
            bodies.append(
                Body(
                    name=body.name,
                    kind=body.kind,
                    motion=body.motion,
                    vertex_count=len(body.positions),
                    contact_distance=distance,
                    triangles=np.asarray(body.triangles).reshape(-1, 3),
                    edges=np.asarray(edges),
                    pins=np.zeros(0, dtype=np.int64),
                    clamped=np.zeros(0, dtype=np.int64),
                    masses=None,
                    second_moments=None,
                    inertia=inertia,
                )
            )
        scene = {"pairs_without_contact": [], "contact_enabled": True, "attachments": []}
        return Run(Path(), manifest={}, rows=[], all_rows=0, bodies=bodies, scene=scene)
