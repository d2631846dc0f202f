"""Meshes: triangle surfaces and tetrahedral volumes as NumPy arrays, generators, files.

Lengths in metres. Triangles are counter-clockwise seen from outside, tetrahedra have positive volume;
``oriented`` repairs both."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark import _core
from stark._core import InvalidArgument, InvalidMesh
from stark.arguments import given_path
from stark.rotations import as_matrix, vector

Points: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int32]
_Mesh = TypeVar("_Mesh", bound="_MeshBase")


def _points(values: ArrayLike, name: str) -> Points:
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "iuf":
            raise TypeError
        array = np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidMesh(
            f"{name}: got {type(values).__name__}, need an array of shape (n, 3) of real numbers [m]"
        ) from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidMesh(
            f"{name}: got the shape {array.shape}, need (n, 3): one row of x, y, z [m] for each vertex"
        )
    return array


def _indices(values: ArrayLike, columns: int, name: str) -> Indices:
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        array = np.empty((), dtype=object)
    if array.size == 0:
        return np.empty((0, columns), dtype=np.int32)
    if array.ndim != 2 or array.shape[1] != columns:
        raise InvalidMesh(
            f"{name}: got the shape {array.shape}, need (m, {columns}): one row of vertex indices each"
        )
    if array.dtype.kind not in "iu":
        raise InvalidMesh(
            f"{name}: got numbers of type {array.dtype}, need integers; convert with .astype(numpy.int32)"
        )
    if array.max() > 2**31 - 1 or array.min() < -(2**31):
        raise InvalidMesh(
            f"{name}: got the index {array.max()}, need indices that fit 32 bits; check the numbering"
        )
    return np.ascontiguousarray(array, dtype=np.int32)


def _corners(vertices: Points, elements: Indices, name: str) -> list[Points]:
    """Positions of the first, second, ... vertex of all elements."""
    if elements.size and not (elements.min() >= 0 and elements.max() < len(vertices)):
        wrong = elements[(elements < 0) | (elements >= len(vertices))]
        raise InvalidMesh(
            f"{name}: one of them refers to vertex {wrong[0]}, need indices in [0, {len(vertices)}), which "
            f"start at 0"
        )
    return [vertices[column] for column in elements.T]


def _numbers(value: Any) -> NDArray[np.float64]:
    """As an array of real numbers, an empty one if it is none."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        return np.empty(0)
    return array.astype(np.float64) if array.dtype.kind in "iuf" else np.empty(0)


