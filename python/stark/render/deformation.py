"""Deformation gradients of bodies, and means at vertices of what is known at elements."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stark.body_kinds import row_of

from .. import mesh as meshes

_STEP = 1e-5  #: of a deformation gradient, in slopes


class Deformation(NamedTuple):
    """Of m elements at k places each, next to k of their vertices; k = 1: constant."""

    gradients: np.ndarray  #: (m, k, 3, d), d = 3 of solids, 2 of cloth in the axes of each triangle
    elements: np.ndarray  #: (m, n) vertices
    sizes: np.ndarray  #: (m,) volumes at rest [m^3], of cloth areas [m^2]


def of_body(body: Any, first: np.ndarray | None = None) -> Deformation:
    """Of the elements of a body; ``first``: see of_cloth()."""
    return of_cloth(body, first) if row_of(body).is_sheet else of_solid(body)


def of_solid(body: Any) -> Deformation:
    """Of tetrahedra; of elements of higher order at each of their nodes."""
    mesh = body.mesh
    elements = mesh.tets if hasattr(mesh, "tets") else mesh.elements
    X, x = mesh.vertices[elements], body.positions[elements]
    slopes = shape_slopes(elements.shape[1])  # (k, n, 3)
    at_rest = np.einsum("mna,knb->mkab", X, slopes)
    now = np.einsum("mna,knb->mkab", x, slopes)
    return Deformation(now @ np.linalg.inv(at_rest), elements, np.abs(mesh.volumes))


def of_cloth(body: Any, first: np.ndarray | None = None) -> Deformation:
    """Of triangles, whose first axis is their first edge, or the part of ``first`` (3,) or (m, 3) in their
    planes at rest."""
    inverses, areas = _at_rest(body) if first is None else _sheet_at_rest(body, first)
    triangles = body.triangles
    x = body.positions[triangles]
    now = np.stack([x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]], axis=-1)
    return Deformation((now @ inverses)[:, None], triangles, areas)


def _sheet_at_rest(body: Any, first: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """What makes deformation gradients of the edges of triangles (m, 2, 2), and areas (m,)."""
    X = body.mesh.vertices[body.triangles]
    edges = np.stack([X[:, 1] - X[:, 0], X[:, 2] - X[:, 0]], axis=-1)  # (m, 3, 2)
    normals = np.cross(edges[..., 0], edges[..., 1])
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    normals = normals / (2.0 * areas[:, None])
    along = edges[..., 0] if first is None else np.broadcast_to(first, normals.shape)
    along = along - normals * (along * normals).sum(axis=1, keepdims=True)
    e1 = along / np.linalg.norm(along, axis=1, keepdims=True)
    axes = np.stack([e1, np.cross(normals, e1)], axis=1)  # (m, 2, 3)
    return np.linalg.inv(axes @ edges), areas


def _at_rest(body: Any) -> tuple[np.ndarray, np.ndarray]:
    """The same along first edges, which is computed once for all handles of a body."""
    known: dict[str, Any] = getattr(body, "_shared", {})
    if "at_rest" not in known:
        known["at_rest"] = _sheet_at_rest(body)
    found: tuple[np.ndarray, np.ndarray] = known["at_rest"]
    return found


def at_vertices(deformation: Deformation, values: np.ndarray, count: int) -> np.ndarray:
    """Means of values (m, k, ...) of elements at ``count`` vertices, weighted by the sizes of the elements:
    (count, ...). 0 at vertices of no element."""
    elements = deformation.elements
    each = np.broadcast_to(values, (*elements.shape, *values.shape[2:]))
    weights = np.broadcast_to(deformation.sizes[:, None], elements.shape)
    total, weight = np.zeros((count, *values.shape[2:])), np.zeros(count)
    shaped = weights.reshape(*weights.shape, *[1] * (values.ndim - 2))
    np.add.at(total, elements, shaped * each)
    np.add.at(weight, elements, weights)
    return np.asarray(total / np.where(weight > 0.0, weight, 1.0).reshape(-1, *[1] * (values.ndim - 2)))


def at_body(body: Any, deformation: Deformation, values: np.ndarray) -> np.ndarray:
    """At all vertices of a body, as ``at_vertices``; embedded ones have what their cells have there, nodes
    of no full cell the mean of those in their cells: what cells have beyond the surface is of no material."""
    mesh, count = body.mesh, len(body.positions)
    if not isinstance(mesh, meshes.EmbeddedMesh):
        return at_vertices(deformation, values, count)
    found = mesh.carried(at_vertices(deformation, values, mesh.node_count))
    around = mesh.elements[mesh.cells]  # of each embedded vertex
    shown = found[mesh.node_count :, None]
    near = np.ones(len(around))
    mean = at_vertices(Deformation(np.empty(0), around, near), shown, mesh.node_count)
    loose = np.setdiff1d(around, mesh.elements[mesh.filling[:, 0] >= 1.0])
    found[loose] = mean[loose]
    return found


def in_material(body: Any, gradients: np.ndarray, tensor: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Values (m, k, ...) of ``tensor`` at deformation gradients (m, k, 3, d). Cells of a lattice that are cut
    have at their nodes the tangent about the middle of what is inside: beyond the surface their polynomials
    may be turned inside out, where stresses are of any size, and means are to be of the material."""
    values = tensor(gradients)
    mesh = body.mesh
    if not isinstance(mesh, meshes.EmbeddedMesh):
        return values
    parts = mesh.filling[:, 0]
    means = mesh.filling[:, [1, 3, 9]] / np.where(parts > 0.0, parts, 1.0)[:, None]
    middle = np.einsum("mn,mnij->mij", _shapes(2.0 * means - 1.0, gradients.shape[1]), gradients)[:, None]
    away = gradients - middle
    length = np.linalg.norm(away, axis=(-2, -1), keepdims=True)
    step = away / np.where(length > 0.0, length, 1.0) * _STEP
    slope = (tensor(middle + step) - tensor(middle - step)) / (2.0 * _STEP)
    return np.where((parts < 1.0)[:, None, None, None], tensor(middle) + length * slope, values)


