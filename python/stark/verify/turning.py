"""Velocities that implicit Euler leaves points with: differences of places, or, of free bodies that turn as a
whole, those in axes that turn with them [theory eq. 26f]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .rotation import turned

Floats = NDArray[np.float64]

_EPSILON = 2.0**-52
_RELATIVE = 1e-9
_ROUNDING = 1024.0
_ADDED_INERTIA, _ROUNDS = 0.01, 6
_LOOSE, _RIGID = 0.5, 0.9  # shares of the kinetic energy
_FULL_TURN, _LARGEST_TURN = 0.8, 1.2  # [rad]


def wrong_velocity(
    masses: Floats, places: tuple[Floats, Floats], velocities: tuple[Floats, Floats], h: float
) -> float:
    """Largest difference of the velocities at the end of a step of length h and of what one of the two rules
    makes of places (n, 3) and velocities at its start, over what rounding allows."""
    moves = masses > 0.0
    if not moves.any():
        return 0.0
    m, (x0, x1), (v0, v1) = masses[moves], (x[moves] for x in places), (v[moves] for v in velocities)
    reach = max(float(np.abs(x).max()) for x in (x0, x1))
    allowed = _RELATIVE * float(np.abs(v1).max()) + 64.0 * _EPSILON * reach / h
    # The way of a body that was fast rounds, too, and what flat bodies make of it is more.
    allowed += _ROUNDING * _EPSILON * float(np.abs(v0).max())
    wrong = [float(np.abs(v1 - v).max()) for v in ((x1 - x0) / h, turned_velocities(m, x0, v0, x1, h))]
    return min(wrong) / max(allowed, 1e-300)


def turned_velocities(masses: Floats, x0: Floats, v0: Floats, x1: Floats, h: float) -> Floats:
    """Velocities (n, 3) at the end of a step of free points from x0 with v0 to x1 (n, 3)."""
    total = masses.sum()
    centre, velocity, end = (masses @ rows / total for rows in (x0, v0, x1))
    r, u = x0 - centre, v0 - velocity
    momentum = masses @ np.cross(r, u)
    spin = _spin(masses, r, momentum)
    energy = float(masses @ (u * u).sum(axis=1))
    share = float(spin @ momentum) / energy if energy > 0.0 else 0.0
    angle = h * float(np.linalg.norm(spin))
    part = np.clip((share - _LOOSE) / (_RIGID - _LOOSE), 0.0, 1.0)
    spin = spin * part * np.clip((_LARGEST_TURN - angle) / (_LARGEST_TURN - _FULL_TURN), 0.0, 1.0)
    R = turned(h * spin[None], np.eye(3)[None])[0]
    carried = r @ R.T
    free = carried + h * (u - np.cross(spin, r)) @ R - h * h * np.cross(spin, np.cross(spin, carried))
    free += centre + h * velocity
    arms = x1 - end
    found = velocity + np.cross(spin, arms) + (x1 - centre - h * velocity - carried) / h
    if not spin.any():
        return np.asarray(found)
    lacking = momentum + masses @ np.cross(arms, (x1 - free) / h - found)
    return np.asarray(found + np.cross(_spin(masses, arms, lacking), arms))


def _spin(masses: Floats, arms: Floats, momentum: Floats) -> Floats:
    """Angular velocity of an angular momentum."""
    second = (arms * masses[:, None]).T @ arms
    size = float(np.trace(second))
    if size <= 0.0:
        return np.zeros(3)
    inertia = size * np.eye(3) - second
    inverse = np.linalg.inv(inertia + _ADDED_INERTIA * size * np.eye(3))
    spin = np.zeros(3)
    for _ in range(_ROUNDS):
        spin = spin + inverse @ (momentum - inertia @ spin)
    return spin
