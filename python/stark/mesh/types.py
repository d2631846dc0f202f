"""Meshes as NumPy arrays: surfaces, volumes, chains of points."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark import _core
from stark._core import InvalidArgument, InvalidMesh
from stark.arguments import given_path, nearest_hint, refuse_masked
from stark.array_file import write_atomically
from stark.attributes import AnsweredAttributes
from stark.mesh.arguments import (
    Indices,
    Points,
    columns_of,
    corners_of,
    indices_of,
    numbers_of,
    points_of,
    shape_of,
)
from stark.mesh.saving import WRITERS
from stark.overloads import overload
from stark.rotations import as_matrix, vector


def edge_counts(triangles: Indices) -> NDArray[np.int64]:
    return np.unique(edge_numbers(triangles), return_counts=True)[1]


def edge_numbers(triangles: Indices) -> NDArray[np.int64]:
    """Of the sides of triangles (3 m,): one number for an edge, whichever way a triangle runs along it.
    Numbers are sorted many times faster than rows."""
    low, high = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).astype(np.int64).T
    return np.asarray((low << 32) + high)


class MeshBase(AnsweredAttributes):
    vertices: Points
    #: What meshes of others call it, and what it is called here.
    _elsewhere: ClassVar[Mapping[str, str]] = {
        "faces": "triangles, of solids surface_triangles",
        "tetrahedra": "tets",
        "cells": "tets, of hexahedra elements",
        "points": "vertices",
        "edges": "triangles, whose sides they are",
        "is_watertight": "is_closed",
        "translate": "mesh.translated((x, y, z)), which makes a new mesh",
        "rotate": "mesh.rotated(stark.rotation(axis=, angle=)), which makes a new mesh",
        "scale": "mesh.scaled(factor), which makes a new mesh",
        "apply_transform": "mesh.rotated and mesh.translated, which make a new mesh",
    }

    def _unknown_attribute(self, name: str) -> str:
        known = [other for other in {*dir(type(self)), *self.__dict__} if not other.startswith("_")]
        elsewhere = self._elsewhere.get(name)
        hint = f": write {elsewhere}" if elsewhere else nearest_hint(name, sorted(known))
        return f"{type(self).__name__} has no attribute '{name}'{hint}"

    def __setattr__(self, name: str, value: object) -> None:
        if isinstance(value, np.ndarray) and getattr(self, name, None) is value:
            return  # the end of `mesh.vertices += offset`, which has written into the array
        raise AttributeError(f"{type(self).__name__} is immutable: make a new one instead of setting {name}")

    def _with(self, vertices: Points) -> Self:
        raise NotImplementedError

    def _require_vertices(self) -> None:
        """InvalidMesh for an index that is that of no vertex: no program could read such a file."""
        for name, array in self.__dict__.items():
            if name in ("triangles", "tets", "elements"):
                corners_of(self.vertices, array, f"{type(self).__name__}: {name}")

    def _kept(self) -> Self:
        """Copy for a body: whoever writes into the arrays of this mesh does not change that one."""
        kept = object.__new__(type(self))
        for name, array in self.__dict__.items():
            kept.__dict__[name] = array.copy()
            kept.__dict__[name].setflags(write=False)
        return kept

    @property
    def bounds(self) -> Points:
        """Lowest and highest corner, shape (2, 3) [m]."""
        if len(self.vertices) == 0:
            raise InvalidMesh(f"{type(self).__name__}: 0 vertices: must have at least one to have bounds")
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def scaled(self, factor: float | ArrayLike) -> Self:
        """Copy with all coordinates times a factor, or times one for each axis: ``scaled(1e-3)`` for
        millimetres."""
        factors = numbers_of(factor)
        if factors.shape not in ((), (3,)) or not (np.isfinite(factors) & (factors > 0)).all():
            raise InvalidArgument(f"scaled: factor = {factor!r}: must be one positive number or three")
        return self._with(self.vertices * factors)

    def translated(self, offset: ArrayLike) -> Self:
        """Copy moved by an offset [m]."""
        return self._with(self.vertices + vector(offset, "translated: offset"))

    def rotated(self, rotation: ArrayLike) -> Self:
        """Copy turned about the origin by a matrix or quaternion, as ``stark.rotation`` makes them."""
        return self._with(self.vertices @ as_matrix(rotation, "rotated: rotation").T)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the arrays, with all digits, as a NumPy file that ``stark.mesh.load`` reads:
        ``mesh.save("cup.npz")``."""
        file = given_path(path, "save: path")
        if file.suffix != ".npz":
            raise InvalidArgument(f"save: path = '{path}': must end in .npz")
        self._require_vertices()
        write_atomically(file, lambda stream: np.savez_compressed(stream, **self.__dict__))

    def centered(self) -> Self:
        """Copy with the middle of its bounds at the origin."""
        return self._with(self.vertices - self.bounds.mean(axis=0))


