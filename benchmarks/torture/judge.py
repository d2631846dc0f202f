"""Looks at accepted states and at the ways between them, and knows nothing of Stark's collision detection:
ipctk says whether anything intersects and whether the straight way is clear; where it is not, the search of
``stark.verify`` for another way does."""

from __future__ import annotations

from enum import Enum
from itertools import pairwise

import ipctk
import numpy as np
from numpy.typing import NDArray

import stark
from stark.verify.geometry import GeometryCheck
from stark.verify.rigid_paths import between, largest_turn
from stark.verify.run import State

from .meeting import Meeting, Pairs, state_of

Floats = NDArray[np.float64]

#: Conservative advancement. Tight inclusion takes minutes over a pair of needles, whatever its limit says.
_CCD = ipctk.AdditiveCCD(max_iterations=20_000)
#: For the few ways that no search finds clear: it takes a gap for closed at a ten thousandth of what it was
#: at first, the one above at a tenth, which what comes to rest on something always reaches. Gaps of 1e-6 m
#: beside motions of 2 cm take it hundreds of thousands of iterations.
_NEAR_CCD = ipctk.AdditiveCCD(max_iterations=2_000_000, conservative_rescaling=0.9999)
#: The same for many ways.
_QUICK_CCD = ipctk.AdditiveCCD(max_iterations=20_000, conservative_rescaling=0.9999)
#: Motion over the size of the smallest body from which steps have to find their way clear (docs/failures.md).
_FAR = 0.25
#: In pieces of such a turn, or in so many, rigid bodies may go straight.
_TURN, _PIECES = 0.3, (4, 16)


class Way(Enum):
    """From one state to the next."""

    STRAIGHT = "straight"  # of all vertices, clear
    AROUND = "around"  # arcs of rigid bodies, or a detour near the straight lines, clear
    OPEN = "open"  # none was found, which proves nothing
    FAR = "far"  # none was found, and something moved so far that the step should have looked for one
    THROUGH = "through"  # a vertex changed sides of a closed surface


class Judge:
    """Of one simulation; ask after each step. ``searching=False``: only straight ways count as clear, which
    is quicker."""

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
        self._meeting = Meeting(sim)
        self._last_state = state_of(sim)
        #: Bodies that met when ``intersects`` was last asked, and must not.
        self.wrong = Pairs()
        #: Prescribed bodies that met: nothing keeps them apart, but steps have to say so.
        self.prescribed = Pairs()

    def positions(self) -> Floats:
        """Of all vertices of surfaces and rods (n, 3) [m]."""
        return np.array(self._core.surface()["positions"])[self._touching]

    def intersects(self) -> bool:
        """Whether an edge is in a triangle now, but for bodies that may be in each other."""
        self.wrong, self.prescribed = Pairs(), Pairs()
        if not ipctk.has_intersections(self._mesh, self.positions()):
            return False
        state = state_of(self._sim)
        self._meeting.watch(state)
        self.wrong, self.prescribed = self._meeting.pairs(state.points())
        return bool(self.wrong)

    def named(self, pairs: Pairs) -> str:
        return self._meeting.names(pairs)

    def way(self) -> Way:
        """From where everything was at the last call (at first: at the start) to where it is."""
        before, self._last = self._last, self.positions()
        start, self._last_state = self._last_state, state_of(self._sim)
        if ipctk.is_step_collision_free(self._mesh, before, self._last, narrow_phase_ccd=_CCD):
            return Way.STRAIGHT
        if not self._searching:
            return Way.OPEN
        if self._is_near_free(before, self._last):
            return Way.STRAIGHT
        self._meeting.watch(self._last_state)
        check = GeometryCheck(self._meeting.run)
        check.surface.watch(self._last_state.regained)
        check._follow(start, self._last_state)
        if check.passed:
            return Way.THROUGH
        if check.blocked or check.long_detours:
            return Way.FAR if self._moved_far(start) and not self._in_pieces(check, start) else Way.OPEN
        return Way.AROUND if check.arcs or check.detours else Way.STRAIGHT

    def _is_near_free(self, a: Floats, b: Floats) -> bool:
        """The straight way again, without taking gaps for closed at a tenth: what comes to rest gets so near,
        and the search of the checker takes a hundred times as long."""
        far = ipctk.compute_collision_free_stepsize(self._mesh, a, b, narrow_phase_ccd=_QUICK_CCD)
        if far < 1.0:
            rest = np.asfortranarray(a + far * (b - a))
            return far > 0.0 and bool(
                ipctk.is_step_collision_free(self._mesh, b, rest, narrow_phase_ccd=_QUICK_CCD)
            )
        return True

    def _moved_far(self, start: State) -> bool:
        places = list(zip(start.positions, self._last_state.positions, strict=True))
        motion = max(float(np.linalg.norm(b - a, axis=1).max()) for a, b in places)
        return motion > _FAR * min(float(np.linalg.norm(np.ptp(a, axis=0))) for a, _ in places)

    def _in_pieces(self, check: GeometryCheck, start: State) -> bool:
        """Whether a way is clear that goes straight between some places on the arcs of rigid bodies."""
        turn = largest_turn(start, self._last_state)
        ends = [start.points(), self._last_state.points()]
        for angle in (np.inf, _TURN, *(turn / pieces for pieces in _PIECES)):
            stations = between(self._meeting.run.bodies, start, self._last_state, angle) or ends
            if all(self._is_free(check, a, b) for a, b in pairwise(stations)):
                return True
        return False

    def _is_free(self, check: GeometryCheck, a: Floats, b: Floats) -> bool:
        """Whether everything may go straight from a to b."""
        if not check._blocked(a, b):
            return True
        surface = check.surface
        x, y = (np.asfortranarray(points[surface.points]) for points in (a, b))
        # The checker's points are in the order of the bodies, which is not that of the solver.
        edges, triangles = (
            np.searchsorted(surface.points, corners).astype(np.int32)
            for corners in (surface.edges, surface.triangles)
        )
        mesh = ipctk.CollisionMesh(x, edges, triangles)
        far = ipctk.compute_collision_free_stepsize(mesh, x, y, narrow_phase_ccd=_NEAR_CCD)
        if far == 1.0:
            return True
        # Where the end is ten thousand times as near as the start, the rest is clear seen from there.
        rest = np.asfortranarray(x + far * (y - x))
        return bool(ipctk.is_step_collision_free(mesh, y, rest, narrow_phase_ccd=_NEAR_CCD))
