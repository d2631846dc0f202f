"""Tractions and pressures on some faces of a body. Forces on the nodes of a face are those of its shape
functions: equal shares for its triangles would strain the elements below as no even load does."""

from __future__ import annotations

from functools import cache
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.bodies import Body
from stark.body_kinds import has_points, row_of
from stark.formulas import Point, Triangle, Vec3, energy, parameter
from stark.handle import BodyHandle
from stark.mesh import Indices
from stark.mesh.face_shapes import cut_faces, face_nodes, face_quadrature, shape_functions
from stark.mesh.repair import turned_edge
from stark.selections import Points, Stencils, stencils, vertex_points
from stark.symbolic import Scalar, cross, dot

Floats = NDArray[np.float64]


@energy
def traction(
    p: Point,
    traction: Vec3 = parameter(unit="Pa", doc="force per area at rest"),
    area: float = parameter(unit="m^2", doc="that each point stands for"),
) -> Scalar:
    """Forces over an area that keep their direction."""
    return -area * dot(traction, p.x)


@energy
def face_pressure(
    t: Triangle,
    pressure: float = parameter(unit="Pa", doc="that presses on the faces, against their normals"),
    shares: Vec3 = parameter(doc="of each node in the force of the triple"),
) -> Scalar:
    """Pressure on faces: minus the work that it does in the step, pressure times the volume that they sweep
    on straight paths. The sum is over triples of their nodes. [theory eq. 15k]"""
    work: Any = 0.0
    for i in range(3):
        a, b, c = t[i], t[(i + 1) % 3], t[(i + 2) % 3]
        e, f = b.x_prev - a.x_prev, c.x_prev - a.x_prev
        de, df = b.x - a.x - e, c.x - a.x - f
        area = cross(e, f) + (cross(e, df) + cross(de, f)) / 2.0 + cross(de, df) / 3.0  # its mean
        work = work + shares[i] * dot(a.x - a.x_prev, area)
    done: Scalar = pressure * work
    return done


class Faces(NamedTuple):
    """Some faces of the surface of a body."""

    body: BodyHandle
    nodes: Indices
    """(m, 3, 4, 6 or 9), in the order of the shape functions, from outside."""


def chosen_faces(surface: Any, owner: str) -> Faces:
    """The faces that are meant, whole faces of elements; InvalidArgument for anything else."""
    has_faces = isinstance(surface, Body) and has_points(surface) and row_of(surface).has_triangles
    faces = surface.faces if has_faces else surface
    columns = faces.columns if isinstance(faces, Stencils) and faces.point_count == 3 else ()
    body = columns[0].body if columns else None
    if body is None or any("vertices" not in c._columns or c.body is not body for c in columns):
        raise InvalidArgument(
            f"{owner} on {surface!r}: must be faces of a cloth or a solid, such as "
            f"solid.faces[mask[solid.triangles].all(axis=1)] with a mask of its vertices"
        )
    triangles = np.stack([column._columns["vertices"] for column in columns], axis=1)
    if not len(triangles):
        raise InvalidArgument(f"{owner} on '{body.name}': no faces are selected; look at the mask")
    cut = cut_faces(body.mesh)
    if cut is None:
        return Faces(body, triangles)
    nodes = face_nodes(body.mesh, triangles)
    if nodes is None:
        raise InvalidArgument(
            f"{owner} on '{body.name}': the {len(triangles)} triangles must be whole faces of elements, "
            f"each of which is {cut} triangles; select faces by a mask of vertices, "
            f"solid.faces[mask[solid.triangles].all(axis=1)]"
        )
    return Faces(body, nodes)


def areas_of_nodes(faces: Faces) -> tuple[Points, Floats]:
    """The nodes of the faces (n,) and the area at rest that each stands for [m^2]. Of faces of 6 nodes it
    vanishes at corners."""
    X = np.asarray(faces.body.mesh.vertices, dtype=np.float64)[faces.nodes]
    areas = np.zeros(X.shape[:2])
    for (u, v), weight in _points_of(faces.nodes.shape[1]):
        values, along_u, along_v = _shape_of(faces.nodes.shape[1], u, v)
        normal = np.cross(along_u @ X, along_v @ X)
        areas += weight * np.linalg.norm(normal, axis=1)[:, None] * values
    vertices, rows = np.unique(faces.nodes, return_inverse=True)
    total: Floats = np.bincount(rows.ravel(), weights=areas.ravel()).astype(np.float64)
    return vertex_points(faces.body, vertices.astype(np.int32)), total


def refuse_turned(surface: Any, owner: str, faces: Faces) -> None:
    """InvalidArgument where the normals of two neighbouring triangles point to opposite sides: a pressure
    would push one and pull the other."""
    chosen = surface.faces if isinstance(surface, Body) else surface
    triangles = np.stack([column._columns["vertices"] for column in chosen.columns], axis=1)
    edge = turned_edge(triangles)
    if edge is not None:
        raise InvalidArgument(
            f"{owner} on '{faces.body.name}': its triangles at the edge between the vertices {edge[0]} and "
            f"{edge[1]} are oriented differently: neighbouring ones must have normals to the same side; turn "
            f"them with stark.mesh.oriented, or select faces of one side"
        )


def pressed_triples(faces: Faces) -> tuple[Stencils, Floats]:
    """Triples of nodes of the faces, and the shares (n, 3) of the energy ``face_pressure``."""
    triples, shares = _force_triples(faces.nodes.shape[1])
    rows = faces.nodes[:, triples].reshape(-1, 3)
    return stencils(faces.body, rows, "triples of nodes"), np.tile(shares, (len(faces.nodes), 1))


@cache
def _force_triples(count: int) -> tuple[Indices, Floats]:
    """Triples of the nodes of a face (n, 3) and what each of their three nodes gets: the integral of
    N_i (N_j,u N_k,v - N_j,v N_k,u), as in the force on node i, the sum over pairs j < k of that times
    (x_j - x_i) x (x_k - x_i)."""
    triples, shares = [], []
    values = [(weight, _shape_of(count, u, v)) for (u, v), weight in _points_of(count)]
    for triple in combinations(range(count), 3):
        row = []
        for turn in range(3):
            i, j, k = (triple[(turn + n) % 3] for n in range(3))
            row.append(sum(w * s[0, i] * (s[1, j] * s[2, k] - s[2, j] * s[1, k]) for w, s in values))
        if np.abs(row).max() > 1e-12:
            triples.append(triple)
            shares.append(row)
    return np.asarray(triples, dtype=np.int32), np.asarray(shares, dtype=np.float64)


def _points_of(count: int) -> list[tuple[Floats, float]]:
    at, weights = face_quadrature(count in (3, 6))
    return list(zip(at, weights.tolist(), strict=True))


def _shape_of(count: int, u: float, v: float) -> Floats:
    """Shape functions of a face and their derivatives by u and v (3, count)."""
    if count == 3:
        return np.array([[1.0 - u - v, u, v], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    return shape_functions(count, u, v)