class TriangleMesh(MeshBase):
    """Surface: ``vertices`` (n, 3) float64 [m], ``triangles`` (m, 3) int32."""

    triangles: Indices

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        self.__dict__["vertices"] = points_of(vertices, "TriangleMesh: vertices")
        self.__dict__["triangles"] = indices_of(triangles, 3, "TriangleMesh: triangles")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file that ``stark.mesh.load`` reads, by its ending: ``mesh.save("cup.npz")`` the arrays
        with all digits, ``.obj`` and ``.ply`` the same for other programs, ``.stl`` in single precision.
        Coordinates are in metres."""
        file = given_path(path, "save: path")
        writer = WRITERS.get(file.suffix.lower())
        if writer is None and file.suffix != ".npz":
            raise InvalidArgument(f"save: path = '{path}': must end in .npz, {', '.join(WRITERS)}")
        if writer is None:
            super().save(file)
            return
        self._require_vertices()
        data = writer(self.vertices, self.triangles, file)
        write_atomically(file, lambda stream: stream.write(data))

    def _with(self, vertices: Points) -> TriangleMesh:
        return TriangleMesh(vertices, self.triangles)

    @property
    def is_closed(self) -> bool:
        """Whether every edge belongs to exactly two triangles."""
        return bool((edge_counts(self.triangles) == 2).all())

    @property
    def volume(self) -> float:
        """Signed volume [m^3], positive when the triangles are oriented outwards; only of closed meshes."""
        a, b, c = corners_of(self.vertices, self.triangles, "TriangleMesh: triangles")
        # About one of its points: about the origin, a body 1 km away would be what rounding leaves.
        o = a[:1]
        return float(np.einsum("ij,ij->", a - o, np.cross(b - o, c - o)) / 6.0)

    @property
    def area(self) -> float:
        """Area of all triangles [m^2]."""
        a, b, c = corners_of(self.vertices, self.triangles, "TriangleMesh: triangles")
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def flipped(self) -> TriangleMesh:
        """Copy with all triangles turned over."""
        return TriangleMesh(self.vertices, self.triangles[:, ::-1])

    def __repr__(self) -> str:
        return f"TriangleMesh({len(self.vertices)} vertices, {len(self.triangles)} triangles)"


class TetMesh(MeshBase):
    """Volume: ``vertices`` (n, 3) float64 [m], ``tets`` (m, 4) int32."""

    tets: Indices

    def __init__(self, vertices: ArrayLike, tets: ArrayLike) -> None:
        self.__dict__["vertices"] = points_of(vertices, "TetMesh: vertices")
        self.__dict__["tets"] = indices_of(tets, 4, "TetMesh: tets")

    def _with(self, vertices: Points) -> TetMesh:
        return TetMesh(vertices, self.tets)

    @property
    def elements(self) -> Indices:
        """``tets``, by the name that they have in meshes of other elements."""
        return self.tets

    @property
    def volumes(self) -> NDArray[np.float64]:
        """Signed volume of each tetrahedron [m^3], shape (m,)."""
        a, b, c, d = corners_of(self.vertices, self.tets, "TetMesh: tets")
        volumes: NDArray[np.float64] = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6.0
        return volumes

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return float(self.volumes.sum())

    def surface_triangles(self) -> Indices:
        """Boundary triangles (k, 3), outwards, as indices of ``vertices``."""
        faces = self.tets[:, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]].reshape(-1, 3)
        _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        boundary: Indices = faces[np.sort(first[counts == 1])]
        return boundary

    def surface(self) -> TriangleMesh:
        """The boundary as a mesh of its own, without the inner vertices."""
        return compact(TriangleMesh(self.vertices, self.surface_triangles()))

    def __repr__(self) -> str:
        return f"TetMesh({len(self.vertices)} vertices, {len(self.tets)} tets)"


class SolidMesh(MeshBase):
    """Volume of elements with 10 (quadratic tetrahedra), 8 or 27 nodes (trilinear and triquadratic
    hexahedra): ``vertices`` (n, 3) float64 [m], ``elements`` (m, 10 | 8 | 27) int32, nodes in the order of
    VTK. Four columns make linear tetrahedra, as a TetMesh does."""

    elements: Indices

    def __init__(self, vertices: ArrayLike, elements: ArrayLike) -> None:
        columns = columns_of(elements)
        if columns not in (4, 8, 10, 27):
            shape = shape_of(elements)
            got = f"the shape {shape}" if shape else "no rows of equal length"
            raise InvalidMesh(
                f"SolidMesh: elements: got {got}: must be (m, k) with 4, 8, 10 or 27 vertex indices each"
            )
        self.__dict__["vertices"] = points_of(vertices, "SolidMesh: vertices")
        self.__dict__["elements"] = indices_of(elements, columns, "SolidMesh: elements")

    def _with(self, vertices: Points) -> SolidMesh:
        return SolidMesh(vertices, self.elements)

    @property
    def volumes(self) -> NDArray[np.float64]:
        """Volume of each element [m^3], shape (m,)."""
        return _core.element_volumes({"vertices": self.vertices, "elements": self.elements})

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return float(self.volumes.sum())

    def surface_triangles(self) -> Indices:
        """Boundary triangles (k, 3), outwards, as indices of ``vertices``: faces of quadratic elements are
        cut into four or eight."""
        return _core.solid_boundary_triangles({"elements": self.elements})

    def surface(self) -> TriangleMesh:
        """The boundary as a mesh of its own, without the inner vertices."""
        return compact(TriangleMesh(self.vertices, self.surface_triangles()))

    def __repr__(self) -> str:
        kind = _core.element_name({"elements": self.elements})
        return f"SolidMesh({len(self.vertices)} vertices, {len(self.elements)} elements: {kind})"


def _moments_of_means(filling: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of files that have the part, the means and the mean squares of the coordinates: of boxes."""
    part, means, squares = filling[:, 0], filling[:, 1:4], filling[:, 4:]
    x, y, z = np.stack([np.ones_like(means), means, squares]).transpose(2, 0, 1)  # (power, m) each
    return np.asarray(np.einsum("m,im,jm,km->mkji", part, x, y, z).reshape(-1, 27))


