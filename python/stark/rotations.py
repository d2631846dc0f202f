"""Rotations as 3x3 matrices (columns are the axes of the body in the world) and the unit of angle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import real_array, real_number, refuse_masked, shown_value
from stark.caller import warn

Vec3Like: TypeAlias = Sequence[float] | NDArray[np.floating]

deg: float = math.pi / 180.0
"""One degree in radians: ``90 * stark.deg``."""

LARGEST = 1e150
"""Of components of vectors, as in sim/scene/validation.cpp: lengths are roots of sums of squares, which
overflow beyond."""

_WHOLE_RADIANS = 25
_NO_ANGLE = 1e9  # whole numbers from here on are mistakes of another kind
"""Four turns: an integer beyond is probably of degrees. A rate times a time is a float."""

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def _given(name: str, value: object) -> str:
    """Name and value as messages show them; of large arrays the shape."""
    return f"{name} = {shown_value(value, 200)}"


def vector(value: ArrayLike, name: str) -> NDArray[np.float64]:
    """Three finite numbers as an array of shape (3,), or InvalidArgument that calls them ``name``."""
    try:
        result = real_array(value, name)
    except InvalidArgument:
        refuse_masked(value, name)  # says more of those
        raise InvalidArgument(f"{_given(name, value)}: must be three numbers") from None
    if result.shape != (3,):
        raise InvalidArgument(f"{_given(name, value)}: must be three numbers, got the shape {result.shape}")
    if all(-LARGEST < number < LARGEST for number in result.tolist()):
        return result
    if not np.isfinite(result).all():
        raise InvalidArgument(f"{_given(name, value)}: must be finite; check where it is computed")
    raise InvalidArgument(f"{_given(name, value)}: none must be beyond 1e150; check where it is computed")


def direction(value: str | ArrayLike, name: str) -> NDArray[np.float64]:
    """A vector (3,) that is not zero, of any length: one of the axes "x", "y", "z" of the world, or three
    numbers."""
    if isinstance(value, str):
        if value not in _AXES:
            raise InvalidArgument(f"{_given(name, value)}: must be 'x', 'y', 'z' or three numbers")
        return np.array(_AXES[value])
    result = vector(value, name)
    if not result.any():
        raise InvalidArgument(f"{name} = (0, 0, 0): must have a direction; give 'x', 'y', 'z' or a vector")
    return result


def check_places(places: NDArray[np.float64], name: str, unit: str = "m") -> None:
    """That rows (n, 3) of positions or velocities are finite and not beyond what can be computed with."""
    wrong = np.flatnonzero(~(np.abs(places) < LARGEST).all(axis=1))  # also NaN
    if wrong.size:
        raise InvalidArgument(
            f"{name}[{wrong[0]}] = {places[wrong[0]].tolist()} {unit}: must be finite, none beyond 1e150; "
            f"check where it is computed"
        )


def warn_of_degrees(what: str, angle: object) -> None:
    """Of a whole number beyond four turns."""
    if not isinstance(angle, (int, np.integer)) or not _WHOLE_RADIANS < abs(int(angle)) < _NO_ANGLE:
        return
    warn(
        f"{what} = {angle} rad is {int(angle) / math.tau:.1f} turns: angles are in radians; "
        f"write {angle} * stark.deg if {angle} degrees are meant, {angle}.0 if not"
    )


def rotation(
    *,
    axis: str | Vec3Like | None = None,
    angle: float | None = None,
    quaternion: ArrayLike | None = None,
    vector: Vec3Like | None = None,
) -> NDArray[np.float64]:
    """Rotation matrix of shape (3, 3), from one of

    * ``axis`` ("x", "y", "z" or a 3-vector of any length) and ``angle`` [rad],
    * ``quaternion`` (w, x, y, z), scalar first, normalised here,
    * ``vector``: the axis times the angle [rad].
    """
    given = [axis is not None or angle is not None, quaternion is not None, vector is not None]
    if sum(given) != 1:
        raise InvalidArgument("rotation: give exactly one of axis= and angle=, quaternion=, vector=")
    if quaternion is not None:
        return _from_quaternion(quaternion, "rotation: quaternion")
    if vector is not None:
        rotation_vector = _vector(vector, "rotation: vector")
        return _from_axis(rotation_vector, float(np.linalg.norm(rotation_vector)))
    if axis is None or angle is None:
        raise InvalidArgument(
            "rotation: axis= and angle= belong together; angle is in radians, use 90 * stark.deg"
        )
    along = direction(axis, "rotation: axis")
    warn_of_degrees("rotation: angle", angle)
    angle = real_number(angle, "rotation: angle")
    if not math.isfinite(angle):
        raise InvalidArgument(f"rotation: angle = {angle} rad: must be finite; check where it is computed")
    return _from_axis(along, angle)


def as_matrix(value: ArrayLike | None, name: str) -> NDArray[np.float64]:
    """Rotation given as None (identity), 3x3 matrix or quaternion (w, x, y, z), as a matrix."""
    if value is None:
        return np.eye(3)
    try:
        array = real_array(value, name)
    except InvalidArgument:
        array = np.empty(0)
    if array.shape == (4,):
        return _from_quaternion(array, name)
    if array.shape != (3, 3):
        raise InvalidArgument(
            f"{_given(name, value)}: must be a 3x3 matrix or a quaternion (w, x, y, z); "
            f"build it with stark.rotation(axis=, angle=)"
        )
    error = np.abs(array.T @ array - np.eye(3)).max()
    determinant = np.linalg.det(array) if np.isfinite(array).all() else math.nan
    if not (error < 1e-6 and determinant > 0.0):
        raise InvalidArgument(
            f"{name}: the matrix is off orthonormal by {error:.3g} and has determinant {determinant:.3g}: "
            f"must be a rotation with determinant 1; build it with stark.rotation(axis=, angle=)"
        )
    return array


def _from_axis(axis: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        return np.eye(3)
    x, y, z = axis / length
    # sin and 1 - cos through the half angle: no cancellation for small angles.
    s, c = math.sin(angle), 2.0 * math.sin(0.5 * angle) ** 2
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: NDArray[np.float64] = np.eye(3) + s * skew + c * (skew @ skew)
    return rotation


def _from_quaternion(value: ArrayLike, name: str) -> NDArray[np.float64]:
    try:
        q = real_array(value, name)
    except InvalidArgument:
        q = np.empty(0)
    norm = float(np.linalg.norm(q)) if q.shape == (4,) else math.nan
    if not (math.isfinite(norm) and norm > 0.0):
        raise InvalidArgument(
            f"{_given(name, value)}: must be four finite numbers (w, x, y, z), not all zero"
        )
    w, x, y, z = q / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def to_quaternion(matrix: ArrayLike) -> NDArray[np.float64]:
    """Unit quaternion (w, x, y, z) with w >= 0 of a rotation matrix."""
    R = as_matrix(matrix, "matrix")
    # The largest of the four components is computed by a root, the others from it: no division by small
    # numbers.
    t = np.array([np.trace(R), R[0, 0], R[1, 1], R[2, 2]])
    i = int(np.argmax(t))
    if i == 0:
        q = np.array([1.0 + t[0], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        a, b, c = i - 1, i % 3, (i + 1) % 3
        q = np.zeros(4)
        q[0] = R[c, b] - R[b, c]
        q[1 + a] = 1.0 + R[a, a] - R[b, b] - R[c, c]
        q[1 + b] = R[b, a] + R[a, b]
        q[1 + c] = R[c, a] + R[a, c]
    q /= np.linalg.norm(q)
    return -q if q[0] < 0 else q


_vector = vector  # rotation() has an argument of that name
