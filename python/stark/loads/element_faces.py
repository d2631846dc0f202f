"""Pressure on the faces of elements of 8 nodes and more. The volume below a face, by its shape functions, is
a sum over triples of its nodes. Triangles that the face is cut into have another: their forces strain the
elements next to them as no even pressure does."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from itertools import combinations

import numpy as np

from stark.formulas import Triangle, Vec3, energy, parameter
from stark.mesh import Indices, Mesh, Polyline
from stark.mesh.face_shapes import Floats, face_nodes, face_quadrature, shape_functions
from stark.symbolic import Scalar, cross, dot


@energy(translation_invariant=False)  # a closed surface is, its triples are not
def pressure(
    t: Triangle,
    pressure: float = parameter(unit="Pa", doc="pressure inside over that outside"),
    origin: Vec3 = parameter(unit="m", doc="any point near the body, the same for all triples"),
    share: float = parameter(1.0, doc="what the triple counts in the volume inside"),
) -> Scalar:
    """Pressure inside a closed surface of faces of elements: minus pressure times enclosed volume, a sum over
    triples of their nodes. [theory eq. 15a]"""
    a, b, c = t[0].x - origin, t[1].x - origin, t[2].x - origin
    return -share * pressure / 6.0 * dot(a, cross(b, c))


def whole_faces(mesh: Mesh | Polyline, triangles: Indices) -> tuple[Indices, Floats] | None:
    """Triples of nodes (n, 3) and their shares (n,) that have the volume of the faces that the triangles are
    cut from. None where triangles say it all: of faces of three nodes, lattices and cloth, and where they
    are not the whole of such faces. All faces are taken so or none, or the surface would have gaps."""
    nodes = face_nodes(mesh, triangles)
    if nodes is None:
        return None
    triples, shares = face_triples(nodes.shape[1])
    return nodes[:, triples].reshape(-1, 3), np.tile(shares, len(nodes))


@cache
def face_triples(count: int) -> tuple[Indices, Floats]:
    """Triples of the nodes of a face of 4, 6 or 9 nodes (n, 3) and their shares (n,): the volume below the
    face is the sum of w x_0 . (x_1 x x_2)/6. [theory eq. 15a]"""
    at, weights = face_quadrature(count == 6)
    values = [shape_functions(count, u, v) for u, v in at]
    triples, shares = [], []
    for triple in combinations(range(count), 3):
        columns = np.stack([value[:, triple] for value in values])
        share = Fraction(float(2.0 * weights @ np.linalg.det(columns))).limit_denominator(1000)
        if share:
            triples.append(triple)
            shares.append(float(share))
    return np.asarray(triples, dtype=np.int32), np.asarray(shares)