class EmbeddedMesh(SolidMesh):
    """A surface in a lattice of hexahedra, as ``stark.mesh.lattice`` makes it: elasticity is that of the
    lattice, contact and pictures are of the surface, which follows it.

    ``vertices`` (n, 3) [m]: first the nodes, then the vertices of the surface. ``elements`` (m, 8 | 27):
    nodes of each cell. ``triangles`` (t, 3): the surface, as indices of ``vertices``. ``cells`` (k,): the
    element of each vertex of the surface. ``filling`` (m, 27): moments of what is inside of each cell, in
    units of the cell: integrals of x^i y^j z^k there, i, j, k in 0, 1, 2, at i + 3 j + 9 k. The first is the
    part of the cell that is inside."""

    elements: Indices
    triangles: Indices
    cells: Indices
    filling: NDArray[np.float64]

    def __init__(
        self,
        vertices: ArrayLike,
        elements: ArrayLike,
        triangles: ArrayLike,
        cells: ArrayLike,
        filling: ArrayLike,
    ) -> None:
        super().__init__(vertices, elements)
        where = "EmbeddedMesh: "
        if self.elements.shape[1] not in (8, 27):
            raise InvalidMesh(f"{where}elements have {self.elements.shape[1]} nodes: must have 8 or 27")
        self.__dict__["triangles"] = indices_of(triangles, 3, where + "triangles")
        self.__dict__["cells"] = indices_of(np.reshape(cells, (-1, 1)), 1, where + "cells")[:, 0]
        moments = numbers_of(filling)
        if moments.shape == (len(self.elements), 7):
            moments = _moments_of_means(moments)
        if moments.shape != (len(self.elements), 27):
            raise InvalidMesh(
                f"{where}filling: got the shape {moments.shape}: must be ({len(self.elements)}, 27): moments "
                f"of each element; use stark.mesh.lattice"
            )
        self.__dict__["filling"] = np.ascontiguousarray(moments, dtype=np.float64)
        wrong = self.cells[(self.cells < 0) | (self.cells >= len(self.elements))]
        if wrong.size:
            raise InvalidMesh(
                f"{where}cells: one of them is {wrong[0]}: must be in [0, {len(self.elements)}), as indices "
                f"of elements"
            )
        if not 0 < len(self.cells) < len(self.vertices):
            raise InvalidMesh(
                f"{where}cells: {len(self.cells)} of {len(self.vertices)} vertices are of the surface: must "
                f"be some, not all"
            )

    def _with(self, vertices: Points) -> EmbeddedMesh:
        return EmbeddedMesh(vertices, self.elements, self.triangles, self.cells, self.filling)

    def _embedding(self) -> dict[str, Any]:
        return {"cells": self.cells, "triangles": self.triangles, "filling": self.filling}

    def _as_one(self) -> dict[str, Any]:
        return {"vertices": self.vertices, "elements": self.elements, "embedding": self._embedding()}

    @property
    def node_count(self) -> int:
        """Number of nodes: vertices from it on are of the surface."""
        return len(self.vertices) - len(self.cells)

    @property
    def volumes(self) -> NDArray[np.float64]:
        """Volume that is inside of the surface in each element [m^3], shape (m,)."""
        return _core.element_volumes(self._as_one())

    def surface_triangles(self) -> Indices:
        """The surface (t, 3), as indices of ``vertices``."""
        return self.triangles

    def nodes_around(self, vertices: ArrayLike) -> Indices:
        """Nodes of the cells in which some vertices are, given by index or by a mask, and those among them
        that are nodes: what to pin to hold a part of the surface. Sorted, (k,)."""
        refuse_masked(vertices, "nodes_around: vertices")
        chosen = np.asarray(vertices)
        if chosen.dtype == bool and chosen.shape == (len(self.vertices),):
            chosen = np.flatnonzero(chosen)
        count = len(self.vertices)
        is_whole = chosen.dtype.kind in "iu" or chosen.size == 0
        if not is_whole or (chosen.size and not 0 <= chosen.min() <= chosen.max() < count):
            raise InvalidArgument(
                f"nodes_around: vertices: must be indices in [0, {count}) or a mask of them"
            )
        chosen = np.atleast_1d(chosen).astype(np.int64)
        inside = chosen[chosen >= self.node_count] - self.node_count
        nodes = [chosen[chosen < self.node_count], self.elements[self.cells[inside]].ravel()]
        return np.unique(np.concatenate(nodes)).astype(np.int32)

    def carried(self, values: ArrayLike) -> NDArray[np.float64]:
        """Values at all vertices of values at the nodes (``node_count``, ...): vertices of the surface get
        those of the shape functions of their cells."""
        refuse_masked(values, "carried: values")
        given = np.asarray(values, dtype=np.float64)
        if given.shape[:1] != (self.node_count,):
            raise InvalidArgument(
                f"carried: got the shape {given.shape}: must be ({self.node_count}, ...), a row for each node"
            )
        weights = _core.embedding_weights(self._as_one())
        of_cells = given[self.elements[self.cells]]
        return np.concatenate([given, np.einsum("kn,kn...->k...", weights, of_cells)])

    def __repr__(self) -> str:
        return (
            f"EmbeddedMesh({len(self.triangles)} triangles in {len(self.elements)} cells, {self.node_count} "
            f"nodes: {_core.element_name({'elements': self.elements})})"
        )


