"""What states and the straight paths between them say about contact: no intersection, the least distance,
clear paths."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .certificate import INCONCLUSIVE, NOT_APPLICABLE, VERIFIED, VIOLATED, Claim
from .detours import Blocked, find_detour, largest_detour
from .distances import Kind, closest, lower_bound
from .limits import excluded_pairs
from .passing import changed_sides
from .paths import blocked_pairs
from .predicates import segments_meet_triangles
from .rigid_paths import between
from .run import Run, State, number
from .surface import PairList, Surface

Floats = NDArray[np.float64]

_CHUNK = 1 << 13  # pairs followed at a time: they stay in the cache
#: Detour, over the size of the smallest body in it, beyond which it may not be what happened: bodies that
#: were thrown at each other could be said to have gone around one another.
_LONG_DETOUR = 0.1
_LISTED = 8  # places named in a certificate
#: Caveat of steps in which surfaces are nearer than settings ask for.
BELOW = "below_least_distance"
#: Share of the required distance that rounding of the solver's own distances may take.
_SLACK = 1e-6
#: Relative difference of the reported and the measured least distance that rounding explains.
_REPORT_ROUNDING = 1e-6
#: Rounding of a distance by that of the places it is measured between, over the largest coordinate.
_PLACE_ROUNDING = 8.0 * float(np.finfo(float).eps)


@dataclass
class GeometryCheck:
    """Goes through the states in order of time: ``add(state)`` for each, then ``claims()``."""

    run: Run
    surface: Surface = field(init=False)
    intersections: list[dict[str, Any]] = field(default_factory=list)
    worst_ratio: float = math.inf
    worst_gap: tuple[float, float, dict[str, Any]] | None = None  # distance, required, where
    too_near: int = 0  # states whose distance is certainly too small
    told: int = 0  # the same, of steps that say so themselves, and of places where the user put bodies
    unsure: int = 0
    blocked: list[dict[str, Any]] = field(default_factory=list)
    passed: list[dict[str, Any]] = field(default_factory=list)
    arcs: int = 0  # steps whose rigid bodies turn on arcs
    detours: int = 0  # steps with another path near the straight one
    largest_detour: float = 0.0  # [m]
    long_detours: list[dict[str, Any]] = field(default_factory=list)
    least: list[float] = field(default_factory=list)  # measured distance of each state [m]
    farthest: float = 0.0  # largest coordinate of all states [m]: places round by their parts of it
    previous: State | None = None
    placed: list[dict[str, Any]] = field(default_factory=list)  # time, state and names of bodies
    unrecorded: list[dict[str, Any]] = field(default_factory=list)  # placed without a state of that

    def __post_init__(self) -> None:
        self.surface = Surface(self.run)
        self.factor: float = self.run.bound("contact.min_separation_factor") or 0.0
        #: What claims about contact are about, where that is not everything.
        self.scope: str = ""
        if left_out := len(excluded_pairs(self.run)):
            self.scope = f" (without {left_out} pair{'s' if left_out > 1 else ''} of bodies, see limits)"

    def add(self, state: State) -> None:
        x = state.points()
        self.surface.watch(state.regained)
        self._find_intersections(state, x)
        self._measure_distances(state, x)
        if state.is_placed:  # no path leads there
            assert state.placed is not None
            names = [self.surface.bodies[k].name for k in np.flatnonzero(state.placed)]
            self.placed.append({"time": state.time, "state": state.index, "bodies": names})
        elif self.previous is not None:
            if self.run.jumps(self.previous, state):
                self.unrecorded.append({"time": self.previous.time, "state": state.index})
            else:
                self._follow(self.previous, state)
        self.previous = state

    def interrupt(self) -> None:
        """A state is missing: nothing is said about the path to the next one."""
        self.previous = None
        self.least.append(math.nan)

    # --- states ---

    def _find_intersections(self, state: State, x: Floats) -> None:
        pairs = self.surface.edge_triangle_pairs(x)
        meets = segments_meet_triangles(*(x[pairs.points[:, k]] for k in range(5)))
        for row in np.flatnonzero(meets):
            self.intersections.append(self._where(state, pairs, int(row), "edge-triangle"))

    def _measure_distances(self, state: State, x: Floats) -> None:
        reach = self.surface.distance[self.surface.body_of][:, None]
        self.farthest = max(self.farthest, float(np.abs(x).max(initial=0.0)))
        least = math.inf
        near, unsure = False, False
        for kind, pairs in self.surface.distance_pairs(x - reach, x + reach).items():
            if not len(pairs):
                continue
            points = x[pairs.points]
            distance, direction = closest(kind, points)
            within = self.surface.distance[pairs.bodies].sum(axis=1)
            rows = np.flatnonzero(~(distance >= within))
            if not len(rows):
                continue
            least = min(least, float(distance[rows].min()))
            bound = lower_bound(kind, points[rows], direction[rows])
            required = (1.0 - _SLACK) * self.factor * within[rows]
            near = near or bool((distance[rows] < required).any())
            unsure = unsure or bool((~(bound >= required) | ~(bound > 0.0)).any())
            self._keep_worst(state, kind, pairs[rows], bound, required)
        if not state.is_placed:
            self.least.append(least)
        is_told = near and self._is_told(state)
        self.told += is_told
        self.too_near += near and not is_told
        self.unsure += unsure and not near

    def _is_told(self, state: State) -> bool:
        """Whether the user put bodies that near, or the step that ends there says that they are."""
        row = self.run.row_of(state)
        caveats = row.get("caveats") if row is not None else None
        return state.index == 0 or state.is_placed or (isinstance(caveats, list) and BELOW in caveats)

    def _keep_worst(self, state: State, kind: Kind, pairs: PairList, bound: Floats, required: Floats) -> None:
        ratio = bound / np.maximum(required, 1e-300)
        row = int(ratio.argmin())
        if ratio[row] < self.worst_ratio:
            self.worst_ratio = float(ratio[row])
            where = self._where(state, pairs, row, _title(kind))
            self.worst_gap = float(bound[row]), float(required[row]), where

    # --- paths ---

    def _follow(self, start: State, end: State) -> None:
        """Straight path, else arcs of rigid bodies, else a detour; what is left is listed."""
        x0, x1 = start.points(), end.points()
        in_the_way = self._blocked(x0, x1)
        if not in_the_way:
            return
        stations = between(self.run.bodies, start, end)
        if stations and not any(self._blocked(a, b) for a, b in pairwise(stations)):
            self.arcs += 1
            return
        passed = changed_sides(self.surface, _bodies_of(in_the_way), x0, x1)
        detour = None if passed else find_detour(self.surface, x0, x1, self._blocked)
        if detour is not None:
            length, size = largest_detour(detour), self._smallest_size(in_the_way, x0)
            self.detours += 1
            self.largest_detour = max(self.largest_detour, length)
            if length > _LONG_DETOUR * size:
                kind, pairs, rows, _ = in_the_way[0]
                where = self._where(end, pairs, int(rows[0]), _title(kind))
                self.long_detours.append(where | {"detour": length, "size": size})
            return
        for kind, pairs, rows, times in in_the_way:
            for row, time in zip(rows.tolist(), times.tolist(), strict=True):
                where = self._where(end, pairs, row, _title(kind))
                where["stuck_at"] = start.time + time * (end.time - start.time)
                self.blocked.append(where)
        for a, b, vertex in passed:
            names = [self.surface.bodies[a].name, self.surface.bodies[b].name]
            place = {"time": end.time, "state": end.index, "pair": "vertex-volume"}
            self.passed.append({**place, "bodies": names, "vertices": [[vertex], []]})

    def _smallest_size(self, in_the_way: Blocked, x: Floats) -> float:
        """Largest extent of the smallest of the bodies that are in each other's way [m]."""
        bodies = {body for pair in _bodies_of(in_the_way) for body in pair}
        return min(float(np.ptp(x[self.surface.body_of == body], axis=0).max()) for body in bodies)

    def _blocked(self, x0: Floats, x1: Floats) -> Blocked:
        """Pairs whose straight path could not be certified."""
        blocked: Blocked = []
        for kind, pairs in self.surface.distance_pairs(np.minimum(x0, x1), np.maximum(x0, x1)).items():
            for first in range(0, len(pairs), _CHUNK):
                some = pairs[first : first + _CHUNK]
                rows, times = blocked_pairs(kind, x0[some.points], x1[some.points])
                if len(rows):
                    blocked.append((kind, some, rows, times))
        return blocked

    # --- claims ---

    def _where(self, state: State, pairs: PairList, row: int, pair: str) -> dict[str, Any]:
        return {"time": state.time, "state": state.index, "pair": pair, **self.surface.names(pairs, row)}

    def claims(self) -> list[Claim]:
        if not self.surface.can_touch.any():
            basis = "scene"
            detail = "contact is switched off, or between all bodies"
            names = ("no_intersection", "minimum_distance", "paths")
            return [Claim(name, "contact of bodies", NOT_APPLICABLE, basis, detail=detail) for name in names]
        return [
            self._no_intersection(),
            self._minimum_distance(),
            self._paths(),
            self._reported_distance(),
        ]

    def _no_intersection(self) -> Claim:
        found = self.intersections
        return Claim(
            "no_intersection",
            f"no edge meets a triangle in any accepted state{self.scope}",
            VIOLATED if found else VERIFIED,
            "states, exact predicates",
            float(len(found)),
            0.0,
            where=found[0] if found else None,
            detail=_listed(found, "edge-triangle pairs meet"),
        )

    def _minimum_distance(self) -> Claim:
        status = VIOLATED if self.too_near else INCONCLUSIVE if self.unsure else VERIFIED
        bound, required, where = self.worst_gap or (None, None, None)
        detail = "" if self.worst_gap else "no two surfaces come within their contact distances"
        if self.too_near:
            detail = f"too near in {self.too_near} states"
        elif self.unsure:
            detail = f"rounding leaves the distance open in {self.unsure} states"
        elif lacking := self.run.lacks("contact.min_separation_factor"):
            status, detail = INCONCLUSIVE, lacking
        elif self.told:
            detail = f"nearer in {self.told} states, which the run says itself"
        return Claim(
            "minimum_distance",
            "surfaces keep contact.min_separation_factor times the sum of their contact distances, or the "
            "step says that they do not" + self.scope,
            status,
            "states, bounds that hold in spite of rounding",
            bound,
            required,
            "m",
            where,
            detail,
        )

    def _paths(self) -> Claim:
        steps = max(0, len(self.least) - 1 - len(self.unrecorded))
        open_steps = len({place["state"] for place in self.blocked})
        ways = [f"all vertices move straight in {steps - self.arcs - self.detours - open_steps} steps"]
        ways += [f"rigid bodies turn on arcs in {self.arcs}"] if self.arcs else []
        if self.detours:
            ways.append(
                f"{self.detours} have detours of up to {self.largest_detour:.3g} m from the straight lines"
            )
        ways += [placed_text(self.placed)] if self.placed else []
        status, where, detail = VERIFIED, None, "; ".join(ways)
        if self.passed:
            status, where = VIOLATED, self.passed[0]
            detail = _listed(self.passed, "vertices changed sides of a closed surface")
        elif self.blocked:
            status, where = INCONCLUSIVE, self.blocked[0]
            detail = _listed(
                _by_bodies(self.blocked),
                f"pairs of bodies in {open_steps} steps have no clear path that was found",
            )
            detail += "; the solver's own path within a step is not recorded"
        elif self.long_detours:
            status, where = INCONCLUSIVE, self.long_detours[0]
            detail = _listed(self.long_detours, "steps have clear paths only far from the straight lines")
            detail += f"; up to {self.largest_detour:.3g} m, more than a tenth of the smallest body there"
        elif self.unrecorded:
            status, where = INCONCLUSIVE, self.unrecorded[0]
            detail = f"bodies were placed before {len(self.unrecorded)} steps, and the states after that are "
            detail += "not recorded: call record_state(sim) after placing, too"
        return Claim(
            "paths",
            "from each accepted state to the next there is a path on which nothing passes through anything"
            + self.scope,
            status,
            "states, supporting planes",
            self.largest_detour,
            None,
            "m",
            where,
            detail,
        )

    def _reported_distance(self) -> Claim:
        """The solver's own figure against the measured one, two formulas for the same positions. In
        recordings of older versions, which lack the last motion, reported distances are those before the last
        Newton iteration, in which points move by less than newton.step_tolerance times the time step."""
        settings = self.run.settings
        current = all("last_motion" in row for row in self.run.rows)
        speed = 0.0 if current else self.run.bound("newton.step_tolerance") or 0.0
        bounded = current or (speed > 0.0 and settings.get("newton.termination", "all") == "all")
        rim = np.unique(self.surface.distance[:, None] + self.surface.distance)
        share, worst, allowed, where, detail = 0.0, 0.0, 0.0, None, ""
        for row, measured in zip(self.run.rows, self.least[1:], strict=False):
            given = row.get("min_distance")
            reported = math.inf if given is None else number(row, "min_distance")
            if not reported >= 0.0 and not detail:
                detail = f"step {row.get('step')} reports min_distance = {given!r} m: must be >= 0"
                where = {"time": number(row, "time"), "reported": given, "measured": _finite(measured)}
            settled = current or row.get("solve_status") == "converged"
            if detail or reported == measured or math.isnan(measured) or not settled:
                continue
            least = min(reported, measured)
            # A pair at the very rim of its contact distance may be in contact for one and not for the other.
            other = max(reported, measured)
            difference = float(np.abs(rim - least).min()) if other == math.inf else other - least
            h = number(row, "time_step")
            limit = _REPORT_ROUNDING * least + 2.0 * speed * (h if 0.0 < h < math.inf else 0.0)
            limit += _PLACE_ROUNDING * self.farthest
            # Where one says that surfaces touch and the other that they do not, no rounding explains it.
            ratio = difference / limit if limit > 0.0 else math.inf
            if ratio > share:
                share, worst, allowed = ratio, difference, limit
                where = {"time": number(row, "time"), "reported": given, "measured": _finite(measured)}
        return Claim(
            "reported_distance",
            "the least distance that the solver reports for a step is the one of its state",
            VIOLATED if detail else VERIFIED if share <= 1.0 else VIOLATED if bounded else INCONCLUSIVE,
            "states against telemetry",
            None if detail else worst,
            None if detail else allowed,
            "m",
            where,
            detail,
            required=False,
        )


