"""Files that meshio reads: solids and surfaces of finite element programs, and their named groups."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark import _core
from stark._core import InvalidMesh
from stark.mesh.abaqus_files import cells_of, name_parts, sections_of
from stark.mesh.arguments import Indices, require_finite
from stark.mesh.gmsh_files import require_numbers
from stark.mesh.repair import doubles, oriented
from stark.mesh.types import SolidMesh, TetMesh, TriangleMesh

#: Types of cells that solids are made of.
_SOLIDS = ("hexahedron27", "hexahedron20", "tetra10", "hexahedron", "tetra")
#: The corners of the triangles that cells of a surface are cut into.
_PIECES = {"triangle": ((0, 1, 2),), "quad": ((0, 1, 2), (0, 2, 3))}


class _Cells(NamedTuple):
    """The cells of a file that its mesh is made of."""

    kind: str
    corners: NDArray[np.int64]
    """(n, nodes), numbered as in the file, each once."""
    first: dict[int, int]
    """Of each block of the file that is part of it, its first row."""
    kept: Indices
    """Of each row of the file, that of ``corners``. MSH 2 has a cell once for each physical group of it."""


def groups_by_meshio(file: Path) -> dict[str, tuple[Indices, Indices]]:
    """Vertices and elements of the groups of a file, by name."""
    read = _read(file)
    cells = _cells(read, file)
    number = _numbering(read, cells)
    parts: dict[str, tuple[list[Any], list[Any]]] = {}
    for k, block in enumerate(read.cells):
        for name, rows in _members(read, k):
            vertices, elements = parts.setdefault(name, ([], []))
            _require_nodes(block.data[rows], len(number), f"'{file}': group '{name}': {block.type}", 0)
            vertices.append(number[np.unique(block.data[rows])])
            if k in cells.first:
                pieces = len(_PIECES.get(block.type, (0,)))
                at = np.add.outer(cells.first[k] + pieces * rows, np.arange(pieces)).ravel()
                elements.append(cells.kept[at])
    for name, points in read.point_sets.items():
        parts.setdefault(name, ([], []))[0].append(number[np.asarray(points, dtype=np.int64)])
    middles = _middles(number[cells.corners]) if cells.kind == "hexahedron20" else None
    groups: dict[str, tuple[Indices, Indices]] = {}
    for name, (of_nodes, of_rows) in parts.items():
        chosen, whole = _together(of_nodes), _together(of_rows)
        if middles is not None:
            chosen = np.concatenate([chosen, middles.within(chosen, whole)])
        groups[name] = (chosen, whole)
    return groups


def load_by_meshio(file: Path) -> TriangleMesh | TetMesh | SolidMesh:
    """The solid of a file, or else its surface, without vertices that no cell of it uses."""
    read = _read(file)
    cells = _cells(read, file)
    _require_points(read, cells, file)
    corners = _numbering(read, cells)[cells.corners]
    points = read.points[np.unique(cells.corners)]
    if cells.kind in _PIECES:
        return TriangleMesh(points, corners)
    if cells.kind == "hexahedron20":
        middles = _middles(corners)
        return SolidMesh(middles.added_to(points), middles.cells)
    return oriented(TetMesh(points, corners)) if cells.kind == "tetra" else SolidMesh(points, corners)


class _Middles(NamedTuple):
    """The nodes that hexahedra of 20 nodes have not: those of faces and of middles, after all others."""

    cells: Indices
    """(m, 27)."""
    faces: Indices
    """(k, 8), corners and edges of the face of each new node."""
    first: int
    """Number of the first of them."""

    def added_to(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """All nodes; new ones where the shape functions of 20 nodes have the face and the middle."""
        corners, edges = points[self.faces[:, :4]].sum(axis=1), points[self.faces[:, 4:]].sum(axis=1)
        rows = points[self.cells[:, :20]]
        middles = (rows[:, 8:].sum(axis=1) - rows[:, :8].sum(axis=1)) / 4.0
        return np.concatenate([points, edges / 2.0 - corners / 4.0, middles])

    def within(self, vertices: Indices, elements: Indices) -> Indices:
        """The new nodes of faces all of whose nodes are chosen, and of chosen elements."""
        faces = np.flatnonzero(np.isin(self.faces, vertices).all(axis=1)) + self.first
        return np.concatenate([faces, self.cells[elements, 26]]).astype(np.int32)


def _middles(cells: Indices) -> _Middles:
    """Of hexahedra of 20 nodes (m, 20)."""
    corners, cube = _cube()
    unit, order = _core.to_quadratic({"vertices": corners, "elements": cube})
    unit = unit[order[0]]
    around = []  # of each node of a face, the nodes of that face
    for node in unit[20:26]:
        axis = int(np.argmax(np.abs(node)))
        around.append(np.flatnonzero(np.abs(unit[:20, axis] - node[axis]) < 1e-9))
    rows = cells[:, np.array(around)].reshape(-1, 8)
    _, first, which = np.unique(np.sort(rows[:, :4], axis=1), axis=0, return_index=True, return_inverse=True)
    count = int(cells.max()) + 1
    numbers = count + which.reshape(-1, 6)
    middles = count + len(first) + np.arange(len(cells))[:, None]
    return _Middles(np.hstack([cells, numbers, middles]).astype(np.int32), rows[first], count)


def _cube() -> tuple[NDArray[np.float64], Indices]:
    """Corners in the order of VTK, about the origin, and one element."""
    bottom = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    corners = np.column_stack((np.tile(bottom, (2, 1)), np.repeat([-1.0, 1.0], 4)))
    return corners, np.arange(8, dtype=np.int32)[None]


def _read(file: Path) -> Any:
    """The mesh of meshio."""
    try:
        import meshio
    except ImportError as error:
        raise ImportError(f"'{file}': this format needs meshio: pip install 'stark-sim[mesh]'") from error
    if file.suffix.lower() == ".msh":
        require_numbers(file)
    sections = sections_of(file) if file.suffix.lower() == ".inp" and file.is_file() else []
    said = io.StringIO()
    try:
        # It prints why a file cannot be read, and then ends the process.
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            read = meshio.read(cells_of(sections), "abaqus") if sections else meshio.read(file)
    except ImportError as error:
        raise ImportError(f"'{file}': {error}; install it") from error
    except (Exception, SystemExit) as error:
        why = " ".join(said.getvalue().split()) if isinstance(error, SystemExit) else f"{error}"
        if not isinstance(error, (SystemExit, meshio.ReadError)) or not why:
            why = "meshio finds no mesh in it" + (f" ({error})" if isinstance(error, ValueError) else "")
            if isinstance(error, LookupError):
                why = "an element names a node that is not there, or the file is cut off; write it anew"
        raise InvalidMesh(f"'{file}' cannot be read: {why}") from None
    if sections:
        name_parts(read, sections, file)
    return read


def _cells(read: Any, file: Path) -> _Cells:
    """Of the highest dimension that the file has; InvalidMesh for types that bodies cannot have."""
    dimension = {block.type: block.dim for block in read.cells}
    types = list(dimension)
    solids = [name for name in types if dimension[name] == 3]
    kinds = solids or [name for name in types if dimension[name] == 2]
    if not kinds or not ((kinds[0] in _SOLIDS and len(kinds) == 1) or set(kinds) <= set(_PIECES)):
        rule = f"must have cells of type {', '.join(_SOLIDS[:-1])} or tetra, or triangle and quad"
        if len(solids) > 1 and set(solids) & set(_SOLIDS):
            rule = "a solid must have cells of one type; mesh it with one, or split it into bodies"
        raise InvalidMesh(f"'{file}' has cells of type {', '.join(kinds or types) or 'none'}: {rule}")
    rows, first, count = [], {}, 0
    for k, block in enumerate(read.cells):
        if block.type in kinds:
            data = np.asarray(block.data, dtype=np.int64)
            pieces = _PIECES.get(block.type)
            if pieces is not None:
                data = data[:, np.asarray(pieces)].reshape(-1, 3)
            _require_nodes(data, len(read.points), f"'{file}': {block.type}", count)
            rows.append(data)
            first[k] = count
            count += len(data)
    corners = np.concatenate(rows)
    order = kept = np.arange(count, dtype=np.int32)
    if len(doubles(corners)):
        _, found, which = np.unique(corners, axis=0, return_index=True, return_inverse=True)
        order = np.sort(found)
        kept = np.searchsorted(order, found[which.reshape(-1)]).astype(np.int32)
    return _Cells(kinds[0], corners[order], first, kept)


def _require_nodes(corners: NDArray[np.int64], points: int, what: str, before: int) -> None:
    """That elements have nodes of the file. meshio gives -1 for numbers that no node has."""
    strays = (corners < 0) | (corners >= points)
    if strays.any():
        row = int(np.flatnonzero(strays.any(axis=1))[0])
        node = int(np.flatnonzero(strays[row])[0])
        raise InvalidMesh(
            f"{what} {before + row} (from 0): its node {node} (from 0) is none of the {points} in the file: "
            f"elements must name nodes that are there; write the file anew, with all nodes"
        )


def _require_points(read: Any, cells: _Cells, file: Path) -> None:
    used = np.zeros(len(read.points), dtype=bool)
    used[cells.corners] = True
    require_finite(np.where(used[:, None], read.points, 0.0), f"'{file}': point")


def _numbering(read: Any, cells: _Cells) -> Indices:
    """The new number of each point of the file, -1 of those that no cell uses."""
    used = np.unique(cells.corners)
    numbers = np.full(len(read.points), -1, dtype=np.int32)
    numbers[used] = np.arange(len(used), dtype=np.int32)
    return numbers


def _members(read: Any, block: int) -> Iterator[tuple[str, NDArray[np.int64]]]:
    """Names of the groups with cells in a block of the file, and their rows in it."""
    names = {}
    if "gmsh:physical" in read.cell_data:
        dimension = read.cells[block].dim
        tags = np.asarray(read.cell_data["gmsh:physical"][block])
        named = {int(tag): name for name, (tag, dim) in read.field_data.items() if dim == dimension}
        names = {named.get(int(tag), str(tag)): np.flatnonzero(tags == tag) for tag in np.unique(tags) if tag}
    for name, rows in read.cell_sets.items():
        if rows[block] is not None and len(rows[block]) and not name.startswith("gmsh:"):
            names[name] = np.asarray(rows[block], dtype=np.int64)
    yield from names.items()


def _together(parts: list[Any]) -> Indices:
    found = np.unique(np.concatenate(parts)) if parts else np.zeros(0)
    return found[found >= 0].astype(np.int32)
