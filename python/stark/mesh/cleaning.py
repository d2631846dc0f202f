"""Closed surfaces from dirty ones: scans with holes, double vertices, turned triangles and loose pieces."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark import _core
from stark._core import InvalidArgument, InvalidMesh
from stark.arguments import given_flag, is_iterable, real_number, shown_value
from stark.mesh.arguments import Indices, Points, corners_of
from stark.mesh.conversion import as_triangle_mesh
from stark.mesh.repair import equal_rows, merged, oriented
from stark.mesh.report import MeshReport
from stark.mesh.types import TriangleMesh, compact

Ints = NDArray[np.int64]


def joined(surfaces: Any) -> TriangleMesh:
    """Several surfaces as one mesh, in the given order. Where they overlap, a mass that is made of a density
    counts their volume twice. Raises InvalidMesh for anything but a list of surfaces."""
    if not is_iterable(surfaces):
        raise InvalidMesh(
            f"joined: got {type(surfaces).__name__}: must be a list of surfaces, joined([a, b])"
        )
    rows = [as_triangle_mesh(surface, f"joined: surface {k}") for k, surface in enumerate(surfaces)]
    if not rows:
        raise InvalidMesh("joined: got no surface: must have at least one")
    starts = np.cumsum([0, *(len(row.vertices) for row in rows)])
    return TriangleMesh(
        np.concatenate([row.vertices for row in rows]),
        np.concatenate([row.triangles + start for row, start in zip(rows, starts, strict=False)]),
    )


def cleaned(
    mesh: Any,
    *,
    tolerance: float = 1e-6,
    smallest_piece: float = 0.01,
    fill_holes: bool = True,
    report: MeshReport | None = None,
) -> TriangleMesh:
    """A surface (TriangleMesh, pair of arrays, mesh of trimesh) without what keeps it from being a body.

    Vertices closer than ``tolerance`` times the diagonal of the bounds become one; triangles that are double,
    without area or at an edge of three or more go; pieces with less than ``smallest_piece`` of the area of
    the largest one go; triangles are turned so that they agree and face outwards; each hole is filled by a
    fan about the middle of its border. What was done is added to ``report``.

    Raises InvalidArgument for values out of range, InvalidMesh if nothing is left, or with ``fill_holes`` if
    the surface does not close: it is one-sided, as a Moebius strip."""
    surface = as_triangle_mesh(mesh, "cleaned")
    corners_of(surface.vertices, surface.triangles, "cleaned: triangles")
    if not np.isfinite(surface.vertices).all():
        raise InvalidMesh("cleaned: a vertex is not finite: all must be [m]; leave out what is not")
    near, share = _share(tolerance, "tolerance"), _share(smallest_piece, "smallest_piece")
    if report is not None and not isinstance(report, MeshReport):
        raise InvalidArgument(f"cleaned: report = {shown_value(report)}: must be a stark.mesh.MeshReport")
    done = MeshReport() if report is None else report
    if len(surface.triangles) == 0:
        raise InvalidMesh("cleaned: the mesh has 0 triangles: must have at least one")
    grid = near * float(np.linalg.norm(surface.bounds[1] - surface.bounds[0]))
    surface = _merged(surface, grid, done)
    surface = _without_bad_triangles(surface, done)
    surface = _without_small_pieces(surface, share, done)
    surface = _turned(surface, done)
    if given_flag(fill_holes, "cleaned: fill_holes"):
        surface = _filled(surface, done)
        if not _core.is_closed(surface.triangles):
            raise InvalidMesh(
                f"cleaned: the surface is open at {len(_core.find_boundary_edges(surface.triangles))} edges "
                f"after its holes were filled: must be two-sided; cut it, or take fill_holes=False"
            )
    return surface


def _share(value: float, name: str) -> float:
    number = real_number(value, f"cleaned: {name}")
    if not 0.0 <= number < 1.0:
        raise InvalidArgument(f"cleaned: {name} = {value!r}: must be in [0, 1)")
    return number


def _merged(mesh: TriangleMesh, grid: float, report: MeshReport) -> TriangleMesh:
    found = merged(merged(mesh), grid)
    if len(found.triangles) == 0:
        raise InvalidMesh(
            f"cleaned: no triangle is larger than {grid:g} m: must be; give a smaller tolerance"
        )
    gone = len(mesh.vertices) - len(found.vertices)
    report.add("merged", gone, f"{gone} vertices within {grid:.2g} m of another one, or unused")
    return found


def _without_bad_triangles(mesh: TriangleMesh, report: MeshReport) -> TriangleMesh:
    first, _ = equal_rows(np.sort(mesh.triangles, axis=1))
    keep = np.zeros(len(mesh.triangles), dtype=bool)
    keep[first] = True
    report.add("double", int((~keep).sum()), f"{int((~keep).sum())} triangles that were there twice")
    edges, counts = _edges(mesh.triangles[keep])
    crowded = (counts[edges] > 2).any(axis=1)
    report.add("crowded", int(crowded.sum()), f"{int(crowded.sum())} triangles at edges of three or more")
    keep[np.flatnonzero(keep)[crowded]] = False
    if not keep.any():
        raise InvalidMesh("cleaned: each edge has three triangles or more: must have two; it is no surface")
    return compact(TriangleMesh(mesh.vertices, mesh.triangles[keep]))


def _edges(triangles: Indices) -> tuple[Ints, Ints]:
    """Edges of each triangle (m, 3), and the number of triangles of each edge."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).astype(np.int64)
    _, edges, counts = np.unique(
        pairs[:, 0] * (int(triangles.max()) + 1) + pairs[:, 1], return_inverse=True, return_counts=True
    )
    return edges.reshape(-1, 3), counts


