"""Paths of fibres from edges in any order."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import as_array
from stark.mesh import Indices


@dataclass(frozen=True)
class FibrePaths:
    """Vertices along fibres, and their edges in the order in which the user knows them."""

    paths: tuple[Indices, ...]
    edges: Indices
    """(m, 2) vertices."""
    rows: NDArray[np.intp]
    """(m,) row of ``edges`` of each edge, path by path."""
    edge_nodes: NDArray[np.intp]
    """(m, 2) nodes of each row of ``edges``, counted over all paths; the ends of a ring are one node."""
    given_as_edges: bool = False

    def by_path(
        self, fields: dict[str, tuple[NDArray[np.float64], bool]], owner: str
    ) -> dict[str, tuple[NDArray[np.float64], bool]]:
        """Values of each edge, from the order of ``edges`` to that of the paths."""
        sorted_fields = {}
        for name, (values, per_edge) in fields.items():
            if per_edge and (values.size == 0 or values.size % len(self.rows)):
                raise InvalidArgument(
                    f"{owner}: {name} has {values.size} numbers: must be a multiple of the {len(self.rows)} "
                    f"edges; give one number for all, or values for each edge"
                )
            rows = values.reshape(len(self.rows), -1)[self.rows].reshape(-1) if per_edge else values
            sorted_fields[name] = rows, per_edge
        return sorted_fields


def paths_from(edges: ArrayLike | None, paths: Any, owner: str) -> FibrePaths:
    """One of edges (m, 2) and paths. What the indices are is left to the core, which checks them."""
    if paths is not None:
        rows = _rows(paths, owner)
        segments = [np.column_stack([path[:-1], path[1:]]) for path in rows]
        all_edges = np.concatenate([*segments, np.empty((0, 2), dtype=np.int32)])
        return _fibre_paths(rows, all_edges, np.arange(len(all_edges)))
    array = as_array(edges, f"{owner}: edges")
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iu" or not len(array):
        raise InvalidArgument(
            f"{owner}: edges of shape {array.shape} and type {array.dtype}: must be vertex indices of shape "
            f"(m, 2), at least one row"
        )
    given = array.astype(np.int32)
    ends = np.sort(given, axis=1)
    if (ends[:, 0] == ends[:, 1]).any() or len(np.unique(ends, axis=0)) < len(ends):
        return _fibre_paths(list(given), given, np.arange(len(given)))  # refused by the core, which says why
    chained, order = _chained(given)
    return replace(_fibre_paths(chained, given, order), given_as_edges=True)


def _rows(paths: Any, owner: str) -> list[Indices]:
    """One path or several, as rows of integers."""
    try:
        is_one = len(paths) > 0 and all(np.ndim(entry) == 0 for entry in paths)
        rows = [np.asarray(row) for row in ([paths] if is_one else paths)]
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(f"{owner}: paths = {paths!r}: must be rows of vertex indices") from None
    for k, row in enumerate(rows):
        if row.ndim != 1 or (row.size and row.dtype.kind not in "iu"):
            raise InvalidArgument(
                f"{owner}: path {k} of shape {row.shape} and type {row.dtype}: must be a row of vertex "
                f"indices"
            )
    return [row.astype(np.int32) for row in rows]


def _fibre_paths(paths: list[Indices], edges: Indices, order: NDArray[np.intp]) -> FibrePaths:
    nodes = np.empty((len(edges), 2), dtype=np.intp)
    first = k = 0
    for path in paths:
        is_ring = len(path) > 0 and path[0] == path[-1]
        count = len(path) - int(is_ring)
        local = np.arange(max(len(path) - 1, 0))
        nodes[order[k : k + len(local)]] = first + np.column_stack([local, (local + 1) % max(count, 1)])
        first += count
        k += len(local)
    for array in (*paths, edges):
        array.setflags(write=False)
    return FibrePaths(tuple(paths), edges, order, nodes)


def _chained(edges: Indices) -> tuple[list[Indices], NDArray[np.intp]]:
    """Paths that go on where two edges meet, and the row of each of their edges; rings come last."""
    at: dict[int, list[int]] = {}
    for row, edge in enumerate(edges.tolist()):
        for v in edge:
            at.setdefault(v, []).append(row)
    used = np.zeros(len(edges), dtype=bool)
    paths: list[Indices] = []
    order: list[int] = []

    def walk(start: int, row: int) -> None:
        path = [start]
        while True:
            used[row] = True
            order.append(row)
            a, b = edges[row].tolist()
            path.append(b if path[-1] == a else a)
            onward = [r for r in at[path[-1]] if not used[r]]
            if len(at[path[-1]]) != 2 or not onward:
                break
            row = onward[0]
        paths.append(np.array(path, dtype=np.int32))

    for row, edge in enumerate(edges.tolist()):
        for v in edge:
            if len(at[v]) != 2 and not used[row]:
                walk(v, row)
    for row in range(len(edges)):
        if not used[row]:
            walk(int(edges[row, 0]), row)
    return paths, np.array(order, dtype=np.intp)
