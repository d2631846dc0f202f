"""Pairs of overlapping boxes by a bounding volume hierarchy in NumPy: boxes sorted along a space-filling
curve, a complete binary tree above them, both trees walked together with all open pairs of nodes in one
array."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_OPEN_PAIRS = 1 << 19  # walked at a time, to bound the memory


class _Level:
    """Nodes of one level: bounds by axis (3, n), and the group of all boxes below, -1 for none."""

    def __init__(self, low: Floats, high: Floats, group: Integers) -> None:
        self.low, self.high, self.group = low, high, group

    def parents(self, mixed: int) -> _Level:
        a, b = self.group[::2], self.group[1::2]
        return _Level(
            np.minimum(self.low[:, ::2], self.low[:, 1::2]),
            np.maximum(self.high[:, ::2], self.high[:, 1::2]),
            np.where((b == -1) | (a == b), a, mixed),
        )


class BoxTree:
    """Boxes (n, 3) with a group each. Nodes whose boxes are all of one group know it, so that pairs of groups
    that do not matter are left early."""

    def __init__(self, low: Floats, high: Floats, group: Integers, group_count: int) -> None:
        count = len(low)
        self.count = count
        size = 1 << max(0, (count - 1).bit_length())
        #: Number of the box of each leaf.
        self.order: NDArray[Any] = (
            np.lexsort((_morton(0.5 * (low + high)), group)) if count else np.zeros(0, dtype=np.int64)
        )
        leaves = _Level(np.full((3, size), np.inf), np.full((3, size), -np.inf), np.full(size, -1))
        leaves.low[:, :count] = low[self.order].T
        leaves.high[:, :count] = high[self.order].T
        leaves.group[:count] = group[self.order]
        #: From the leaves to the root.
        self.levels: list[_Level] = [leaves]
        while self.levels[-1].group.size > 1:
            self.levels.append(self.levels[-1].parents(group_count))


def group_table(allowed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which groups matter to each other (G + 1, G + 1), from those that are allowed (G, G): the last one is
    that of nodes of several groups."""
    table = np.ones((len(allowed) + 1,) * 2, dtype=bool)
    table[:-1, :-1] = allowed
    table[-1, :-1], table[:-1, -1] = allowed.any(axis=0), allowed.any(axis=1)
    return table


def overlapping_pairs(a: BoxTree, b: BoxTree, table: NDArray[np.bool_]) -> tuple[Integers, Integers]:
    """Numbers of boxes of a and of b that overlap or touch, of groups that matter by their ``table``; a tree
    with itself gives each pair once, without a box with itself."""
    nothing = np.zeros(0, dtype=np.int64)
    if not a.count or not b.count:
        return nothing, nothing
    found = [(nothing, nothing)]
    root = np.zeros(1, dtype=np.int64)
    stack = [(len(a.levels) - 1, len(b.levels) - 1, root, root)]
    while stack:
        level_a, level_b, i, j = stack.pop()
        if len(i) > _OPEN_PAIRS:
            half = len(i) // 2
            stack += [(level_a, level_b, i[:half], j[:half]), (level_a, level_b, i[half:], j[half:])]
            continue
        i, j = _overlapping(a.levels[level_a], b.levels[level_b], i, j, table)
        if level_a == level_b == 0:
            found.append((i, j))
        elif len(i):
            i, j = _children(i, j, level_a == 0, level_b == 0, a is b)
            stack.append((max(0, level_a - 1), max(0, level_b - 1), i, j))
    i, j = (np.concatenate(column) for column in zip(*found, strict=True))
    if a is b:
        distinct = i < j
        i, j = i[distinct], j[distinct]
    return a.order[i], b.order[j]


def _overlapping(
    a: _Level, b: _Level, i: Integers, j: Integers, table: NDArray[np.bool_]
) -> tuple[Integers, Integers]:
    """Those pairs of nodes that overlap and whose groups matter; the first axis leaves few for the others."""
    keep = (a.low[0].take(i) <= b.high[0].take(j)) & (b.low[0].take(j) <= a.high[0].take(i))
    rows = np.flatnonzero(keep)
    i, j = i.take(rows), j.take(rows)
    keep = table[a.group.take(i), b.group.take(j)]
    for k in (1, 2):
        keep &= (a.low[k].take(i) <= b.high[k].take(j)) & (b.low[k].take(j) <= a.high[k].take(i))
    rows = np.flatnonzero(keep)
    return i.take(rows), j.take(rows)


def _children(i: Integers, j: Integers, keep_i: bool, keep_j: bool, same: bool) -> tuple[Integers, Integers]:
    """Pairs of children of both nodes; leaves stay as they are."""
    firsts = [i] if keep_i else [2 * i, 2 * i + 1]
    seconds = [j] if keep_j else [2 * j, 2 * j + 1]
    i = np.concatenate([p for p in firsts for _ in seconds])
    j = np.concatenate([q for _ in firsts for q in seconds])
    if not same:
        return i, j
    rows = np.flatnonzero(i <= j)
    return i.take(rows), j.take(rows)


def _morton(points: Floats) -> Integers:
    """Place along a Z-order curve of 10 bits a coordinate."""
    low, high = points.min(axis=0), points.max(axis=0)
    cells = ((points - low) / np.maximum(high - low, 1e-300) * 1023.0).astype(np.int64)
    return _spread(cells[:, 0]) | _spread(cells[:, 1]) << 1 | _spread(cells[:, 2]) << 2


def _spread(bits: Integers) -> Integers:
    """Two zero bits after each of ten."""
    for shift, mask in ((16, 0x30000FF), (8, 0x300F00F), (4, 0x30C30C3), (2, 0x9249249)):
        bits = (bits | bits << shift) & mask
    return bits
