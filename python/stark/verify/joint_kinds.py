"""The built-in joints, written down here once more: what each holds and its coordinates, from two frames.

The residuals and coordinates are those of docs/joints.md; a new joint is one entry of KINDS."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Lengths [m] and angles [rad], each held by its norm.
Residuals = tuple[list[Floats], list[Floats]]


@dataclass(frozen=True)
class JointKind:
    """Functions of two frames, origins p, q and axes as columns of A, B; ``held`` gets the values of the
    joint, too."""

    held: Callable[[Floats, Floats, Floats, Floats, dict[str, Any]], Residuals]
    coordinates: dict[str, Callable[[Floats, Floats, Floats, Floats], float]] = field(default_factory=dict)


def across(p: Floats, A: Floats, q: Floats) -> list[Floats]:
    """From p to q along the axes x and y of A."""
    return [A[:, :1].T @ (q - p), A[:, 1:2].T @ (q - p)]


def along(axis: int) -> Callable[[Floats, Floats, Floats, Floats], float]:
    """From p to q along an axis of A."""
    return lambda p, A, q, B: float(A[:, axis] @ (q - p))


def turn_about_z(p: Floats, A: Floats, q: Floats, B: Floats) -> float:
    """Rotation of b against a about their z axes [rad]."""
    return math.atan2(B[:, 0] @ A[:, 1], B[:, 0] @ A[:, 0])


def tilt(p: Floats, A: Floats, q: Floats, B: Floats) -> float:
    """Angle between the z axes [rad]."""
    return math.atan2(float(np.linalg.norm(np.cross(A[:, 2], B[:, 2]))), float(A[:, 2] @ B[:, 2]))


def between_z(A: Floats, B: Floats) -> list[Floats]:
    """What is zero where the z axes agree."""
    return [A[:, 2] - B[:, 2]]


def between_axes(A: Floats, B: Floats) -> list[Floats]:
    """What is zero where all axes agree."""
    return [A[:, 0] - B[:, 0], A[:, 2] - B[:, 2]]


KINDS: dict[str, JointKind] = {
    "fixed": JointKind(lambda p, A, q, B, values: ([p - q], between_axes(A, B))),
    "ball": JointKind(lambda p, A, q, B, values: ([p - q], [])),
    "hinge": JointKind(lambda p, A, q, B, values: ([p - q], between_z(A, B)), {"angle": turn_about_z}),
    "slider": JointKind(
        lambda p, A, q, B, values: (across(p, A, q), between_axes(A, B)), {"displacement": along(2)}
    ),
    "cylindrical": JointKind(
        lambda p, A, q, B, values: (across(p, A, q), between_z(A, B)),
        {"displacement": along(2), "angle": turn_about_z},
    ),
    "universal": JointKind(
        lambda p, A, q, B, values: ([p - q], [A[:, :1].T @ B[:, 1]]),
        {
            "angle_a": lambda p, A, q, B: math.atan2(B[:, 1] @ A[:, 2], B[:, 1] @ A[:, 1]),
            "angle_b": lambda p, A, q, B: math.atan2(A[:, 0] @ B[:, 2], A[:, 0] @ B[:, 0]),
        },
    ),
    "planar": JointKind(
        lambda p, A, q, B, values: ([A[:, 2:].T @ (q - p)], between_z(A, B)),
        {"displacement_x": along(0), "displacement_y": along(1), "angle": turn_about_z},
    ),
    "point_on_axis": JointKind(lambda p, A, q, B, values: (across(p, A, q), []), {"displacement": along(2)}),
    "distance": JointKind(
        lambda p, A, q, B, values: ([np.array([np.linalg.norm(q - p) - values["length"][0][0]])], [])
    ),
    "direction": JointKind(lambda p, A, q, B, values: ([], between_z(A, B)), {"angle": turn_about_z}),
    "orientation": JointKind(lambda p, A, q, B, values: ([], between_axes(A, B))),
    "span": JointKind(
        lambda p, A, q, B, values: ([], []),
        {"distance": lambda p, A, q, B: float(np.linalg.norm(q - p))},
    ),
    "tilt": JointKind(lambda p, A, q, B, values: ([], []), {"angle": tilt}),
}
