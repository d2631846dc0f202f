"""Whether pairs of primitives stay apart while their points move on straight lines.

A supporting plane certifies a stretch of time: along a fixed direction the gaps n.(a_i - b_j) of the points
of two convex hulls are linear in time, so while all of them are positive the hulls are apart. The march takes
the direction of the closest points, goes as far as it certifies, and takes a new one there. What is said to
be clear is clear whatever the rounding of closest points and times; what is not may be clear, too."""

from __future__ import annotations

from functools import reduce

import numpy as np
from numpy.typing import NDArray

from .distances import Kind, closest, differences, gaps

Floats = NDArray[np.float64]

_STRIDE = 0.95  # of the certified stretch, so that the next direction sees some distance
_MAX_PLANES = 256


def blocked_pairs(kind: Kind, x0: Floats, x1: Floats) -> tuple[NDArray[np.int64], Floats]:
    """Rows of pairs whose path from x0 to x1 (k, 4, 3) could not be certified, and the time in [0, 1] they
    got to."""
    near = np.flatnonzero(~_apart_along_axes(kind, x0, x1))
    stuck, reached = _march(kind, x0[near], x1[near])
    return near[stuck], reached


def _apart_along_axes(kind: Kind, x0: Floats, x1: Floats) -> NDArray[np.bool_]:
    """Pairs that a coordinate axis separates at both ends, and so on all of the path: exactly, as comparisons
    do not round."""
    count = int(kind)
    above, below = np.ones((len(x0), 3), dtype=bool), np.ones((len(x0), 3), dtype=bool)
    for x in (x0, x1):
        a, b = x[:, :count].swapaxes(0, 1), x[:, count:].swapaxes(0, 1)
        above &= reduce(np.minimum, a) > reduce(np.maximum, b)
        below &= reduce(np.maximum, a) < reduce(np.minimum, b)
    return np.asarray((above | below).any(axis=1))


def _march(kind: Kind, x0: Floats, x1: Floats) -> tuple[NDArray[np.int64], Floats]:
    """Rows that no planes carry to the end, and how far they do."""
    open_rows, time = np.arange(len(x0)), np.zeros(len(x0))
    blocked: list[NDArray[np.int64]] = []
    for _ in range(_MAX_PLANES):
        if not len(open_rows):
            break
        a, b, t = x0[open_rows], x1[open_rows], time[open_rows]
        n = closest(kind, a + t[:, None, None] * (b - a))[1]
        (start, error_0), (end, error_1) = gaps(n, differences(kind, a)), gaps(n, differences(kind, b))
        margin = np.maximum(error_0, error_1)[:, None] * 2.0
        start, end = start - margin, end - margin
        now = start + t[:, None] * (end - start)
        apart = (now > 0.0).all(axis=1) & (n != 0.0).any(axis=1)
        falling = end <= 0.0
        rate = np.where(start > end, start - end, 1.0)
        last = np.where(falling, start / rate, np.inf).min(axis=1)  # when the first gap closes
        clear = apart & (last == np.inf)
        reached = t + _STRIDE * (np.minimum(last, 1.0) - t)
        stuck = ~clear & (~apart | ~(reached > t + 1e-12))
        time[open_rows] = np.where(clear, 1.0, np.where(stuck, t, reached))
        blocked.append(open_rows[stuck])
        open_rows = open_rows[~clear & ~stuck]
    rows = np.sort(np.concatenate([*blocked, open_rows]))
    return rows, time[rows]
