"""Repairs of meshes: unused vertices, vertices at the same place, orientation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument, InvalidMesh
from stark.mesh.arguments import Indices, Points, corners_of, numbers_of
from stark.mesh.types import (
    EmbeddedMesh,
    Mesh,
    SolidMesh,
    TetMesh,
    TriangleMesh,
    compact,
    edge_counts,
    edge_numbers,
)
from stark.overloads import overload

#: Odd numbers by which the cells of a grid get one number each, and neighbours those next to it, modulo 2^64.
_MIXED = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


@overload
def merged(mesh: TriangleMesh, tolerance: float = 0.0) -> TriangleMesh: ...
@overload
def merged(mesh: TetMesh, tolerance: float = 0.0) -> TetMesh: ...
@overload
def merged(mesh: SolidMesh, tolerance: float = 0.0) -> SolidMesh: ...
def merged(mesh: Mesh, tolerance: float = 0.0) -> Mesh:
    """Copy in which vertices at the same place are one; collapsed triangles and elements go. With a
    ``tolerance`` [m] those of one cell of a grid of that size are one, and the first ones of cells that lie
    beside each other, if they are no farther apart."""
    if not isinstance(mesh, (TriangleMesh, TetMesh, SolidMesh)) or isinstance(mesh, EmbeddedMesh):
        raise InvalidMesh(f"merged: got {type(mesh).__name__}: must be a TriangleMesh, TetMesh or SolidMesh")
    grid = numbers_of(tolerance)
    if grid.shape != () or not 0.0 <= grid < np.inf:
        raise InvalidArgument(f"merged: tolerance = {tolerance!r} m: must be a number >= 0")
    name = "triangles" if isinstance(mesh, TriangleMesh) else "elements"
    elements = getattr(mesh, name)
    corners_of(mesh.vertices, elements, f"merged: {name}")
    keys = mesh.vertices if grid == 0.0 else np.round(mesh.vertices / grid)
    first, numbers = equal_rows(keys)
    vertices = mesh.vertices[first]
    if grid > 0.0:
        numbers = _across_cells(keys[first], vertices, float(grid))[numbers]
    found = numbers[elements].astype(np.int32)
    nodes = np.sort(found, axis=1)
    whole_ones = (nodes[:, 1:] != nodes[:, :-1]).all(axis=1)
    return compact(type(mesh)(vertices, found[whole_ones]))


def equal_rows(rows: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first of each group of equal rows (k,), in their order, and the group of each row (n,). np.unique
    of rows takes many times as long."""
    order = np.lexsort(rows.T)  # stable: the first of a group comes first
    ordered = rows[order]
    starts = np.concatenate([[True], (ordered[1:] != ordered[:-1]).any(axis=1)])[: len(rows)]
    first = order[starts]
    rank = np.empty_like(first)
    rank[np.argsort(first)] = np.arange(len(first))
    groups = np.empty_like(order)
    groups[order] = rank[np.cumsum(starts) - 1]
    return np.sort(first), groups


def _across_cells(cells: Points, vertices: Points, reach: float) -> NDArray[np.int64]:
    """For each of the vertices, one in a cell, the first one in the cells around it that is within reach and
    has not joined another; itself where there is none (n,). A grid alone would part what lies on either side
    of a border, however near."""
    cells = np.nan_to_num(cells, posinf=0.0, neginf=0.0)
    numbers = (cells - cells.min(axis=0, initial=0.0)).astype(np.uint64) @ _MIXED
    order = np.argsort(numbers)
    pairs = []
    for beside in np.ndindex(3, 3, 3):
        offset = np.array(beside) - 1
        if tuple(offset) <= (0, 0, 0):
            continue  # each two cells once
        wanted = numbers + offset.astype(np.uint64) @ _MIXED
        place = np.minimum(np.searchsorted(numbers, wanted, sorter=order), len(order) - 1)
        mine = np.flatnonzero(numbers[order[place]] == wanted)
        other = order[place[mine]]
        near = np.linalg.norm(vertices[mine] - vertices[other], axis=1) <= reach
        pairs.append(np.sort(np.column_stack([mine[near], other[near]]), axis=1))
    rows = np.concatenate(pairs)
    joins = np.arange(len(vertices))
    for one, later in rows[np.lexsort((rows[:, 0], rows[:, 1]))].tolist():
        if joins[one] == one and joins[later] == later:
            joins[later] = one
    return joins


def whole(surface: TriangleMesh) -> TriangleMesh:
    """With vertices at the same place as one, where the surface is open and has such, and without triangles
    that have a vertex twice."""
    triangles = surface.triangles
    if not (0 <= triangles.min() <= triangles.max() < len(surface.vertices)):
        return surface
    collapsed = (triangles == np.roll(triangles, 1, axis=1)).any(axis=1)
    if collapsed.any() and not collapsed.all():
        surface = TriangleMesh(surface.vertices, triangles[~collapsed])
    if surface.is_closed or len(equal_rows(surface.vertices)[0]) == len(surface.vertices):
        return surface
    united = merged(surface)
    return united if len(united.triangles) else surface


