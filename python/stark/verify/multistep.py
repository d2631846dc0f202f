"""Steps of bdf2, backward differences of order 2 with variable steps: what the velocities of a state have to
be, from its places and from what the state before had [theory eq. 26, 26a, 26c].

With bdf2 a recorded state has, beside places, velocities v and lags Q, by which velocities are ahead of the
mean ones of the step that led there; for what turns, increments of angular momentum A, by contact p, and
lags."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .files import need
from .rotation import free_rotation, torque
from .weights import Group, Moving

Floats = NDArray[np.float64]

_EPSILON = 2.0**-52
_ROUNDING = 32.0 * _EPSILON


@dataclass(frozen=True)
class Step:
    """Coefficients of a kind of step: v1 = (x1 - x0 - ahead v0 + lag Q0) / duration."""

    length: float  # h [s]
    duration: float  # sigma [s]
    history: float = 0.0  # c; 0 where the step before has no say
    ahead: float = 0.0  # b [s]
    lag: float = 0.0  # l [s]
    renewal: float = 0.5  # Q1 = renewal (Q0 + v1 - v0), without contact
    lasting: float = 0.0  # share of the increment by contact that goes on
    is_resolved: bool = False  # whether contact is as other forces

    @property
    def is_impact(self) -> bool:
        """Whether velocities at its end are its mean ones; forces of joints then count as contact."""
        return self.history > 0.0 and self.ahead == 0.0


def kinds_of_step(h: float, before: float, has_history: bool, lasting: float) -> list[Step]:
    """What a step of length h may have been, after one of length ``before`` [s]; which of them it was follows
    from the contact ahead, that no state tells. ``lasting``: the share of contact that went on, as
    reported, which is one for all bodies."""
    if not has_history:
        return [Step(h, h)]
    if not 0.0 < before < math.inf:
        return []
    w = h / before
    s, c = h * (1.0 + w) / (1.0 + 2.0 * w), w * w / (1.0 + 2.0 * w)
    rest = h - s
    return [
        Step(h, s, c, rest, rest, rest / h, 1.0, is_resolved=True),
        Step(h, s, c, rest, rest, rest / h, lasting),
        Step(h, h, c, 0.0, h * w, rest / h, lasting),
    ]


@dataclass(frozen=True)
class Motion:
    """Points of a group, (n, 3) each: places [m], velocities and lags [m/s], at the start and at the end."""

    group: Group
    places: tuple[Floats, Floats]
    velocities: tuple[Floats, Floats]
    lags: tuple[Floats, Floats]

    def wrong_velocity(self, step: Step) -> float:
        """Largest difference of a way and what the velocities make of it, over what rounding allows."""
        (x0, x1), (v0, v1) = self.places, self.velocities
        return self._share((x1, -x0, -step.ahead * v0, step.lag * self.lags[0], -step.duration * v1))

    def wrong_lag(self, step: Step) -> float:
        """The same of the lags at the end, for a step without contact; 0 where contact of the step before
        goes on in part, which no state tells of points."""
        if step.lasting > 0.0 and not step.is_resolved:
            return 0.0
        v0, v1 = self.velocities
        old, new = self.lags
        parts = (new, -step.renewal * v1, step.renewal * v0)
        return self._share((*parts, -step.renewal * old) if step.history else parts)

    def _share(self, parts: tuple[Floats, ...]) -> float:
        """Largest component of a sum that should vanish, over the rounding of its terms."""
        if parts[0].size == 0:
            return 0.0
        allowed = _ROUNDING * sum(self.group.largest(part) for part in parts)
        return float((self.group.largest(np.asarray(sum(parts))) / np.maximum(allowed, 1e-300)).max())


def motion_of(group: Group, start: Moving, end: Moving) -> Motion:
    """Of a group in a step; points without mass rest."""
    known = (start.velocities, end.velocities, start.lags, end.lags)
    need(all(rows is not None for rows in known), "a state lacks velocities or lags of a body")
    moves = (group.masses[:, None] > 0.0) | group.is_rigid
    rows = [np.where(moves, row, 0.0) for row in (start.places, end.places, *known) if row is not None]
    x0, x1, v0, v1, lag0, lag1 = rows
    return Motion(group, (x0, x1), (v0, v1), (lag0, lag1))


def impulse(start: Floats, end: Floats, moments: Floats, before: Floats, spins: Floats, step: Step) -> Floats:
    """Change of the angular momenta ``before`` (n, 3) in a step that brought the rotations from ``start`` to
    ``end``; spins (n, 3, 3): A, p and Q of angular momenta at its start [kg m^2/s]."""
    free = free_rotation(start, moments, leading_momentum(before, spins, step), step.length)
    changed: Floats = _goes_on(spins, step) + torque(free, end, moments) / step.duration
    return changed


def leading_momentum(before: Floats, spins: Floats, step: Step) -> Floats:
    """Angular momenta (n, 3) of the free motion that a step is measured against."""
    leading: Floats = before + (step.duration * _goes_on(spins, step) - step.lag * spins[:, 2]) / step.length
    return leading


def _goes_on(spins: Floats, step: Step) -> Floats:
    """Increments of the step before that act on."""
    goes_on: Floats = step.history * (spins[:, 0] + step.lasting * spins[:, 1])
    return goes_on
