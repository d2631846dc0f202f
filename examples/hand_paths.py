"""Paths of a hand as paths of the joints of its arm."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

import stark


def of_joints(
    robot: stark.robots.Robot,
    hand: str,
    places: Iterable[ArrayLike],
    rotation: ArrayLike,
    joints: str | list[str],
    start: ArrayLike,
) -> np.ndarray:
    """q (k, n) that has a link at places (k, 3) [m] with one rotation (3, 3), each from the one before, so
    that the arm does not change its posture on the way."""
    q, rows = np.asarray(start, dtype=np.float64), []
    for place in places:
        q = robot.inverse_kinematics(hand, place, rotation, joints=joints, start=q).q
        rows.append(q)
    return np.array(rows)


def at(time: float, times: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """q (n,) at a time [s], on straight lines between rows (k, n) at times (k,); held before and after."""
    return np.array([np.interp(time, times, column) for column in rows.T])
