"""Posture of a robot with more joints than a goal needs: of the q that reach it the one next to a wanted one.

Sequential quadratic programming with the distance of the coordinates as objective and the goal as equality,
limits of joints in an active set, a merit function with the error as penalty (Nocedal and Wright, Numerical
Optimization (2006), 16.5 and 18.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stark.robots.inverse import Bounds, Goal, Kinematics, Reach, Search, descend, stopped

Floats = NDArray[np.float64]

#: Of a coordinate in one step [rad, m].
_LARGEST_STEP = 0.3
#: A step below which the posture is found [rad, m], and the least share of a step that is tried.
_ARRIVED, _SHORTEST = 1e-9, 1e-6
#: Singular values of the Jacobian over the largest one below which a direction does not count.
_SINGULAR = 1e-6


def settled(
    search: Search,
    found: Reach,
    wanted: Floats,
    kinematics: Kinematics,
    bounds: Bounds,
    names: tuple[str, ...],
) -> Reach:
    """What a search found, after it slid along the goal to where it is next to a wanted posture."""
    slid = _next_to(wanted, kinematics, search.goal, found.q, bounds, search.iterations)
    q, frame, iterations = descend(kinematics, search.goal, slid, bounds, search.iterations)
    total = found.iterations + iterations
    other = Reach(q, *search.goal.distances(frame), total, stopped(q, bounds, names))
    return other if search.is_met(other) else found


def _next_to(
    wanted: Floats, kinematics: Kinematics, goal: Goal, start: Floats, bounds: Bounds, iterations: int
) -> Floats:
    """The q (n,) at the goal with the least distance of all coordinates from ``wanted``, downhill from
    ``start``, which is at the goal; near it to the second order of the last step."""
    q, penalty = start, 0.0
    frame, columns = kinematics(q)
    for _ in range(iterations):
        error, away = goal.errors(frame), wanted - q
        step, multipliers = _step(goal.rows(columns), error, away, (q, *bounds))
        size = float(np.abs(step).max(initial=0.0))
        if size < _ARRIVED:
            break
        penalty = max(penalty, 2.0 * float(np.linalg.norm(multipliers)) + 1.0)
        before = 0.5 * float(away @ away) + penalty * float(np.linalg.norm(error))
        share = min(1.0, _LARGEST_STEP / size, _room(step, q, bounds))
        while share > _SHORTEST:
            tried = np.clip(q + share * step, *bounds)
            frame, columns = kinematics(tried)
            distance = 0.5 * float((wanted - tried) @ (wanted - tried))
            if distance + penalty * float(np.linalg.norm(goal.errors(frame))) < before:
                break
            share *= 0.5
        else:
            break
        q = tried
    return q


def _step(
    jacobian: Floats, error: Floats, away: Floats, box: tuple[Floats, Floats, Floats]
) -> tuple[Floats, Floats]:
    """Towards the wanted posture where the goal leaves the choice, and to the goal; the multipliers of the
    goal. Coordinates at a bound that would leave it are held."""
    q, lower, upper = box
    free = lower < upper
    while True:
        part = jacobian[:, free]
        solved = np.linalg.lstsq(part @ part.T, part @ away[free] - error, rcond=_SINGULAR**2)
        multipliers: Floats = np.asarray(solved[0], dtype=np.float64)
        step = np.zeros_like(q)
        step[free] = away[free] - part.T @ multipliers
        leaving = free & (((q <= lower) & (step < 0.0)) | ((q >= upper) & (step > 0.0)))
        if not leaving.any():
            return step, multipliers
        free &= ~leaving


def _room(step: Floats, q: Floats, bounds: Bounds) -> float:
    """Share of the step that leads to the first bound, infinite where none is on the way."""
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(step > 0.0, (bounds[1] - q) / step, (bounds[0] - q) / step)
    return float(shares[step != 0.0].min(initial=np.inf))