def placed_text(placed: list[dict[str, Any]]) -> str:
    """What was placed and when, which no path leads to."""
    names = [f"{', '.join(map(repr, p['bodies'][:_LISTED]))} at {p['time']:.6g} s" for p in placed]
    more = f" and {len(names) - _LISTED} times more" if len(names) > _LISTED else ""
    times = "once" if len(names) == 1 else f"{len(names)} times"
    return f"the user has placed bodies {times}, a jump that is no path: {'; '.join(names[:_LISTED])}{more}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _title(kind: Kind) -> str:
    return "point-triangle" if kind == Kind.POINT_TRIANGLE else "edge-edge"


def _bodies_of(blocked: Blocked) -> set[tuple[int, ...]]:
    return {tuple(pair) for _, pairs, rows, _ in blocked for pair in pairs.bodies[rows].tolist()}


def _by_bodies(places: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The first place of each step and pair of bodies."""
    first: dict[Any, dict[str, Any]] = {}
    for place in places:
        first.setdefault((place["state"], *sorted(place["bodies"])), place)
    return list(first.values())


def _listed(places: list[dict[str, Any]], what: str) -> str:
    if not places:
        return ""
    texts = [f"{place['time']:.6g} s {' and '.join(place['bodies'])} {place['vertices']}" for place in places]
    more = f" and {len(texts) - _LISTED} more" if len(texts) > _LISTED else ""
    return f"{len(places)} {what}: " + ", ".join(texts[:_LISTED]) + more
