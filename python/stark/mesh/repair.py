"""Repairs of meshes: unused vertices, vertices at the same place, orientation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument, InvalidMesh
from stark.mesh.arguments import Indices, Points, corners_of, numbers_of
from stark.mesh.types import EmbeddedMesh, Mesh, SolidMesh, TetMesh, TriangleMesh, compact
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
    cells, first, renumbered = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # keeps the order of the file
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    vertices, numbers = mesh.vertices[first[order]], rank[renumbered.reshape(-1)]
    if grid > 0.0:
        numbers = _across_cells(cells[order], vertices, float(grid))[numbers]
    found = numbers[elements].astype(np.int32)
    nodes = np.sort(found, axis=1)
    whole_ones = (nodes[:, 1:] != nodes[:, :-1]).all(axis=1)
    return compact(type(mesh)(vertices, found[whole_ones]))


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
    if surface.is_closed or len(np.unique(surface.vertices, axis=0)) == len(surface.vertices):
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
    by_edge: dict[tuple[int, int], list[int]] = {}
    for t, (a, b, c) in enumerate(triangles.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            by_edge.setdefault((min(edge), max(edge)), []).append(t)
    seen = np.zeros(len(triangles), dtype=bool)
    for seed in range(len(triangles)):
        if seen[seed]:
            continue
        seen[seed] = True
        component, stack = [seed], [seed]
        while stack:
            a, b, c = triangles[stack.pop()].tolist()
            for u, v in ((a, b), (b, c), (c, a)):
                neighbours = by_edge[min(u, v), max(u, v)]
                for other in neighbours if len(neighbours) == 2 else ():
                    if seen[other]:
                        continue
                    x, y, z = triangles[other].tolist()
                    if (u, v) in ((x, y), (y, z), (z, x)):  # runs the same way: turned over relative to us
                        triangles[other] = (z, y, x)
                    seen[other] = True
                    component.append(other)
                    stack.append(other)
        part = TriangleMesh(mesh.vertices, triangles[component])
        if part.is_closed and part.volume < 0.0:
            triangles[component] = triangles[component][:, ::-1]
    return TriangleMesh(mesh.vertices, triangles)


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
