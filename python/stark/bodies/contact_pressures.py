"""Contact pressure at vertices: the force of each over its part of the faces that touch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stark.mesh import Indices, Mesh, Polyline
from stark.mesh.face_shapes import face_shares, uncut_faces

Floats = NDArray[np.float64]


class VertexShares:
    """What vertices have of the faces of a surface that touch, or of all where none does: a third of a
    triangle; of faces of elements with more nodes the integrals of their shape functions, as the elements
    spread an even pressure."""

    def __init__(
        self,
        mesh: Mesh | Polyline,
        triangles: Indices,
        triangle_areas: Floats,
        touching: NDArray[np.bool_],
        count: int,
    ) -> None:
        """Of a surface of so many vertices; triangle_areas (m,) [m^2]; touching (m,): which triangles do."""
        faces = uncut_faces(mesh, triangles)
        self._faces = triangles if faces is None else faces
        shares = np.full(3, 1.0 / 3.0) if faces is None else face_shares(faces.shape[1])
        touch = np.asarray(touching.reshape(len(self._faces), -1).all(axis=1))
        self._is_touched = np.zeros(count, dtype=bool)
        self._is_touched[self._faces[touch]] = True
        self._counts = self._is_touched[self._faces] == touch[:, None]  # faces for their nodes (m, k)
        self._is_corner = shares == 0.0  # nodes that have no area, of quadratic tetrahedra
        self._faces_of_corner = self._sums(self._is_corner * np.ones(self._faces.shape))
        face_areas = triangle_areas.reshape(len(self._faces), -1).sum(axis=1)
        self._areas = self._sums(face_areas[:, None] * shares)

    def pressure(self, forces: Floats) -> Floats:
        """Forces (n,) [N] over areas (n,) [Pa]. Vertices without an area give their force to the other nodes
        of their faces in equal parts, and have the mean pressure of these."""
        lent = self._lend(forces)
        pressure = np.divide(lent, self._areas, out=np.zeros_like(lent), where=self._areas > 0.0)
        sums = self._sums(self._is_corner * pressure[self._faces[:, ~self._is_corner]].mean(axis=1)[:, None])
        presses = (self._faces_of_corner > 0.0) & (self._is_touched | (forces > 0.0))
        return np.divide(sums, self._faces_of_corner, out=pressure, where=presses)

    def mean_pressure(self, forces: Floats, vertices: Indices) -> float:
        """Of these vertices together [Pa]."""
        return float(forces[vertices].sum() / self._areas[vertices].sum())

    def _lend(self, forces: Floats) -> Floats:
        """Forces (n,) with those of vertices without an area given away."""
        has_none = self._faces_of_corner > 0.0
        each = np.divide(forces, self._faces_of_corner, out=np.zeros_like(forces), where=has_none)
        given = np.where(self._counts & self._is_corner, each[self._faces], 0.0).sum(axis=1)
        others = self._faces[:, ~self._is_corner]
        lent = np.where(has_none, 0.0, forces)
        np.add.at(lent, others, np.broadcast_to(given[:, None] / others.shape[1], others.shape))
        return lent

    def _sums(self, values: Floats) -> Floats:
        """By vertex, of what the nodes of faces have (m, k), of the faces that count for them."""
        sums = np.zeros(len(self._is_touched))
        np.add.at(sums, self._faces[self._counts], np.broadcast_to(values, self._faces.shape)[self._counts])
        return sums
