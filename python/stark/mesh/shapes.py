"""Simple shapes: sheets, boxes, round bodies, chains."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stark import _core
from stark._core import InvalidArgument
from stark.mesh.arguments import (
    cells_of,
    count_of,
    counts_around,
    numbers_of,
    positive,
    require_few,
    sizes_of,
)
from stark.mesh.types import Polyline, SolidMesh, TetMesh, TriangleMesh
from stark.rotations import vector


def grid(width: float, depth: float, cells: int | tuple[int, int]) -> TriangleMesh:
    """Rectangle in the plane z = 0 about the origin: ``width`` along x, ``depth`` along y [m]. ``cells``:
    along both, or (nx, ny); two triangles a cell. The (nx + 1)(ny + 1) vertices come in rows along x, from
    the smallest y: the corners are 0, nx, ny (nx + 1) and the last. Raises InvalidArgument for numbers out
    of range."""
    nx, ny = cells_of(cells, 2, "grid: cells")
    return TriangleMesh(
        *_core.make_grid(positive(width, "grid: width"), positive(depth, "grid: depth"), nx, ny)
    )


def box(size: float | ArrayLike, subdivisions: int = 1) -> TriangleMesh:
    """Closed box about the origin; ``size`` is one edge length or three [m], ``subdivisions`` the squares
    along each edge of a face, of two triangles. Raises InvalidArgument for numbers out of range."""
    count = count_of(subdivisions, "box: subdivisions")
    require_few(6 * count**2, f"box: subdivisions = {count}")
    return TriangleMesh(*_core.make_box(sizes_of(size, "box: size").tolist(), count))


def sphere(radius: float, subdivisions: int = 3) -> TriangleMesh:
    """Sphere of ``radius`` [m] about the origin: an icosahedron split ``subdivisions`` times, 20 * 4^n
    triangles with vertices on the sphere. Raises InvalidArgument for numbers out of range, and more than 8
    subdivisions."""
    count = count_of(subdivisions, "sphere: subdivisions", 0)
    if count > 8:
        raise InvalidArgument(
            f"sphere: subdivisions = {count}: must be at most 8, which is 1,310,720 triangles"
        )
    return TriangleMesh(*_core.make_icosphere(positive(radius, "sphere: radius"), count))


def cylinder(radius: float, height: float, segments: int = 32, stacks: int = 1) -> TriangleMesh:
    """Closed cylinder about the z axis with the origin in its middle: ``radius`` and ``height`` from cap to
    cap [m]; ``segments`` around the axis, ``stacks`` along it. Caps have no vertices inside. Raises
    InvalidArgument for numbers out of range."""
    return TriangleMesh(
        *_core.make_cylinder(
            positive(radius, "cylinder: radius"),
            positive(height, "cylinder: height"),
            *counts_around("cylinder", segments=(segments, 3), stacks=(stacks, 1)),
        )
    )


def capsule(radius: float, height: float, segments: int = 32, rings: int = 8) -> TriangleMesh:
    """Capsule about the z axis with the origin in its middle: ``radius`` [m], ``height`` between the centres
    of the half spheres [m]; ``segments`` around the axis, ``rings`` on each half sphere. Raises
    InvalidArgument for numbers out of range."""
    return TriangleMesh(
        *_core.make_capsule(
            positive(radius, "capsule: radius"),
            positive(height, "capsule: height"),
            *counts_around("capsule", segments=(segments, 3), rings=(rings, 1)),
        )
    )


def torus(
    major_radius: float, minor_radius: float, major_segments: int = 48, minor_segments: int = 24
) -> TriangleMesh:
    """Torus about the z axis and the origin: a tube of ``minor_radius`` [m] around a circle of
    ``major_radius`` [m]; ``major_segments`` along the circle, ``minor_segments`` around the tube. Raises
    InvalidArgument for numbers out of range and tubes that reach the axis."""
    if positive(minor_radius, "torus: minor_radius") >= positive(major_radius, "torus: major_radius"):
        raise InvalidArgument(
            f"torus: minor_radius = {minor_radius} m: must be below major_radius = {major_radius} m"
        )
    return TriangleMesh(
        *_core.make_torus(
            float(major_radius),
            float(minor_radius),
            *counts_around("torus", major_segments=(major_segments, 3), minor_segments=(minor_segments, 3)),
        )
    )


def polyline(start: ArrayLike, end: ArrayLike, segments: int) -> Polyline:
    """Straight chain of ``segments`` equal edges from ``start`` to ``end``, (3,) [m] each. Raises
    InvalidArgument for numbers out of range."""
    a, b = vector(start, "polyline: start"), vector(end, "polyline: end")
    t = np.linspace(0.0, 1.0, count_of(segments, "polyline: segments") + 1)[:, None]
    return Polyline(a + t * (b - a))


def helix(radius: float, pitch: float, turns: float, segments: int) -> Polyline:
    """Helix of ``radius`` [m] about z that starts at (radius, 0, 0) and rises by ``pitch`` [m] a turn;
    ``segments`` edges in all ``turns``. Raises InvalidArgument for numbers out of range."""
    r, rise = positive(radius, "helix: radius"), numbers_of(pitch)
    if rise.shape != () or not np.isfinite(rise):
        raise InvalidArgument(f"helix: pitch = {pitch!r} m: must be a finite number")
    angle = np.linspace(
        0.0, 2.0 * np.pi * positive(turns, "helix: turns", ""), count_of(segments, "helix: segments") + 1
    )
    return Polyline(np.column_stack([r * np.cos(angle), r * np.sin(angle), rise * angle / (2.0 * np.pi)]))


def tet_box(size: float | ArrayLike, cells: int | tuple[int, int, int]) -> TetMesh:
    """Solid box about the origin: ``size`` is one edge length or three [m], ``cells`` one number for all
    directions or (nx, ny, nz); each cell has a node at its centre and twelve tetrahedra. Raises
    InvalidArgument for numbers out of range."""
    return TetMesh(
        *_core.make_tet_box(sizes_of(size, "tet_box: size").tolist(), cells_of(cells, 3, "tet_box: cells"))
    )


def tet_ball(radius: float, subdivisions: int = 2, shells: ArrayLike = (0.4, 0.7, 1.0)) -> TetMesh:
    """Solid ball about the origin: the triangles of ``sphere`` on shells, prisms of three tetrahedra between
    them, a core of one tetrahedron each. ``shells``: their radii over that of the ball, growing, the last 1.

    Raises InvalidArgument for other shells and numbers out of range."""
    shares = numbers_of(shells)
    if (
        shares.ndim != 1
        or not len(shares)
        or not np.all(np.diff(shares, prepend=0.0) > 0.0)
        or shares[-1] != 1.0
    ):
        raise InvalidArgument(f"tet_ball: shells = {shells!r}: must grow from above 0 to 1, as (0.5, 1.0)")
    edge = positive(radius, "tet_ball: radius")
    surface = sphere(1.0, count_of(subdivisions, "tet_ball: subdivisions", 0))
    count = len(surface.vertices)
    vertices = np.concatenate([np.zeros((1, 3)), *(edge * share * surface.vertices for share in shares)])
    a, b, c = np.sort(surface.triangles, axis=1).T + 1  # neighbours then cut their common side alike
    tets = [np.stack([np.zeros_like(a), a, b, c], axis=1)]
    for _ in shares[1:]:
        outer = [side + count for side in (a, b, c)]
        tets += [np.stack(rows, axis=1) for rows in ((a, b, c, outer[2]), (a, b, *outer[1:]), (a, *outer))]
        a, b, c = outer
    elements = np.concatenate(tets).astype(np.int32)
    x = vertices[elements]
    inverted = np.einsum("ni,ni->n", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), x[:, 3] - x[:, 0]) < 0.0
    elements[inverted] = elements[inverted][:, [0, 2, 1, 3]]
    return TetMesh(vertices, elements)


def box_hexahedra(size: float | ArrayLike, cells: int | tuple[int, int, int]) -> SolidMesh:
    """Solid box of hexahedra with 8 nodes about the origin: ``size`` is one edge length or three [m],
    ``cells`` one number for all directions or (nx, ny, nz). Raises InvalidArgument for numbers out of
    range."""
    return SolidMesh(
        *_core.make_hex_box(
            sizes_of(size, "box_hexahedra: size").tolist(), cells_of(cells, 3, "box_hexahedra: cells")
        )
    )
