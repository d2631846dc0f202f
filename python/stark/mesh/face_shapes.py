"""Faces of elements that have more than three nodes: which nodes, their shape functions, what each has of
the area. Surfaces cut such faces into triangles."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from stark.mesh.arguments import Indices
from stark.mesh.types import EmbeddedMesh, Mesh, Polyline, SolidMesh

Floats = NDArray[np.float64]

# By the number of triangles that find_boundary_triangles() cuts a face into: nodes of the face, each at a
# corner (row, column) of them.
_CORNERS = {
    2: ((0, 0), (0, 1), (0, 2), (1, 2)),
    4: ((0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)),
    8: ((0, 0), (2, 0), (4, 0), (6, 0), (0, 1), (2, 1), (4, 1), (6, 1), (0, 2)),
}
# The same nodes of a face that is seen from its other side.
_TURNED = {4: [0, 3, 2, 1], 6: [0, 2, 1, 5, 4, 3], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}
# Places of the nodes of quadrilaterals along both sides: at 0, at 1, in the middle.
_ALONG = ((0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (1, 2), (2, 1), (0, 2), (2, 2))
_TRIANGLES = {8: 2, 10: 4, 27: 8}  # of a face, by the nodes of the element


def cut_faces(mesh: Mesh | Polyline) -> int | None:
    """Into how many triangles the surface cuts each face of an element; None where it cuts none."""
    if not isinstance(mesh, SolidMesh) or isinstance(mesh, EmbeddedMesh):
        return None
    return _TRIANGLES.get(mesh.elements.shape[1])


def face_nodes(mesh: Mesh | Polyline, triangles: Indices) -> Indices | None:
    """Nodes (m, 4, 6 or 9) of the faces that the triangles are cut from, in the order of the shape functions
    and turned as the triangles are. None where triangles say it all: of faces of three nodes, lattices and
    cloth, and where they are not the whole of such faces."""
    cut = cut_faces(mesh)
    if cut is None or len(triangles) % cut:
        return None
    assert isinstance(mesh, SolidMesh)
    surface = mesh.surface_triangles()
    numbers = {tuple(row): k for k, row in enumerate(_from_smallest(surface).tolist())}
    numbers |= {(a, c, b): ~k for (a, b, c), k in numbers.items()}  # turned the other way round
    found = np.array([numbers.get(tuple(row), len(surface)) for row in _from_smallest(triangles).tolist()])
    chosen = np.unique(np.where(found < 0, ~found, found))
    faces = np.unique(chosen // cut)
    if chosen[-1] == len(surface) or len(chosen) != len(triangles) or len(faces) * cut != len(chosen):
        return None
    pieces = surface.reshape(-1, cut, 3)[faces]
    turned = np.isin(faces * cut, ~found[found < 0])
    nodes = _nodes_of(pieces)
    nodes[turned] = nodes[turned][:, _TURNED[nodes.shape[1]]]
    return nodes


def uncut_faces(mesh: Mesh | Polyline, surface: Indices) -> Indices | None:
    """Nodes (m, 4, 6 or 9) of all faces of the mesh's surface, given by its triangles and in their order;
    None where these are cut from nothing."""
    cut = cut_faces(mesh)
    return None if cut is None else _nodes_of(surface.reshape(-1, cut, 3))


@cache
def face_shares(count: int) -> Floats:
    """Part of the area of a face that each of its nodes has, the integral of its shape function (count,): a
    quarter of a face of four; nothing at the corners of a face of six."""
    at, weights = face_quadrature(count == 6)
    shares = weights @ np.stack([shape_functions(count, u, v)[0] for u, v in at])
    return np.asarray(np.round(shares / shares.sum(), 14))


def face_quadrature(triangle: bool) -> tuple[Floats, Floats]:
    """Points (n, 2) and weights (n,) of the unit triangle or square, exact for a biquadratic face."""
    x, w = np.polynomial.legendre.leggauss(4)
    x, w = (x + 1.0) / 2.0, w / 2.0
    u, v = (a.ravel() for a in np.meshgrid(x, x, indexing="ij"))
    weights = np.outer(w, w).ravel()
    if triangle:
        weights, v = weights * (1.0 - u), v * (1.0 - u)
    return np.stack([u, v], axis=1), weights


def shape_functions(count: int, u: float, v: float) -> Floats:
    """Shape functions of a face and their derivatives by u and v (3, count)."""
    if count == 6:
        corner = np.array([[1.0 - u - v, u, v], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
        a, b = corner, corner[:, [1, 2, 0]]
        at_corners = np.stack([a[0] * (2.0 * a[0] - 1.0), *(a[i] * (4.0 * a[0] - 1.0) for i in (1, 2))])
        between = np.stack([4.0 * a[0] * b[0], *(4.0 * (a[i] * b[0] + a[0] * b[i]) for i in (1, 2))])
        return np.concatenate([at_corners, between], axis=1)
    p, q = (_line(t, 2 if count == 4 else 3) for t in (u, v))
    nodes = _ALONG[:count]
    return np.stack([[p[0, i] * q[0, j], p[1, i] * q[0, j], p[0, i] * q[1, j]] for i, j in nodes], axis=1)


def node_places(count: int) -> Floats:
    """Of the nodes of a face of 4 or 9 on the unit square (count, 2)."""
    return np.asarray(np.array([0.0, 1.0, 0.5])[np.array(_ALONG[:count])])


def _line(t: float, count: int) -> Floats:
    """Functions of the ends, and the middle, of a line and their derivatives (2, count)."""
    if count == 2:
        return np.array([[1.0 - t, t], [-1.0, 1.0]])
    return np.array(
        [
            [(1.0 - t) * (1.0 - 2.0 * t), t * (2.0 * t - 1.0), 4.0 * t * (1.0 - t)],
            [4.0 * t - 3.0, 4.0 * t - 1.0, 4.0 - 8.0 * t],
        ]
    )


def _from_smallest(triangles: Indices) -> Indices:
    """Corners in the same cyclic order, from the smallest on."""
    first = np.argmin(triangles, axis=1)[:, None]
    return np.take_along_axis(triangles, (first + np.arange(3)) % 3, axis=1)


def _nodes_of(pieces: Indices) -> Indices:
    """Nodes (m, 4, 6 or 9) of faces that are cut into these triangles (m, n, 3)."""
    return np.stack([pieces[:, i, j] for i, j in _CORNERS[pieces.shape[1]]], axis=1)