@overload
def oriented(mesh: TetMesh) -> TetMesh: ...
@overload
def oriented(mesh: TriangleMesh) -> TriangleMesh: ...
def oriented(mesh: TetMesh | TriangleMesh) -> TetMesh | TriangleMesh:
    """Copy with tetrahedra of positive volume; or with triangles that agree with their neighbours and, where
    they enclose a volume, face outwards."""
    if isinstance(mesh, TetMesh):
        tets = mesh.tets.copy()
        negative = mesh.volumes < 0.0
        tets[negative] = tets[negative][:, [0, 1, 3, 2]]
        return TetMesh(mesh.vertices, tets)
    if not isinstance(mesh, TriangleMesh):
        raise InvalidMesh(f"oriented: got {type(mesh).__name__}: must be a TriangleMesh or a TetMesh")
    corners_of(mesh.vertices, mesh.triangles, "oriented: triangles")
    return _oriented_triangles(mesh)


def turned_edge(triangles: Indices) -> tuple[int, int] | None:
    """The first edge whose two triangles (n, 3) run along it in the same direction, so that their normals
    point to opposite sides. None where there is no such edge; edges of three triangles and more do not
    count."""
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    _, rows, counts = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    forward = np.bincount(rows.ravel(), weights=edges[:, 0] < edges[:, 1])
    turned = (counts == 2) & (forward != 1)
    if not turned.any():
        return None
    a, b = sorted(edges[np.flatnonzero(rows.ravel() == np.argmax(turned))[0]].tolist())
    return a, b


def _oriented_triangles(mesh: TriangleMesh) -> TriangleMesh:
    triangles = mesh.triangles.copy()
    turned, part = _agreeing(triangles)
    triangles[turned] = triangles[turned][:, ::-1]
    order = np.argsort(part, kind="stable")
    for mine in np.split(order, np.flatnonzero(np.diff(part[order])) + 1):
        if len(mine) < 4 or (edge_counts(triangles[mine]) != 2).any():  # open
            continue
        used, corners = np.unique(triangles[mine], return_inverse=True)
        if TriangleMesh(mesh.vertices[used], corners.reshape(-1, 3)).volume < 0.0:
            triangles[mine] = triangles[mine][:, ::-1]
    return TriangleMesh(mesh.vertices, triangles)


def _agreeing(triangles: Indices) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Which triangles (m,) are to be turned over to agree with the first one that they are connected with by
    edges of two triangles, and the number of that one."""
    beside, same = _neighbours(triangles)
    turned, part = [False] * len(triangles), [-1] * len(triangles)
    for seed in range(len(triangles)):
        if part[seed] >= 0:
            continue
        part[seed] = seed
        stack = [seed]
        while stack:
            t = stack.pop()
            for side in (3 * t + 1, 3 * t, 3 * t + 2) if turned[t] else (3 * t, 3 * t + 1, 3 * t + 2):
                other = beside[side]
                if other >= 0 and part[other] < 0:
                    part[other] = seed
                    turned[other] = same[side] != turned[t]
                    stack.append(other)
    return np.array(turned, dtype=bool), np.array(part, dtype=np.int64)


def _neighbours(triangles: Indices) -> tuple[list[int], list[bool]]:
    """Of each side (3 m,): the other triangle of its edge, -1 where there is not one other; and whether both
    run along it in the same direction."""
    numbers = edge_numbers(triangles)
    order = np.argsort(numbers, kind="stable")
    _, begins, counts = np.unique(numbers[order], return_index=True, return_counts=True)
    one, two = order[begins[counts == 2]], order[begins[counts == 2] + 1]
    rises = (triangles < np.roll(triangles, -1, axis=1)).ravel()
    beside, same = np.full(len(numbers), -1), np.zeros(len(numbers), dtype=bool)
    beside[one], beside[two] = two // 3, one // 3
    same[one] = same[two] = rises[one] == rises[two]
    return beside.tolist(), same.tolist()


def doubles(elements: NDArray[np.integer[Any]]) -> Indices:
    """(n, 2): of each element with the nodes of an earlier one, that one and its own number."""
    nodes = np.sort(elements, axis=1)
    factors = np.cumprod(np.full(nodes.shape[1], 0x9E3779B97F4A7C15, dtype=np.uint64))
    keys = nodes.astype(np.uint64) @ factors  # modulo 2^64; numbers are sorted faster than rows
    if len(np.unique(keys)) == len(keys):
        return np.zeros((0, 2), dtype=np.int32)
    _, first, which = np.unique(nodes, axis=0, return_index=True, return_inverse=True)
    own = first[which.reshape(-1)]
    later = np.flatnonzero(own != np.arange(len(nodes)))
    return np.column_stack((own[later], later)).astype(np.int32)
