"""Inverse kinematics: coordinates that bring a frame of a link to a wanted place.

Damped least squares (Levenberg-Marquardt) on the geometric Jacobian and its change, with limits of joints as
bounds of an active set; Siciliano et al., Robotics (2009), 3.5 and 3.7, and Nocedal and Wright, Numerical
Optimization (2006), 10.3 and 16.7."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import real_number
from stark.robots.kinematics import Placement

Floats = NDArray[np.float64]

#: Damping over the largest eigenvalue of the normal matrix: at first, and where a search ends.
_DAMPING, _LARGEST_DAMPING = 1e-3, 1e12
#: Of a joint in one iteration [rad]: beyond, the quadratic model is worth nothing.
_LARGEST_TURN = 1.0
#: A search ends where a step improves the squared error by less than this share of it.
_STALLED = 1e-13
#: What counts as standing at a limit: rounding of the last step may stop short of it [rad, m].
_AT_LIMIT = 1e-12


class Reach(NamedTuple):
    """What inverse kinematics found."""

    q: Floats  #: (n,) [rad, m], in the order of ``robot.coordinates``
    position_error: float  #: distance from the wanted position [m], 0 if none was wanted
    rotation_error: float  #: angle from the wanted rotation [rad], 0 if none was wanted
    iterations: int  #: of all attempts
    at_limits: tuple[str, ...]  #: joints that stand at a limit


@dataclass(frozen=True)
class Goal:
    """Of a frame of a link: ``position`` (3,) [m], ``rotation`` (3, 3), or both; ``length`` [m] is what an
    error of one radian counts as."""

    position: Floats | None
    rotation: Floats | None
    length: float

    def errors(self, frame: Placement) -> Floats:
        """(k,) [m] that vanish where a frame is at the goal; their derivatives are minus ``rows`` of the
        Jacobian to the first order of the angle."""
        parts = []
        if self.position is not None:
            parts.append(self.position - frame.position)
        if self.rotation is not None:
            parts.append(self.length * rotation_vector(self.rotation @ frame.rotation.T))
        return np.concatenate(parts)

    def rows(self, jacobian: Floats) -> Floats:
        """Those of a Jacobian (6, n) that belong to the errors, with their units."""
        parts = []
        if self.position is not None:
            parts.append(jacobian[:3])
        if self.rotation is not None:
            parts.append(self.length * jacobian[3:])
        return np.concatenate(parts)

    def curvature(self, columns: Floats, error: Floats) -> Floats:
        """(n, n): what the change of the Jacobian adds to the second derivatives of half the squared
        distance, without which a search for the nearest place creeps. Joint i moves column j of a joint
        further out by w_i x v_j. That of the rotation is left out."""
        count = columns.shape[1]
        if self.position is None:
            return np.zeros((count, count))
        # Entry (i, j) is -error . (w_i x v_j), i the inner one; coordinates go outwards.
        upper = np.triu(-np.cross(error[:3], columns[3:].T) @ columns[:3])
        return upper + np.triu(upper, 1).T

    def distances(self, frame: Placement) -> tuple[float, float]:
        """[m] and [rad] from the goal."""
        away = 0.0 if self.position is None else float(np.linalg.norm(self.position - frame.position))
        if self.rotation is None:
            return away, 0.0
        return away, float(np.linalg.norm(rotation_vector(self.rotation @ frame.rotation.T)))


#: Frame of the link and Jacobian (6, n) at some q.
Kinematics = Callable[[Floats], tuple[Placement, Floats]]
Bounds = tuple[Floats, Floats]


@dataclass(frozen=True)
class Search:
    """For q at a goal, within tolerances [m], [rad]: some attempts, of some iterations at most."""

    goal: Goal
    position_tolerance: float
    rotation_tolerance: float
    attempts: int
    iterations: int

    def run(self, kinematics: Kinematics, start: Floats, bounds: Bounds, names: tuple[str, ...]) -> Reach:
        """The first q that meets the tolerances, or the best."""
        best, total = None, 0
        for begin in _starts(start, bounds, self.attempts):
            q, frame, iterations = descend(kinematics, self.goal, begin, bounds, self.iterations)
            total += iterations
            found = Reach(q, *self.goal.distances(frame), total, stopped(q, bounds, names))
            if best is None or self._badness(found) < self._badness(best):
                best = found
            if self.is_met(found):
                break
        assert best is not None
        return best._replace(iterations=total)

    def is_met(self, found: Reach) -> bool:
        """Whether the tolerances are."""
        return (
            found.position_error <= self.position_tolerance
            and found.rotation_error <= self.rotation_tolerance
        )

    def refusal(self, owner: str, found: Reach, is_carried: bool) -> str:
        """What to say where they are not. ``is_carried``: whether joints that may move carry the link."""
        if not is_carried:
            return (
                f"{owner}: {found.position_error:.3g} m and {found.rotation_error:.3g} rad away, and no "
                f"joint that may move carries it: must be carried by one at least; give other joints, or "
                f"place what a loop holds by robot.q of the joints that drive it"
            )
        limits = f"; at their limits: {', '.join(found.at_limits)}" if found.at_limits else ""
        return (
            f"{owner}: the nearest of {self.attempts} attempts is {found.position_error:.3g} m and "
            f"{found.rotation_error:.3g} rad away{limits}: must be within {self.position_tolerance:g} m and "
            f"{self.rotation_tolerance:g} rad; give a goal within reach, more joints, or nearest=True"
        )

    def _badness(self, found: Reach) -> float:
        return math.hypot(found.position_error, self.goal.length * found.rotation_error)


def descend(
    kinematics: Kinematics, goal: Goal, start: Floats, bounds: Bounds, iterations: int
) -> tuple[Floats, Placement, int]:
    """The q (n,) downhill from ``start``, within bounds, where the squared error has a minimum, the frame
    there and the iterations that it took. Bounds that are equal hold a coordinate."""
    q, damping = np.clip(start, *bounds), _DAMPING
    frame, columns = kinematics(q)
    error = goal.errors(frame)
    for iteration in range(iterations):
        jacobian = goal.rows(columns)
        normal = jacobian.T @ jacobian + goal.curvature(columns, error)
        step = _step(normal, jacobian.T @ error, damping, (q, *bounds))
        turn = float(np.abs(step[columns[3:].any(axis=0)]).max(initial=0.0))
        moved = np.clip(q + min(1.0, _LARGEST_TURN / max(turn, 1e-300)) * step, *bounds)
        if np.array_equal(moved, q):
            return q, frame, iteration
        tried_frame, tried_columns = kinematics(moved)
        tried = goal.errors(tried_frame)
        before, gain = float(error @ error), float(error @ error - tried @ tried)
        if gain > 0.0:
            q, frame, columns, error = moved, tried_frame, tried_columns, tried
            damping = max(0.2 * damping, 1e-12)
            if gain <= _STALLED * before:
                return q, frame, iteration + 1
        else:
            damping *= 5.0
            if damping > _LARGEST_DAMPING:
                return q, frame, iteration + 1
    return q, frame, iterations


def _step(normal: Floats, downhill: Floats, damping: float, box: tuple[Floats, Floats, Floats]) -> Floats:
    """Damped Newton step of the coordinates that no bound holds."""
    q, lower, upper = box
    free = ~(((q <= lower) & (downhill <= 0.0)) | ((q >= upper) & (downhill >= 0.0)))
    step = np.zeros_like(q)
    while free.any():
        part = normal[np.ix_(free, free)]
        values, axes = np.linalg.eigh(part)
        scale = max(float(np.abs(values).max()), 1e-12)
        stiffness = np.maximum(np.abs(values), 1e-9 * scale) + damping * scale
        step[:] = 0.0
        step[free] = axes @ ((axes.T @ downhill[free]) / stiffness)
        # A coordinate at its bound that would leave it is held, and the others are solved for again.
        leaving = free & (((q <= lower) & (step < 0.0)) | ((q >= upper) & (step > 0.0)))
        if not leaving.any():
            break
        free &= ~leaving
        step[leaving] = 0.0
    return step


def stopped(q: Floats, bounds: Bounds, names: tuple[str, ...]) -> tuple[str, ...]:
    """Coordinates that stand at a limit."""
    stands = (q <= bounds[0] + _AT_LIMIT) | (q >= bounds[1] - _AT_LIMIT)
    at_limits = (bounds[0] < bounds[1]) & stands
    return tuple(name for name, stops in zip(names, at_limits, strict=True) if stops)


def _starts(start: Floats, bounds: Bounds, attempts: int) -> list[Floats]:
    """The given start, then random ones within the bounds, half a turn around the start where there are none;
    the same at every call."""
    random = np.random.default_rng(0)
    lower = np.where(np.isfinite(bounds[0]), bounds[0], start - math.pi)
    upper = np.where(np.isfinite(bounds[1]), bounds[1], start + math.pi)
    return [start, *(random.uniform(lower, upper) for _ in range(attempts - 1))]


def rotation_vector(rotation: Floats) -> Floats:
    """Axis times angle (3,) [rad] of a rotation matrix, angles in [0, pi]."""
    twice_sine = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine, cosine = 0.5 * float(np.linalg.norm(twice_sine)), 0.5 * (float(np.trace(rotation)) - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return twice_sine * (0.5 * angle / sine)
    if cosine > 0.0:
        return 0.5 * twice_sine
    # Half a turn: R = 2 a a^T - I; the longest column of R + I is along the axis.
    symmetric = 0.5 * (rotation + rotation.T) + np.eye(3)
    axis = symmetric[:, int(np.argmax(symmetric.diagonal()))]
    axis = axis / np.linalg.norm(axis)
    return angle * (axis if axis @ twice_sine >= 0.0 else -axis)


def positive(value: float, what: str, unit: str) -> float:
    """A number > 0, or InvalidArgument."""
    number = real_number(value, what)
    if not 0.0 < number < math.inf:
        raise InvalidArgument(f"{what} = {value!r} {unit}: must be a number > 0")
    return number


def count_of(value: int, what: str) -> int:
    """A whole number > 0, or InvalidArgument."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 1 <= value <= 1_000_000:
        raise InvalidArgument(f"{what} = {value!r}: must be a whole number in [1, 1000000]")
    return int(value)
