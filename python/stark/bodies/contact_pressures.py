"""Contact pressure at vertices: the force of each over its part of the faces that touch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stark.mesh import Indices, Mesh, Polyline
from stark.mesh.face_shapes import boundary_faces, face_shares

Floats = NDArray[np.float64]


class VertexShares:
    """What vertices have of the faces of a surface: a third of a triangle; of faces of elements with more
    nodes the integrals of their shape functions, as the elements spread an even pressure."""

    def __init__(self, mesh: Mesh | Polyline, triangles: Indices, areas: Floats, touching: NDArray[np.bool_]):
        """areas (m,) of the triangles [m^2]; touching (m,): which of them touch."""
        faces = boundary_faces(mesh)
        self._faces = triangles if faces is None else faces
        self._shares = np.full(3, 1.0 / 3.0) if faces is None else face_shares(faces.shape[1])
        self._areas = areas.reshape(len(self._faces), -1).sum(axis=1)
        self._touching = np.asarray(touching.reshape(len(self._faces), -1).all(axis=1))

    def areas(self, count: int) -> Floats:
        """Of each vertex (count,): of the faces that touch, of all where none does [m^2]."""
        return self._by_vertex(self._areas[:, None] * self._shares, count)

    def lend(self, forces: Floats) -> Floats:
        """Forces (n,) with those of vertices without an area, the corners of quadratic tetrahedra, given to
        the other nodes of their faces in equal parts."""
        if self._shares.all():
            return forces
        corners, others = self._faces[:, self._shares == 0.0], self._faces[:, self._shares > 0.0]
        counts = self._by_vertex((self._shares == 0.0) * np.ones_like(self._faces), len(forces))
        given = np.divide(forces, counts, out=np.zeros_like(forces), where=counts > 0.0)
        lent = np.where(counts > 0.0, 0.0, forces)
        used = self._used(len(forces))
        for k in range(corners.shape[1]):
            part = np.where(used[corners[:, k]] == self._touching, given[corners[:, k]], 0.0)
            np.add.at(lent, others.ravel(), np.repeat(part / others.shape[1], others.shape[1]))
        return lent

    def fill(self, pressure: Floats, forces: Floats) -> Floats:
        """Pressure (n,) with the mean of the other nodes of their faces at vertices without an area, where
        these have a force (n,) or touch."""
        if self._shares.all():
            return pressure
        is_corner = self._shares == 0.0
        means = pressure[self._faces[:, ~is_corner]].mean(axis=1)[:, None]
        sums = self._by_vertex(is_corner * means, len(pressure))
        counts = self._by_vertex(is_corner * np.ones_like(means), len(pressure))
        filled = (counts > 0.0) & (self._used(len(pressure)) | (forces > 0.0))
        return np.divide(sums, counts, out=pressure.copy(), where=filled)

    def _used(self, count: int) -> NDArray[np.bool_]:
        """Whether a vertex has faces that touch, which then alone count (count,)."""
        used = np.zeros(count, dtype=bool)
        used[self._faces[self._touching]] = True
        return used

    def _by_vertex(self, values: Floats, count: int) -> Floats:
        """Sums of what the nodes of faces have (m, k), of the faces that count for them (count,)."""
        sums = np.zeros(count)
        counts = self._used(count)[self._faces] == self._touching[:, None]
        np.add.at(sums, self._faces[counts], np.broadcast_to(values, self._faces.shape)[counts])
        return sums