@functools.cache
def shape_slopes(nodes: int) -> np.ndarray:
    """Gradients of the shape functions of solid elements in their own coordinates at each node, (k, n, 3);
    of linear tetrahedra at one place. Nodes in the order of VTK."""
    places = _nodes(nodes)
    powers = _powers(nodes)
    at_nodes = places[:1] if nodes == 4 else places
    coefficients = np.linalg.inv(_monomials(places, powers))  # monomials x shape functions
    slopes = []
    for axis in range(3):
        lower = powers.copy()
        lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
        slopes.append(powers[:, axis] * _monomials(at_nodes, lower) @ coefficients)
    return np.stack(slopes, axis=-1)


def _shapes(points: np.ndarray, nodes: int) -> np.ndarray:
    """Shape functions of a hexahedron at points (m, 3) within it, from -1 to 1: (m, n)."""
    powers = _powers(nodes)
    return np.asarray(_monomials(points, powers) @ np.linalg.inv(_monomials(_nodes(nodes), powers)))


def _monomials(points: np.ndarray, powers: np.ndarray) -> np.ndarray:
    return np.asarray((points[:, None, :] ** powers[None]).prod(axis=-1))


def _powers(nodes: int) -> np.ndarray:
    if nodes in (4, 10):
        degree = 1 if nodes == 4 else 2
        every = np.indices((degree + 1,) * 3).reshape(3, -1).T
        return np.asarray(every[every.sum(axis=1) <= degree])
    return np.indices((2 if nodes == 8 else 3,) * 3).reshape(3, -1).T


def _nodes(nodes: int) -> np.ndarray:
    """Own coordinates of the nodes: those of an element that our own functions make."""
    if nodes in (4, 10):
        corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
        one: Any = meshes.TetMesh(corners, [[0, 1, 2, 3]])
    else:
        one = meshes.box_hexahedra(2.0, 1).centered()
    if nodes in (10, 27):
        one = meshes.to_quadratic(one)
    elements = one.tets if hasattr(one, "tets") else one.elements
    return np.asarray(one.vertices[elements[0]])