class Polyline(MeshBase):
    """Chain of points for rods: ``vertices`` (n, 3) float64 [m], each joined to the next."""

    def __init__(self, vertices: ArrayLike) -> None:
        self.__dict__["vertices"] = points_of(vertices, "Polyline: vertices")

    def _with(self, vertices: Points) -> Polyline:
        return Polyline(vertices)

    @property
    def edges(self) -> Indices:
        """Edges (n - 1, 2) as indices of ``vertices``."""
        first = np.arange(len(self.vertices) - 1, dtype=np.int32)
        return np.column_stack([first, first + 1]).astype(np.int32)

    @property
    def length(self) -> float:
        """Sum of the lengths of all edges [m]."""
        return float(np.linalg.norm(np.diff(self.vertices, axis=0), axis=1).sum())

    def __repr__(self) -> str:
        return f"Polyline({len(self.vertices)} points, {self.length:g} m)"


Mesh: TypeAlias = TriangleMesh | TetMesh | SolidMesh


@overload
def compact(mesh: TriangleMesh) -> TriangleMesh: ...
@overload
def compact(mesh: TetMesh) -> TetMesh: ...
@overload
def compact(mesh: SolidMesh) -> SolidMesh: ...
def compact(mesh: Mesh) -> Mesh:
    """Copy without the vertices that no element uses."""
    name = next((n for n in ("tets", "elements", "triangles") if hasattr(mesh, n)), None)
    if isinstance(mesh, EmbeddedMesh):
        raise InvalidMesh("compact: got an EmbeddedMesh: must be compact already, as lattice() makes them")
    if not isinstance(mesh, MeshBase) or name is None:
        raise InvalidMesh(f"compact: got {type(mesh).__name__}: must be a TriangleMesh, TetMesh or SolidMesh")
    elements = getattr(mesh, name)
    corners_of(mesh.vertices, elements, f"compact: {name}")
    used, renumbered = np.unique(elements, return_inverse=True)
    kind = type(mesh)
    return kind(mesh.vertices[used], renumbered.reshape(elements.shape).astype(np.int32))