def pieces(triangles: Indices) -> Ints:
    """Piece of each triangle (m,), from 0 in the order of triangles: those with a common edge are of one."""
    edges, counts = _edges(triangles)
    least_edge = connected(len(counts), edges)[edges[:, 0]]
    _, first, piece = np.unique(least_edge, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[piece.reshape(-1)].astype(np.int64)


def connected(count: int, elements: NDArray[np.integer]) -> Ints:
    """The least vertex of 0 to count - 1 that each one (count,) is connected with by ``elements`` (m, k)."""
    labels = np.arange(count)
    while True:  # each pass spreads the least label within elements, then to the root: few passes are needed
        found = labels.copy()
        np.minimum.at(found, elements.ravel(), np.repeat(labels[elements].min(axis=1), elements.shape[1]))
        np.minimum.at(found, labels, found.copy())
        found = found[found]
        if np.array_equal(found, labels):
            return labels
        labels = found


def _without_small_pieces(mesh: TriangleMesh, share: float, report: MeshReport) -> TriangleMesh:
    label = pieces(mesh.triangles)
    a, b, c = corners_of(mesh.vertices, mesh.triangles, "cleaned: triangles")
    areas = np.bincount(label, 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
    small = areas < share * areas.max()
    report.add(
        "pieces",
        int(small.sum()),
        f"{int(small.sum())} loose pieces of less than {share:g} of the largest, dropped",
    )
    return compact(TriangleMesh(mesh.vertices, mesh.triangles[~small[label]]))


def _turned(mesh: TriangleMesh, report: MeshReport) -> TriangleMesh:
    found: TriangleMesh = oriented(mesh)
    # Closed pieces face outwards already; pieces with holes by their volume about their middle.
    label, triangles = pieces(found.triangles), found.triangles.copy()
    order = np.argsort(label, kind="stable")
    for mine in np.split(order, np.cumsum(np.bincount(label))[:-1]):
        x = found.vertices[triangles[mine]] - found.vertices[np.unique(triangles[mine])].mean(axis=0)
        if np.einsum("ij,ij->", x[:, 0], np.cross(x[:, 1], x[:, 2])) < 0.0:
            triangles[mine] = triangles[mine][:, ::-1]
    turned = int((_parity(triangles) != _parity(mesh.triangles)).sum())
    report.add("turned", turned, f"{turned} triangles that faced inwards")
    return TriangleMesh(found.vertices, triangles)


def _parity(triangles: Indices) -> NDArray[np.bool_]:
    """Whether the corners of each triangle are an even permutation of their order."""
    a, b, c = triangles.T
    even: NDArray[np.bool_] = ((a < b).astype(int) + (b < c) + (c < a)) == 2
    return even


def _filled(mesh: TriangleMesh, report: MeshReport) -> TriangleMesh:
    loops = border_loops(mesh.triangles)
    vertices: list[Points] = [mesh.vertices]
    triangles: list[Indices] = [mesh.triangles]
    count, longest = len(mesh.vertices), 0.0
    for loop in loops:
        x = mesh.vertices[loop]
        longest = max(longest, float(np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1).sum()))
        if len(loop) == 3:
            triangles.append(np.array([loop[::-1]], dtype=np.int32))
            continue
        ends = np.roll(loop, -1)
        triangles.append(np.column_stack([ends, loop, np.full(len(loop), count)]).astype(np.int32))
        vertices.append(x.mean(axis=0)[None, :])
        count += 1
    report.add("filled", len(loops), f"{len(loops)} holes, the longest border {longest:.3g} m")
    return TriangleMesh(np.concatenate(vertices), np.concatenate(triangles))


def border_loops(triangles: Indices) -> list[Ints]:
    """Closed chains of vertices along the border, each in the direction of its triangles."""
    half = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64)
    size = int(triangles.max()) + 1
    forward, backward = half[:, 0] * size + half[:, 1], half[:, 1] * size + half[:, 0]
    border = half[~np.isin(forward, backward)]
    ahead: dict[int, list[int]] = {}
    for a, b in border.tolist():
        ahead.setdefault(a, []).append(b)
    loops = []
    for start in border[:, 0].tolist():
        while ahead.get(start):
            chain, place = [start], {start: 0}
            while ahead.get(chain[-1]):
                following = ahead[chain[-1]].pop()
                if (at := place.get(following)) is not None:  # a loop that pinches itself is several
                    loops.append(np.array(chain[at:]))
                    for gone in chain[at + 1 :]:
                        del place[gone]
                    del chain[at + 1 :]
                else:
                    place[following] = len(chain)
                    chain.append(following)
    return [loop for loop in loops if len(loop) > 2]
