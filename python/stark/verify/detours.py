"""Looks for a clear path between two states near the straight one: what slides around a corner in a long
step, or meets in the middle of it, is in its own way on straight lines.

The search is a heuristic; the path that it finds is certified piece by piece like any other. From where it
is, the path heads straight for the end; pairs that would meet are kept on their sides of the plane between
their closest points (by projections in turn), which turns along as the pieces go on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .distances import Kind, closest, differences
from .surface import PairList, Surface

Floats = NDArray[np.float64]
#: Pairs in the way of each other on a straight path, and the times they got to.
Blocked = list[tuple[Kind, PairList, NDArray[np.int64], Floats]]
#: Points of pairs (k, 4), how many are of the first side, normals (k, 3) and gaps (k,) [m].
Plane = tuple[NDArray[np.int64], int, Floats, Floats]

_PIECES = 60
_ROUNDS = 6  # in which pairs join that would meet on the way around others
_SWEEPS = 100  # of projections
_SHARED = 8  # normals of the nearest pairs of two bodies
_KEPT_GAP = 0.5  # of the distance of a pair, at most
_STRIDE = 0.9  # of what is certified
_PATIENCE = 12  # pieces without getting nearer to the end


def find_detour(
    surface: Surface, x0: Floats, x1: Floats, blocked: Callable[[Floats, Floats], Blocked]
) -> list[Floats] | None:
    """Positions (N, 3) at the ends of the pieces of a clear path from x0 to x1; None if none was found."""
    weight = np.linalg.norm(x1 - x0, axis=1)
    weight = weight / max(float(weight.max()), 1e-300) + 1e-9
    stations, x, best, waited = [x0], x0, np.inf, 0
    for _ in range(_PIECES):
        goal, planes = x1, list[Plane]()
        in_the_way = blocked(x, goal)
        for _ in range(_ROUNDS):
            if not in_the_way:
                break
            planes += _planes(surface, x, in_the_way)
            goal = _kept_apart(x1, planes, weight)
            in_the_way = blocked(x, goal)
        if goal is x1:
            return [*stations, x1]
        if in_the_way:
            reached = min(float(times.min()) for *_, times in in_the_way)
            goal = x + _STRIDE * reached * (goal - x)
            if blocked(x, goal):
                return None
        x = goal
        stations.append(x)
        left = float((weight * np.linalg.norm(x1 - x, axis=1)).sum())
        waited = 0 if left < 0.99 * best else waited + 1
        best = min(best, left)
        if waited > _PATIENCE:
            return None
    return None


def largest_detour(stations: list[Floats]) -> float:
    """Largest distance of a vertex on a path from its straight line [m]."""
    x0, u = stations[0], stations[-1] - stations[0]
    length = np.einsum("ni,ni->n", u, u)
    largest = 0.0
    for x in stations[1:-1]:
        t = np.clip(np.einsum("ni,ni->n", x - x0, u) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        largest = max(largest, float(np.linalg.norm(x - x0 - t[:, None] * u, axis=1).max()))
    return largest


def _planes(surface: Surface, x: Floats, in_the_way: Blocked) -> list[Plane]:
    """Planes between pairs at x, and the gaps to be kept there. Two bodies share the normals of their nearest
    pairs where they separate others, too: those of the pairs around a corner would hold each other up."""
    near: dict[tuple[int, int], list[tuple[float, Floats]]] = {}
    found = []
    for kind, pairs, rows, _ in in_the_way:
        points, bodies = x[pairs.points[rows]], pairs.bodies[rows]
        distance, normal = closest(kind, points)
        sign = np.where(bodies[:, 0] < bodies[:, 1], 1.0, -1.0)[:, None]
        found.append((kind, pairs, rows, distance, normal, sign))
        for (a, b), d, n in zip(bodies.tolist(), distance.tolist(), sign * normal, strict=True):
            near.setdefault((min(a, b), max(a, b)), []).append((d, n))
    for shared in near.values():
        shared.sort(key=lambda entry: entry[0])
    planes = []
    for kind, pairs, rows, distance, normal, sign in found:
        d = differences(kind, x[pairs.points[rows]])
        chosen, kept = normal.copy(), distance.copy()
        for k, (a, b) in enumerate(pairs.bodies[rows].tolist()):
            for _, n in near[min(a, b), max(a, b)][:_SHARED] if a != b else []:
                gap = float((d[k] @ (sign[k] * n)).min())
                if gap > 1e-3 * distance[k]:
                    chosen[k], kept[k] = sign[k] * n, gap
                    break
        reach = surface.distance[pairs.bodies[rows]].sum(axis=1)
        planes.append((pairs.points[rows], pairs.first, chosen, _KEPT_GAP * np.minimum(kept, reach)))
    return planes


def _kept_apart(goal: Floats, planes: list[Plane], weight: Floats) -> Floats:
    """The goal, moved so that pairs stay on their sides of the planes between them."""
    y = goal.copy()
    for _ in range(_SWEEPS):
        shift, count = np.zeros_like(y), np.full(len(y), 1e-300)
        for points, first, normal, gap in planes:
            heights = np.einsum("kc,kpc->kp", normal, y[points])
            nearest_a, nearest_b = heights[:, :first].min(axis=1), heights[:, first:].max(axis=1)
            lack = gap - (nearest_a - nearest_b)
            rows = np.flatnonzero(lack > 0.0)
            if not len(rows):
                continue
            of_a = weight[points[rows, :first]].mean(axis=1)
            share = of_a / (of_a + weight[points[rows, first:]].mean(axis=1))
            # The nearer a point is to the other side, the more of it has to give way.
            down_a = nearest_a[rows] + lack[rows] * share
            up_b = nearest_b[rows] - lack[rows] * (1.0 - share)
            for k in range(points.shape[1]):
                h = heights[rows, k]
                push = np.maximum(0.0, down_a - h) if k < first else np.minimum(0.0, up_b - h)
                moved = push != 0.0
                np.add.at(shift, points[rows[moved], k], push[moved, None] * normal[rows[moved]])
                np.add.at(count, points[rows[moved], k], 1.0)
        if not shift.any():
            break
        y += 1.2 * shift / np.maximum(count, 1.0)[:, None]
    return y