class _MeshBase:
    vertices: Points

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is immutable: make a new one instead of setting {name}")

    def _with(self: _Mesh, vertices: Points) -> _Mesh:
        raise NotImplementedError

    @property
    def bounds(self) -> Points:
        """Lowest and highest corner, shape (2, 3) [m]."""
        if len(self.vertices) == 0:
            raise InvalidMesh(f"{type(self).__name__}: 0 vertices: must have at least one to have bounds")
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def scaled(self: _Mesh, factor: float | ArrayLike) -> _Mesh:
        """Copy with all coordinates times a factor, or times one for each axis: ``scaled(1e-3)`` for
        millimetres."""
        factors = _numbers(factor)
        if factors.shape not in ((), (3,)) or not (np.isfinite(factors) & (factors > 0)).all():
            raise InvalidArgument(f"scaled: factor = {factor!r}: must be one positive number or three")
        return self._with(self.vertices * factors)

    def translated(self: _Mesh, offset: ArrayLike) -> _Mesh:
        """Copy moved by an offset [m]."""
        return self._with(self.vertices + vector(offset, "translated: offset"))

    def rotated(self: _Mesh, rotation: ArrayLike) -> _Mesh:
        """Copy turned about the origin by a matrix or quaternion, as ``stark.rotation`` makes them."""
        return self._with(self.vertices @ as_matrix(rotation, "rotated: rotation").T)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the arrays, with all digits, as a NumPy file that ``stark.mesh.load`` reads:
        ``mesh.save("cup.npz")``."""
        from stark.array_file import write_atomically

        file = given_path(path, "save: path")
        if file.suffix != ".npz":
            raise InvalidArgument(f"save: path = '{path}': must end in .npz")
        write_atomically(file, lambda stream: np.savez_compressed(stream, **self.__dict__))

    def centered(self: _Mesh) -> _Mesh:
        """Copy with the middle of its bounds at the origin."""
        return self._with(self.vertices - self.bounds.mean(axis=0))


class TriangleMesh(_MeshBase):
    """Surface: ``vertices`` (n, 3) float64 [m], ``triangles`` (m, 3) int32."""

    triangles: Indices

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        self.__dict__["vertices"] = _points(vertices, "TriangleMesh: vertices")
        self.__dict__["triangles"] = _indices(triangles, 3, "TriangleMesh: triangles")

    def _with(self, vertices: Points) -> TriangleMesh:
        return TriangleMesh(vertices, self.triangles)

    @property
    def is_closed(self) -> bool:
        """Whether every edge belongs to exactly two triangles."""
        return bool((_edge_counts(self.triangles) == 2).all())

    @property
    def volume(self) -> float:
        """Signed volume [m^3], positive when the triangles are oriented outwards; only of closed meshes."""
        a, b, c = _corners(self.vertices, self.triangles, "TriangleMesh: triangles")
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    @property
    def area(self) -> float:
        a, b, c = _corners(self.vertices, self.triangles, "TriangleMesh: triangles")
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def flipped(self) -> TriangleMesh:
        """Copy with all triangles turned over."""
        return TriangleMesh(self.vertices, self.triangles[:, ::-1])

    def __repr__(self) -> str:
        return f"TriangleMesh({len(self.vertices)} vertices, {len(self.triangles)} triangles)"


class TetMesh(_MeshBase):
    """Volume: ``vertices`` (n, 3) float64 [m], ``tets`` (m, 4) int32."""

    tets: Indices

    def __init__(self, vertices: ArrayLike, tets: ArrayLike) -> None:
        self.__dict__["vertices"] = _points(vertices, "TetMesh: vertices")
        self.__dict__["tets"] = _indices(tets, 4, "TetMesh: tets")

    def _with(self, vertices: Points) -> TetMesh:
        return TetMesh(vertices, self.tets)

    @property
    def volumes(self) -> NDArray[np.float64]:
        """Signed volume of each tetrahedron [m^3], shape (m,)."""
        a, b, c, d = _corners(self.vertices, self.tets, "TetMesh: tets")
        return np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6.0

    @property
    def volume(self) -> float:
        return float(self.volumes.sum())

    def surface_triangles(self) -> Indices:
        """Boundary triangles (k, 3), outwards, as indices of ``vertices``."""
        faces = self.tets[:, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]].reshape(-1, 3)
        _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        return faces[np.sort(first[counts == 1])]

    def surface(self) -> TriangleMesh:
        """The boundary as a mesh of its own, without the inner vertices."""
        return compact(TriangleMesh(self.vertices, self.surface_triangles()))

    def __repr__(self) -> str:
        return f"TetMesh({len(self.vertices)} vertices, {len(self.tets)} tets)"


class SolidMesh(_MeshBase):
    """Volume of elements with 10 (quadratic tetrahedra), 8 or 27 nodes (trilinear and triquadratic
    hexahedra): ``vertices`` (n, 3) float64 [m], ``elements`` (m, 10 | 8 | 27) int32, nodes in the order of
    VTK. Four columns make linear tetrahedra, as a TetMesh does."""

    elements: Indices

    def __init__(self, vertices: ArrayLike, elements: ArrayLike) -> None:
        columns = np.shape(elements)[1] if np.ndim(elements) == 2 else 0
        if columns not in (4, 8, 10, 27):
            raise InvalidMesh(
                f"SolidMesh: elements: got the shape {np.shape(elements)}, need (m, k) with 4, 8, 10 or 27 "
                f"vertex indices each"
            )
        self.__dict__["vertices"] = _points(vertices, "SolidMesh: vertices")
        self.__dict__["elements"] = _indices(elements, columns, "SolidMesh: elements")

    def _with(self, vertices: Points) -> SolidMesh:
        return SolidMesh(vertices, self.elements)

    @property
    def volumes(self) -> NDArray[np.float64]:
        """Volume of each element [m^3], shape (m,)."""
        return _core.element_volumes(self.vertices, self.elements)

    @property
    def volume(self) -> float:
        return float(self.volumes.sum())

    def surface_triangles(self) -> Indices:
        """Boundary triangles (k, 3), outwards, as indices of ``vertices``: faces of quadratic elements are
        cut into four or eight."""
        return _core.solid_boundary_triangles(self.elements)

    def surface(self) -> TriangleMesh:
        """The boundary as a mesh of its own, without the inner vertices."""
        return compact(TriangleMesh(self.vertices, self.surface_triangles()))

    def __repr__(self) -> str:
        kind = _core.element_name(self.elements)
        return f"SolidMesh({len(self.vertices)} vertices, {len(self.elements)} elements: {kind})"


class Polyline(_MeshBase):
    """Chain of points for rods: ``vertices`` (n, 3) float64 [m], each joined to the next."""

    def __init__(self, vertices: ArrayLike) -> None:
        self.__dict__["vertices"] = _points(vertices, "Polyline: vertices")

    def _with(self, vertices: Points) -> Polyline:
        return Polyline(vertices)

    @property
    def edges(self) -> Indices:
        """Edges (n - 1, 2) as indices of ``vertices``."""
        first = np.arange(len(self.vertices) - 1, dtype=np.int32)
        return np.column_stack([first, first + 1]).astype(np.int32)

    @property
    def length(self) -> float:
        """[m]"""
        return float(np.linalg.norm(np.diff(self.vertices, axis=0), axis=1).sum())

    def __repr__(self) -> str:
        return f"Polyline({len(self.vertices)} points, {self.length:g} m)"


Mesh: TypeAlias = TriangleMesh | TetMesh | SolidMesh


# --- Conversions and repairs --------------------------------------------------------------------------------


def as_triangle_mesh(mesh: Any, name: str) -> TriangleMesh:
    """A TriangleMesh, a ``(vertices, triangles)`` pair or anything with ``vertices`` and ``faces``
    (trimesh)."""
    if isinstance(mesh, TriangleMesh):
        return mesh
    if isinstance(mesh, TetMesh):
        raise InvalidMesh(f"{name}: got a TetMesh, need a TriangleMesh; use add_solid, or mesh.surface()")
    # trimesh has the corners of its triangles as `triangles`, and their indices as `faces`.
    for attribute in ("faces", "triangles"):
        if hasattr(mesh, "vertices") and hasattr(mesh, attribute):
            return _named(name, TriangleMesh, mesh.vertices, getattr(mesh, attribute))
    if isinstance(mesh, Sequence) and not isinstance(mesh, str) and len(mesh) == 2:
        return _named(name, TriangleMesh, mesh[0], mesh[1])
    raise InvalidMesh(
        f"{name}: got {type(mesh).__name__}, need a stark.TriangleMesh or a (vertices, triangles) pair; "
        f"files are read by stark.mesh.load(path)"
    )


def as_tet_mesh(mesh: Any, name: str) -> TetMesh:
    """A TetMesh, a ``(vertices, tets)`` pair or anything with ``vertices`` and ``tets``."""
    if isinstance(mesh, TetMesh):
        return mesh
    if isinstance(mesh, TriangleMesh):
        raise InvalidMesh(
            f"{name}: got a TriangleMesh, need a TetMesh; use stark.mesh.tetrahedralise(mesh) or add_cloth"
        )
    if hasattr(mesh, "vertices") and hasattr(mesh, "tets"):
        return _named(name, TetMesh, mesh.vertices, mesh.tets)
    if isinstance(mesh, Sequence) and not isinstance(mesh, str) and len(mesh) == 2:
        return _named(name, TetMesh, mesh[0], mesh[1])
    raise InvalidMesh(f"{name}: got {type(mesh).__name__}, need a stark.TetMesh or a (vertices, tets) pair")


def as_solid_mesh(mesh: Any, name: str) -> TetMesh | SolidMesh:
    """A SolidMesh, whatever ``as_tet_mesh`` takes, or a ``(vertices, elements)`` pair with 4, 8, 10 or 27
    nodes an element."""
    if isinstance(mesh, SolidMesh):
        return mesh
    is_pair = isinstance(mesh, Sequence) and not isinstance(mesh, str) and len(mesh) == 2
    if is_pair and np.ndim(mesh[1]) == 2 and np.shape(mesh[1])[1] in (8, 10, 27):
        return _named(name, SolidMesh, mesh[0], mesh[1])
    return as_tet_mesh(mesh, name)


def as_polyline(mesh: Any, name: str) -> Polyline:
    """A Polyline, or an array of points (n, 3)."""
    if isinstance(mesh, Polyline):
        return mesh
    if isinstance(mesh, (TriangleMesh, TetMesh, SolidMesh)):
        raise InvalidMesh(
            f"{name}: got a {type(mesh).__name__}, need a stark.mesh.Polyline or points (n, 3); use "
            f"stark.mesh.polyline(start, end, segments)"
        )
    try:
        return Polyline(mesh)
    except InvalidMesh as error:
        raise InvalidMesh(f"{name}: {error}") from None


def _named(name: str, kind: type[Any], vertices: ArrayLike, elements: ArrayLike) -> Any:
    try:
        return kind(vertices, elements)
    except InvalidMesh as error:
        raise InvalidMesh(f"{name}: {error}") from None


def _edge_counts(triangles: Indices) -> NDArray[np.int64]:
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


def compact(mesh: Any) -> Any:
    """Copy without the vertices that no element uses."""
    name = next((n for n in ("tets", "elements", "triangles") if hasattr(mesh, n)), None)
    if not isinstance(mesh, _MeshBase) or name is None:
        raise InvalidMesh(f"compact: got {type(mesh).__name__}, need a TriangleMesh, TetMesh or SolidMesh")
    elements = getattr(mesh, name)
    _corners(mesh.vertices, elements, f"compact: {name}")
    used, renumbered = np.unique(elements, return_inverse=True)
    return type(mesh)(mesh.vertices[used], renumbered.reshape(elements.shape).astype(np.int32))


def merged(mesh: TriangleMesh, tolerance: float = 0.0) -> TriangleMesh:
    """Copy in which vertices at the same place (within ``tolerance`` [m] on a grid) are one; collapsed
    triangles go."""
    if not isinstance(mesh, TriangleMesh):
        raise InvalidMesh(f"merged: got {type(mesh).__name__}, need a TriangleMesh")
    grid = _numbers(tolerance)
    if grid.shape != () or not 0.0 <= grid < np.inf:
        raise InvalidArgument(f"merged: tolerance = {tolerance!r} m: must be a number >= 0")
    _corners(mesh.vertices, mesh.triangles, "merged: triangles")
    keys = mesh.vertices if grid == 0.0 else np.round(mesh.vertices / grid)
    _, first, renumbered = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # keeps the order of the file
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    triangles = rank[renumbered.reshape(-1)][mesh.triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    return compact(TriangleMesh(mesh.vertices[first[order]], triangles.astype(np.int32)))


def oriented(mesh: Any) -> Any:
    """Copy with tetrahedra of positive volume; or with triangles that agree with their neighbours and, where
    they enclose a volume, face outwards."""
    if isinstance(mesh, TetMesh):
        tets = mesh.tets.copy()
        negative = mesh.volumes < 0.0
        tets[negative] = tets[negative][:, [0, 1, 3, 2]]
        return TetMesh(mesh.vertices, tets)
    if not isinstance(mesh, TriangleMesh):
        raise InvalidMesh(f"oriented: got {type(mesh).__name__}, need a TriangleMesh or a TetMesh")
    _corners(mesh.vertices, mesh.triangles, "oriented: triangles")
    return _oriented_triangles(mesh)


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


# --- Generators ---------------------------------------------------------------------------------------------


def _sizes(size: float | ArrayLike, name: str) -> NDArray[np.float64]:
    values = _numbers(size)
    if values.shape == ():
        values = np.full(3, float(values))
    if values.shape != (3,) or not (np.isfinite(values) & (values > 0.0)).all():
        raise InvalidArgument(f"{name} = {size!r} m: must be one positive number or three")
    return values


def positive(value: float, name: str) -> float:
    """A length [m], or InvalidArgument."""
    number = _numbers(value)
    if number.shape != () or not 0.0 < number < np.inf:
        raise InvalidArgument(f"{name} = {value!r} m: must be a number > 0")
    return float(value)


def _count(value: int, name: str, least: int = 1) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value <= 100_000:
        raise InvalidArgument(f"{name} = {value!r}: must be a whole number in [{least}, 100000]")
    return int(value)


def _cells(cells: Any, dimensions: int, name: str) -> list[int]:
    """Cells along each axis, as many as indices of 32 bits can tell apart."""
    counts = [cells] * dimensions if isinstance(cells, (int, np.integer)) else cells
    if not isinstance(counts, (list, tuple, np.ndarray)) or len(counts) != dimensions:
        raise InvalidArgument(f"{name} = {cells!r}: must be one whole number or {dimensions}")
    counts = [_count(count, name) for count in counts]
    _require_few(math.prod(count + 1 for count in counts), f"{name} = {cells!r}")
    return counts


def _require_few(vertex_count: int, what: str) -> None:
    if vertex_count > 2**28:
        raise InvalidArgument(f"{what}: makes {vertex_count} vertices: must be at most 2^28, choose fewer")


def _around(shape: str, **counts: tuple[int, int]) -> list[int]:
    """Two counts, given with the least that makes sense, whose product is the number of vertices."""
    checked = [_count(value, f"{shape}: {name}", least) for name, (value, least) in counts.items()]
    _require_few(math.prod(checked), f"{shape}: {' and '.join(counts)} = {checked}")
    return checked


def grid(width: float, depth: float, cells: int | tuple[int, int]) -> TriangleMesh:
    """Rectangle in the plane z = 0 about the origin: ``width`` along x, ``depth`` along y [m], two triangles
    a cell."""
    nx, ny = _cells(cells, 2, "grid: cells")
    return TriangleMesh(
        *_core.make_grid(positive(width, "grid: width"), positive(depth, "grid: depth"), nx, ny)
    )


def box(size: float | ArrayLike, subdivisions: int = 1) -> TriangleMesh:
    """Closed box about the origin; ``size`` is one edge length or three [m]."""
    count = _count(subdivisions, "box: subdivisions")
    _require_few(6 * count**2, f"box: subdivisions = {count}")
    return TriangleMesh(*_core.make_box(_sizes(size, "box: size"), count))


def sphere(radius: float, subdivisions: int = 3) -> TriangleMesh:
    """Icosphere about the origin: an icosahedron split ``subdivisions`` times."""
    count = _count(subdivisions, "sphere: subdivisions", 0)
    if count > 8:
        raise InvalidArgument(
            f"sphere: subdivisions = {count}: must be at most 8, which is 1,310,720 triangles"
        )
    return TriangleMesh(*_core.make_icosphere(positive(radius, "sphere: radius"), count))


def cylinder(radius: float, height: float, segments: int = 32, stacks: int = 1) -> TriangleMesh:
    """Closed cylinder about the z axis, ``height`` from cap to cap."""
    return TriangleMesh(
        *_core.make_cylinder(
            positive(radius, "cylinder: radius"),
            positive(height, "cylinder: height"),
            *_around("cylinder", segments=(segments, 3), stacks=(stacks, 1)),
        )
    )


def capsule(radius: float, height: float, segments: int = 32, rings: int = 8) -> TriangleMesh:
    """Capsule about the z axis; ``height`` between the centres of the half spheres."""
    return TriangleMesh(
        *_core.make_capsule(
            positive(radius, "capsule: radius"),
            positive(height, "capsule: height"),
            *_around("capsule", segments=(segments, 3), rings=(rings, 1)),
        )
    )


def torus(
    major_radius: float, minor_radius: float, major_segments: int = 48, minor_segments: int = 24
) -> TriangleMesh:
    """Torus about the z axis: a tube of ``minor_radius`` around a circle of ``major_radius``."""
    if positive(minor_radius, "torus: minor_radius") >= positive(major_radius, "torus: major_radius"):
        raise InvalidArgument(
            f"torus: minor_radius = {minor_radius} m: must be below major_radius = {major_radius} m"
        )
    return TriangleMesh(
        *_core.make_torus(
            float(major_radius),
            float(minor_radius),
            *_around("torus", major_segments=(major_segments, 3), minor_segments=(minor_segments, 3)),
        )
    )


def polyline(start: ArrayLike, end: ArrayLike, segments: int) -> Polyline:
    """Straight chain from ``start`` to ``end`` [m] with equal edges."""
    a, b = vector(start, "polyline: start"), vector(end, "polyline: end")
    t = np.linspace(0.0, 1.0, _count(segments, "polyline: segments") + 1)[:, None]
    return Polyline(a + t * (b - a))


def helix(radius: float, pitch: float, turns: float, segments: int) -> Polyline:
    """Helix about z that starts at (radius, 0, 0) and rises by ``pitch`` [m] a turn; ``segments`` in all."""
    r, rise = positive(radius, "helix: radius"), _numbers(pitch)
    if rise.shape != () or not np.isfinite(rise):
        raise InvalidArgument(f"helix: pitch = {pitch!r} m: must be a finite number")
    angle = np.linspace(
        0.0, 2.0 * np.pi * positive(turns, "helix: turns"), _count(segments, "helix: segments") + 1
    )
    return Polyline(np.column_stack([r * np.cos(angle), r * np.sin(angle), rise * angle / (2.0 * np.pi)]))


def tet_box(size: float | ArrayLike, cells: int | tuple[int, int, int]) -> TetMesh:
    """Solid box about the origin: cuboid cells with a node at each centre, twelve tetrahedra a cell."""
    return TetMesh(*_core.make_tet_box(_sizes(size, "tet_box: size"), _cells(cells, 3, "tet_box: cells")))


def box_hexahedra(size: float | ArrayLike, cells: int | tuple[int, int, int]) -> SolidMesh:
    """Solid box about the origin of cuboid elements with 8 nodes."""
    return SolidMesh(
        *_core.make_hex_box(_sizes(size, "box_hexahedra: size"), _cells(cells, 3, "box_hexahedra: cells"))
    )


def to_quadratic(mesh: Any) -> SolidMesh:
    """Same elements with nodes between the corners: 10-node tetrahedra of a TetMesh, 27-node hexahedra of
    hexahedra. Nodes of a curved boundary may be moved onto it afterwards, ``SolidMesh(vertices,
    mesh.elements)``."""
    solid = as_solid_mesh(mesh, "to_quadratic")
    elements = solid.tets if isinstance(solid, TetMesh) else solid.elements
    return SolidMesh(*_core.to_quadratic(solid.vertices, elements))


# --- Files and volume meshing -------------------------------------------------------------------------------


def load(path: str | os.PathLike[str]) -> Mesh:
    """Reads a mesh file. OBJ, PLY and STL surfaces and saved meshes (NPZ) need nothing; MSH and VTK volumes
    need ``meshio``, all other formats ``trimesh`` (``pip install stark-sim[mesh]``). Coordinates are taken as
    metres: use ``.scaled`` if they are not."""
    from stark import mesh_files

    return mesh_files.load(path)


def tetrahedralise(mesh: Any, *, edge_length: float | None = None, tolerance: float = 1e-3) -> TetMesh:
    """Volume mesh of a closed surface, by fTetWild (``pip install stark-sim[mesh]``).

    ``edge_length`` [m]: wanted edge length, a twentieth of the diagonal of the bounds if left out.
    ``tolerance``: largest distance between the given surface and the result, over that diagonal. fTetWild is
    randomised: meshes of two calls differ a little; keep one with ``mesh.save("cup.npz")`` to repeat a
    simulation bit by bit."""
    from stark import mesh_files

    return mesh_files.tetrahedralise(as_triangle_mesh(mesh, "tetrahedralise"), edge_length, tolerance)
