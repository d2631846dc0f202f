"""Motions: values as functions of time, for bodies and pins that follow them.

    lift = stark.motion.spline([0.0, 1.0, 2.0], [(0, 0, 0), (0, 0, 0.2), (0.1, 0, 0.2)])
    turn = stark.motion.rotations([0.0, 2.0], [np.eye(3), stark.rotation(axis="z", angle=1.0)])
    finger.follow(position=lift, rotation=turn)

A motion is called with a time [s]. Motions through knots hold the first value before the first time and the
last one after the last."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import given_flag, given_path, is_iterable, real_array, real_number, refuse_masked
from stark.attributes import own_names
from stark.mesh import TriangleMesh
from stark.mesh.usd_files import read_usd, without_unused
from stark.point_cache import read_point_cache
from stark.rotations import as_matrix, to_quaternion

Floats = NDArray[np.float64]


class Motion:
    """A value as a function of time: ``motion(0.5)`` [s]. Made by the functions of this module."""

    def __init__(
        self,
        value: Callable[[float], Any],
        duration: float | None,
        text: str,
        knots: dict[str, Any] | None = None,
    ) -> None:
        self._value = value
        self._text = text
        self._knots = knots  # kind, times, values and options of what made it; None for functions
        self.duration = duration
        """Time of the last knot [s], None for functions of time."""

    def __call__(self, time: float) -> Floats:
        return real_array(self._value(float(time)), f"{self!r} at {time:g} s")

    def __repr__(self) -> str:
        return f"<stark.motion {self._text}>"

    def __reduce__(self) -> tuple[Any, ...]:
        if self._knots is None:
            return Motion, (self._value, self.duration, self._text)
        return _again, (self._knots, self._text)


def linear(times: ArrayLike, values: ArrayLike) -> Motion:
    """Straight lines between knots: ``times`` (n,) [s], rising, and ``values`` (n, ...)."""
    t, v = _knots("linear", times, values, 1)

    def value(time: float) -> Floats:
        k, s, _ = _interval(t, time)
        place: Floats = v[k] if s == 0.0 else (1.0 - s) * v[k] + s * v[k + 1]
        return place

    knots = {"kind": "linear", "times": t, "values": v}
    return Motion(value, float(t[-1]), f"linear through {len(t)} knots", knots)


def spline(times: ArrayLike, values: ArrayLike, *, rest: bool = True) -> Motion:
    """Cubic spline through knots with continuous velocity and acceleration: ``times`` (n,) [s], rising, and
    ``values`` (n, ...). It starts and ends at rest, or with ``rest=False`` without acceleration (a natural
    spline: the velocity then jumps at the ends, where the values are held)."""
    rest = given_flag(rest, "spline: rest")
    t, v = _knots("spline", times, values, 2)
    slopes = _slopes(t, v, rest)

    def value(time: float) -> Floats:
        k, s, h = _interval(t, time)
        place: Floats = v[k]
        if s == 0.0:
            return place
        # Cubic Hermite polynomial of the interval.
        r = 1.0 - s
        ends = (1.0 + 2.0 * s) * r * r * v[k] + (1.0 + 2.0 * r) * s * s * v[k + 1]
        place = ends + h * s * r * (r * slopes[k] - s * slopes[k + 1])
        return place

    knots = {"kind": "spline", "times": t, "values": v, "rest": rest}
    return Motion(value, float(t[-1]), f"spline through {len(t)} knots", knots)


def point_cache(path: str | os.PathLike[str], *, fps: float = 24.0, smooth: bool = False) -> Motion:
    """Positions of the vertices of a mesh over time, from a PC2 file of another program with ``fps`` frames a
    second; the first frame is at 0 s. For a character whose vertices are all pinned, in the order of its
    mesh: ``body.follow(stark.motion.point_cache("walk.pc2"))``. Straight lines between frames, or with
    ``smooth`` a natural spline. Raises InvalidArgument for files that are missing or damaged."""
    rate, smooth = real_number(fps, "point_cache: fps"), given_flag(smooth, "point_cache: smooth")
    if not 0.0 < rate < np.inf:
        raise InvalidArgument(f"point_cache: fps = {fps!r}: must be > 0 and finite")
    found = read_point_cache(given_path(path, "point_cache: path"))
    times = np.arange(len(found.positions)) * (found.rate / rate)
    if smooth and len(times) > 1:
        return spline(times, found.positions, rest=False)
    return linear(times, found.positions)


class AnimatedMesh(NamedTuple):
    """A surface, and the positions of its vertices over time."""

    mesh: TriangleMesh
    """As it is in the first frame."""
    motion: Motion
    """Of all its vertices, in the world."""


def usd_mesh(path: str | os.PathLike[str], prim: str | None = None, *, smooth: bool = False) -> AnimatedMesh:
    """The meshes of a USD file as one moving surface, or those at and below the prim with this path:
    ``skin, walk = stark.motion.usd_mesh("walk.usdc", "/World/Character")``. In metres, z up; the first frame
    is at 0 s. Points, frames and skeletons may move. Of surfaces that are open, vertices that are always at
    the same place become one. Straight lines between frames, or with ``smooth`` a natural spline. Raises
    InvalidMesh for files and prims that cannot be read; needs ``usd-core``."""
    smooth = given_flag(smooth, "usd_mesh: smooth")
    found = without_unused(read_usd(given_path(path, "usd_mesh: path"), _path_of(prim), moving=True))
    if smooth and len(found.times) > 1:
        return AnimatedMesh(found.mesh, spline(found.times, found.frames, rest=False))
    return AnimatedMesh(found.mesh, linear(found.times, found.frames))


def _path_of(prim: str | None) -> str | None:
    if prim is not None and not isinstance(prim, str):
        raise InvalidArgument(f"usd_mesh: prim = {prim!r}: must be the path of a prim, as '/World/body'")
    return prim


def rotations(times: ArrayLike, values: Any, *, smooth: bool = True, rest: bool = True) -> Motion:
    """Rotations through knots: ``times`` (n,) [s], rising, and n matrices or quaternions (w, x, y, z), each
    less than half a turn from the next. The value is a matrix (3, 3).

    ``smooth``: a spline of quaternions with continuous angular velocity and acceleration, ``rest`` as in
    ``spline``; otherwise constant angular velocity between knots."""
    smooth, rest = given_flag(smooth, "rotations: smooth"), given_flag(rest, "rotations: rest")
    if not is_iterable(values):
        raise InvalidArgument(f"rotations: values = {values!r}: must be matrices or quaternions")
    matrices = [as_matrix(value, f"rotations: value {k}") for k, value in enumerate(values)]
    quaternions = [to_quaternion(matrix) for matrix in matrices]
    for k in range(1, len(quaternions)):  # q and -q are the same rotation: the nearer one to the last
        cosine = float(quaternions[k] @ quaternions[k - 1])
        if abs(cosine) < 1e-6:
            raise InvalidArgument(
                f"rotations: values {k - 1} and {k} are half a turn apart: must be less; add a knot between "
                f"them"
            )
        quaternions[k] = quaternions[k] * np.sign(cosine)
    t, q = _knots("rotations", times, np.array(quaternions).reshape(-1, 4), 1 if not smooth else 2)
    through = spline(t, q, rest=rest) if smooth else None

    def value(time: float) -> Floats:
        quaternion = _slerp(t, q, time) if through is None else through(time)
        return as_matrix(quaternion, f"rotations at {time:g} s")

    knots = {
        "kind": "rotations", "times": t, "values": np.array(matrices), "smooth": smooth,
        "rest": rest,
    }  # fmt: skip
    return Motion(value, float(t[-1]), f"rotations through {len(t)} knots", knots)


def function(value: Callable[[float], ArrayLike]) -> Motion:
    """A motion from a function of the time [s]. It must depend on nothing else, or a rewind differs."""
    if not callable(value):
        raise InvalidArgument(f"function: value = {value!r}: must be a function of the time [s]")
    return Motion(value, None, f"of {getattr(value, '__name__', 'a function')}")


def as_motion(value: Any, owner: str) -> Motion:
    """A motion or a plain function of time."""
    if isinstance(value, Motion):
        return value
    if callable(value):
        return function(value)
    raise InvalidArgument(
        f"{owner} = {value!r}: must be a motion, such as stark.motion.spline(times, values), or a function "
        f"of the time [s]"
    )


# --- details ---


def through_same_knots(motion: Any, change: Callable[[Floats], Floats]) -> Motion | None:
    """The motion through the same knots with other values, so that documents can hold it; None for rotations
    and for functions of the time."""
    knots = motion._knots if isinstance(motion, Motion) else None
    if knots is None or knots["kind"] == "rotations":
        return None
    return _again({**knots, "values": change(knots["values"])}, motion._text)


def _again(knots: dict[str, Any], text: str) -> Motion:
    """The motion that was pickled."""
    made: dict[str, Callable[..., Motion]] = {"linear": linear, "spline": spline, "rotations": rotations}
    same = made[knots["kind"]](**{name: value for name, value in knots.items() if name != "kind"})
    same._text = text
    return same


def _knots(owner: str, times: ArrayLike, values: ArrayLike, fewest: int) -> tuple[Floats, Floats]:
    refuse_masked(times, f"{owner}: times")
    refuse_masked(values, f"{owner}: values")
    try:
        t, v = real_array(times, owner), real_array(values, owner)
    except InvalidArgument:
        raise InvalidArgument(
            f"{owner}: times and values must be numbers, a row of values for each time"
        ) from None
    if t.ndim != 1 or v.ndim < 1 or len(t) != len(v) or len(t) < fewest:
        raise InvalidArgument(
            f"{owner}: times of shape {t.shape} and values of shape {v.shape}: must be (n,) and (n, ...) "
            f"with n >= {fewest}"
        )
    if not (np.isfinite(t).all() and np.isfinite(v).all()):
        raise InvalidArgument(f"{owner}: times [s] and values must be finite; check where they are computed")
    falls = np.flatnonzero(~(np.diff(t) > 0.0))
    if falls.size:
        k = int(falls[0])
        raise InvalidArgument(f"{owner}: times[{k}] = {t[k]:g} s, times[{k + 1}] = {t[k + 1]:g} s: must rise")
    return t, v


def _interval(t: Floats, time: float) -> tuple[int, float, float]:
    """Interval of a time, the fraction in it, its length [s]; at knots and outside the fraction is 0."""
    k = min(max(int(t.searchsorted(time, side="right")) - 1, 0), len(t) - 1)  # np.clip is slow
    if time <= t[0] or k == len(t) - 1:
        return k, 0.0, 0.0
    h = float(t[k + 1] - t[k])
    return k, float(time - t[k]) / h, h


def _slopes(t: Floats, v: Floats, rest: bool) -> Floats:
    """Velocities at the knots for which the acceleration is continuous: a tridiagonal system [de Boor 1978,
    ch. IV], solved by elimination."""
    n = len(t)
    h = np.diff(t)
    secants = np.diff(v, axis=0) / h.reshape((-1,) + (1,) * (v.ndim - 1))
    lower, diagonal, upper, right = np.zeros(n), np.ones(n), np.zeros(n), np.zeros_like(v)
    for k in range(1, n - 1):
        lower[k], diagonal[k], upper[k] = h[k], 2.0 * (h[k - 1] + h[k]), h[k - 1]
        right[k] = 3.0 * (h[k] * secants[k - 1] + h[k - 1] * secants[k])
    if not rest:
        diagonal[0], upper[0], right[0] = 2.0, 1.0, 3.0 * secants[0]
        diagonal[-1], lower[-1], right[-1] = 2.0, 1.0, 3.0 * secants[-1]
    for k in range(1, n):
        factor = lower[k] / diagonal[k - 1]
        diagonal[k] -= factor * upper[k - 1]
        right[k] -= factor * right[k - 1]
    right[-1] /= diagonal[-1]
    for k in range(n - 2, -1, -1):
        right[k] = (right[k] - upper[k] * right[k + 1]) / diagonal[k]
    return right


def _slerp(t: Floats, q: Floats, time: float) -> Floats:
    """Between quaternions at constant angular velocity [Shoemake 1985]."""
    k, s, _ = _interval(t, time)
    turned: Floats = q[k]
    if s == 0.0:
        return turned
    # The angle from the chord: exact for small ones.
    angle = 2.0 * np.arcsin(min(1.0, 0.5 * float(np.linalg.norm(q[k + 1] - q[k]))))
    if angle < 1e-8:
        turned = (1.0 - s) * q[k] + s * q[k + 1]
    else:
        turned = (np.sin((1.0 - s) * angle) * q[k] + np.sin(s * angle) * q[k + 1]) / np.sin(angle)
    return turned


def __dir__() -> list[str]:
    return own_names(__name__, globals())
