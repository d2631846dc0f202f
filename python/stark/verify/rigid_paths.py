"""Paths on which rigid bodies turn on arcs: straight paths of their vertices cut corners in long steps."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .rotation import axis_and_angle
from .run import Body, State

Floats = NDArray[np.float64]

_FEWEST, _MOST = 4, 64  # pieces of a step
_ANGLE = math.radians(1.0)  # of a piece


def between(bodies: list[Body], start: State, end: State, angle: float = _ANGLE) -> list[Floats]:
    """Positions of all points at the ends of the pieces of a step, in which no body turns by more than
    ``angle`` [rad] if 64 are enough: rigid bodies turn evenly about their centres of mass, which move on
    straight lines like everything else. Empty if no body turns."""
    largest = largest_turn(start, end)
    if not largest > 0.0:
        return []
    turns = [_turn(a, b) for a, b in zip(start.poses, end.poses, strict=True)]
    fewest = _FEWEST if angle <= _ANGLE else 1
    count = int(np.clip(math.ceil(largest / angle * (1.0 - 1e-12)), fewest, _MOST))
    stations = [start.points()]
    for k in range(1, count):
        s, parts = k / count, []
        for i, body in enumerate(bodies):
            x0, x1 = start.positions[i], end.positions[i]
            turn = turns[i]
            if turn is None or turn[1] == 0.0:
                parts.append(x0 + s * (x1 - x0))
                continue
            centre_0, centre_1 = _centre(body, start.poses[i]), _centre(body, end.poses[i])
            arms = (x0 - centre_0) @ _rotation(turn[0], s * turn[1]).T
            parts.append(centre_0 + s * (centre_1 - centre_0) + arms)
        stations.append(np.concatenate(parts))
    return [*stations, end.points()]


def largest_turn(start: State, end: State) -> float:
    """Of all bodies in a step [rad]."""
    turns = [_turn(a, b) for a, b in zip(start.poses, end.poses, strict=True)]
    return max((turn[1] for turn in turns if turn is not None), default=0.0)


def _centre(body: Body, pose: Floats | None) -> Floats:
    assert pose is not None and body.inertia is not None
    centre: Floats = pose[0] + pose[1:] @ np.array(body.inertia["center_of_mass"])
    return centre


def _turn(pose_0: Floats | None, pose_1: Floats | None) -> tuple[Floats, float] | None:
    """Axis and angle of the shortest turn between two poses."""
    if pose_0 is None or pose_1 is None:
        return None
    return axis_and_angle(pose_1[1:] @ pose_0[1:].T)


def _rotation(axis: Floats, angle: float) -> Floats:
    """Rodrigues' formula."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Floats = np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
    return rotation
