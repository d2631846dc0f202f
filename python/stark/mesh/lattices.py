"""Surfaces in lattices of hexahedra: coarse elasticity, fine contact."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stark import _core
from stark._core import InvalidArgument, InvalidMesh
from stark.arguments import given_flag, shown_value
from stark.caller import warn
from stark.mesh.arguments import Indices, Points, corners_of, count_of, positive
from stark.mesh.conversion import as_triangle_mesh
from stark.mesh.report import MeshReport
from stark.mesh.types import EmbeddedMesh, TriangleMesh, compact

#: Most triangles that splitting long edges may make.
_MOST_TRIANGLES = 2_000_000

#: Mean thickness in cells below which slender bodies bend much too stiffly, by order.
_THINNEST = {1: 0.4, 2: 0.125}

#: Longest side over the mean thickness of slender bodies: of a cube 3.
_SLENDER = 10.0


def lattice(
    surface: Any,
    *,
    cells: int | None = None,
    cell_size: float | None = None,
    order: int = 1,
    split: bool = True,
    report: MeshReport | None = None,
) -> EmbeddedMesh:
    """A surface (TriangleMesh, pair of arrays, mesh of trimesh) in a lattice of cubes, for ``add_solid``:
    elasticity and inertia are those of the cubes, as far as the surface encloses them, and contact is that
    of the surface, whose vertices follow the cubes (docs/meshes.md).

    ``cells`` along the longest side of its bounds, or ``cell_size`` [m]. ``order`` 1: trilinear cells of 8
    nodes, 2: triquadratic ones of 27. With ``split`` edges of the surface that are longer than the distance
    of nodes are split, so that it can bend as the cells do; contact acts at its vertices, so finer is better.
    Inside is where the winding number is above one half: the surface may have holes and overlap itself, but
    where it is to collide it must not cross itself at the start. The volume of a closed surface without
    overlaps is met exactly, that of others by samples. Pieces that share a cell are joined by it. What was
    made is added to ``report``.

    Raises InvalidArgument for values out of range and more than two million cells, InvalidMesh for vertices
    that are not finite and surfaces that enclose nothing, or next to nothing of any cell."""
    given = as_triangle_mesh(surface, "lattice")
    corners_of(given.vertices, given.triangles, "lattice: triangles")
    if not np.isfinite(given.vertices).all():
        raise InvalidMesh("lattice: a vertex is not finite: all must be [m]; leave out what is not")
    if len(given.triangles) == 0:
        raise InvalidMesh("lattice: the surface has 0 triangles: must have some; check the file")
    is_number = isinstance(order, (int, float, np.number)) and not isinstance(order, bool)
    if not is_number or order not in (1, 2):
        raise InvalidArgument(f"lattice: order = {order!r}: must be 1 (trilinear) or 2 (triquadratic)")
    order = int(order)
    if report is not None and not isinstance(report, MeshReport):
        raise InvalidArgument(f"lattice: report = {shown_value(report)}: must be a stark.mesh.MeshReport")
    given, size = compact(given), _size(given, cells, cell_size)
    if given_flag(split, "lattice: split"):
        given = _split(given, size / order)
    (vertices, elements), of_vertices, triangles, filling = _core.make_lattice(
        given.vertices, given.triangles, size, order == 2
    )
    mesh = EmbeddedMesh(vertices, elements, triangles, of_vertices, filling)
    _warn_of_thin(mesh, given, size, _THINNEST[order])
    if report is not None:
        _tell(mesh, given, size, report)
    return mesh


def _warn_of_thin(mesh: EmbeddedMesh, surface: TriangleMesh, size: float, thinnest: float) -> None:
    thickness = 2.0 * mesh.volume / surface.area
    longest = float((surface.bounds[1] - surface.bounds[0]).max())
    if thickness < thinnest * size and longest > _SLENDER * thickness:
        warn(
            f"lattice: the surface is {thickness:.3g} m thick in the mean (twice its volume over its area), "
            f"{thickness / size:.2g} of a cell: must be {thinnest:g} at least, or it bends too stiffly; "
            f"use cells of {thickness / thinnest:.3g} m or less, or add_cloth for sheets"
        )


def _size(surface: TriangleMesh, cells: int | None, cell_size: float | None) -> float:
    if (cells is None) == (cell_size is None):
        raise InvalidArgument("lattice: give one of cells, along the longest side, and cell_size [m]")
    longest = float((surface.bounds[1] - surface.bounds[0]).max())
    if not longest > 0.0:
        raise InvalidMesh("lattice: the surface is a point: must enclose a volume")
    if cell_size is not None:
        size = positive(cell_size, "lattice: cell_size")
        if size > 2.0 * longest:
            raise InvalidArgument(
                f"lattice: cell_size = {size:g} m: must be at most twice the longest side of the surface, "
                f"which is {longest:.3g} m; its vertices must be metres, too"
            )
        return size
    assert cells is not None  # one of the two is given
    return longest / count_of(cells, "lattice: cells", 1)


def _split(surface: TriangleMesh, longest: float) -> TriangleMesh:
    """Splits edges that are longer than a length in their middle, triangles with them, until none is."""
    vertices, triangles = surface.vertices, surface.triangles
    while True:
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        lengths = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
        long = lengths > longest * (1.0 + 1e-9)
        if not long.any():
            return TriangleMesh(vertices, triangles)
        if len(triangles) > _MOST_TRIANGLES:
            raise InvalidArgument(
                f"lattice: edges of the surface are split to {longest:.3g} m into more than "
                f"{_MOST_TRIANGLES} triangles: must be fewer; use larger cells, or split=False"
            )
        vertices, triangles = _halved(vertices, triangles, edges, long)


def _halved(vertices: Points, triangles: Indices, edges: Indices, long: Any) -> tuple[Points, Indices]:
    """With a vertex in the middle of each edge that is long; edges (3 m, 2) by triangle."""
    keys = edges[:, 0].astype(np.int64) * len(vertices) + edges[:, 1]
    known, first, numbers = np.unique(keys[long], return_index=True, return_inverse=True)
    ends = edges[long][first]
    middles = np.full(len(keys), -1, dtype=np.int64)
    middles[long] = len(vertices) + numbers.ravel()
    made: list[Any] = []
    for corners, middle in zip(triangles.tolist(), middles.reshape(-1, 3).tolist(), strict=True):
        made += _parts(corners, middle)
    points = np.concatenate([vertices, 0.5 * (vertices[ends[:, 0]] + vertices[ends[:, 1]])])
    assert len(known) == len(ends)
    return points, np.array(made, dtype=np.int32)


def _parts(corners: list[int], middle: list[int]) -> list[list[int]]:
    """One triangle with vertices in the middle of some of its edges (01, 12, 20), -1 where there is none."""
    count = sum(m >= 0 for m in middle)
    if count == 0:
        return [corners]
    (a, b, c), (ab, bc, ca) = corners, middle
    if count == 3:
        return [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    while not (ab >= 0 and (count == 1 or bc >= 0)):  # turn it until the first, or the first two, are there
        (a, b, c), (ab, bc, ca) = (b, c, a), (bc, ca, ab)
    if count == 1:
        return [[a, ab, c], [ab, b, c]]
    return [[ab, b, bc], [a, ab, bc], [a, bc, c]]


def _tell(mesh: EmbeddedMesh, surface: TriangleMesh, size: float, report: MeshReport) -> None:
    cut = int((mesh.filling[:, 0] < 1.0).sum())
    thinnest = float((surface.bounds[1] - surface.bounds[0]).min()) / size
    report.add(
        "lattice",
        len(mesh.elements),
        f"{len(mesh.elements)} cells of {size:.3g} m, {cut} of them at the surface, {mesh.node_count} nodes, "
        f"{math.ceil(thinnest)} cells along the shortest side",
    )
    enclosed = surface.volume if surface.is_closed else math.nan
    exact = ", by samples"
    if abs(mesh.volume - enclosed) < 1e-6 * mesh.volume:
        exact = f" of {enclosed:.6g} m^3 inside of the surface"
    elif surface.is_closed:
        exact += f"; its triangles enclose {enclosed:.6g} m^3, what overlaps more than once"
    report.add("volume", len(mesh.elements), f"{mesh.volume:.6g} m^3{exact}")
    kind = "closed" if surface.is_closed else "open"
    report.add(
        "embedded",
        len(mesh.triangles),
        f"{len(mesh.cells)} vertices, {len(mesh.triangles)} triangles, {kind}",
    )
