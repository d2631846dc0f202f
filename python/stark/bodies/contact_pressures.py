"""Contact pressure at vertices: the force of each over its part of the faces that touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.mesh import Indices, Mesh, Polyline
from stark.mesh.face_shapes import cut_faces, face_shares, node_places, uncut_faces

Floats = NDArray[np.float64]


def pressures_of(bodies: Sequence[Any], contacts: Any) -> list[Floats]:
    """``body.contact_pressure()`` of each of the bodies with triangles of a simulation, whose ``contacts``
    these are: together, since a call for each goes through all contacts."""
    both = contacts._both_sides()
    begins = np.searchsorted(both.bodies[:, 0], np.arange(len(contacts.names) + 1))
    results = []
    offsets = np.full(len(contacts.names), -1)  # in the rows of all that touch, by body
    together: list[int] = []
    x, triangles, patches, count = [], [], [], 0
    for k, body in enumerate(bodies):
        places = body.positions
        results.append(np.zeros(len(places)))
        mine = slice(*begins[body._index : body._index + 2])
        if mine.start == mine.stop:
            continue
        if cut_faces(body.mesh) is not None:
            results[k] = body._pressure_of(both._take(mine))
            continue
        if len(body._inner_vertices()) > 0:
            patches += [count + patch for patch in body._flat_patches(both._take(mine))]
        together.append(k)
        offsets[body._index] = count
        x.append(places)
        triangles.append(body.triangles + count)
        count += len(x[-1])
    if not together:
        return results
    rows = both._take(offsets[both.bodies[:, 0]] >= 0)
    rows = replace(rows, vertices=rows.vertices + offsets[rows.bodies[:, :1]])
    pressure = pressure_on(np.concatenate(x), np.concatenate(triangles), rows, patches)
    for k, own in zip(together, np.split(pressure, np.cumsum([len(one) for one in x])[:-1]), strict=True):
        results[k] = own
    return results


def pressure_on(
    x: Floats,
    triangles: Indices,
    contacts: Any,
    patches: Sequence[Indices],
    mesh: Mesh | Polyline | None = None,
) -> Floats:
    """At vertices (n, 3), of the contacts of a surface that is the first of each pair; its flat patches have
    their mean. ``mesh``: what it is the surface of, whose faces may be cut into triangles."""
    forces = np.linalg.norm(contacts._spread(contacts.normal_forces, len(x)), axis=1)
    touching = touched(contacts, patches, triangles, len(x))
    shares = VertexShares(mesh, triangles, areas_of(x, triangles), touching, len(x))
    pressure = shares.pressure(forces)
    for patch in patches:
        pressure[patch] = shares.mean_pressure(forces, patch)
    return pressure


def touched(contacts: Any, patches: Sequence[Indices], triangles: Indices, count: int) -> NDArray[np.bool_]:
    """Triangles, of so many vertices, all of whose vertices are in contact as points, not as corners of a
    face that is touched, or in a flat patch."""
    vertex = np.zeros(count, dtype=bool)
    for k in range(4):
        mine = (contacts.first_counts > k) & (contacts.weights[:, k] > 1.0 - 1e-9)
        vertex[contacts.vertices[mine, k]] = True
    for patch in patches:
        vertex[patch] = True
    return np.asarray(vertex[triangles].all(axis=1))


def areas_of(points: Floats, triangles: Indices) -> Floats:
    """Of triangles (m,), with vertices at points (n, 3)."""
    a, b, c = (np.asarray(points)[corners] for corners in triangles.T)
    (ux, uy, uz), (vx, vy, vz) = (b - a).T, (c - a).T
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx  # np.cross() takes 40 us
    areas: Floats = 0.5 * np.sqrt(x * x + y * y + z * z)
    return areas


class VertexShares:
    """What vertices have of the faces of a surface that touch, or of all where none does: a third of a
    triangle; of faces of elements with more nodes the integrals of their shape functions, as the elements
    spread an even pressure."""

    def __init__(
        self,
        mesh: Mesh | Polyline | None,
        triangles: Indices,
        triangle_areas: Floats,
        touching: NDArray[np.bool_],
        count: int,
    ) -> None:
        """Of a surface of so many vertices, that of a mesh if its faces may be cut; triangle_areas (m,)
        [m^2]; touching (m,): which triangles do."""
        faces = None if mesh is None else uncut_faces(mesh, triangles)
        self._faces = triangles if faces is None else faces
        shares = np.full(3, 1.0 / 3.0) if faces is None else face_shares(faces.shape[1])
        self._shares = shares
        touch = np.asarray(touching.reshape(len(self._faces), -1).all(axis=1))
        self._is_touched = np.zeros(count, dtype=bool)
        self._is_touched[self._faces[touch]] = True
        self._counts = self._is_touched[self._faces] == touch[:, None]  # faces for their nodes (m, k)
        self._is_corner = shares == 0.0  # nodes that have no area, of quadratic tetrahedra
        self._faces_of_corner = self._sums(self._is_corner)
        face_areas = triangle_areas.reshape(len(self._faces), -1).sum(axis=1)
        self._parts = face_areas[:, None] * shares
        self._areas = self._sums(self._parts)

    def pressure(self, forces: Floats) -> Floats:
        """Forces (n,) [N] over areas (n,) [Pa], of faces of nine nodes evened. Vertices without an area give
        their force to the other nodes of their faces in equal parts, and have the mean pressure of these."""
        if not self._is_corner.any():
            pressure = self._over_areas(forces)
            return self._evened(pressure) if len(self._shares) == 9 else pressure
        pressure = self._over_areas(self._lend(forces))
        sums = self._sums(self._is_corner * pressure[self._faces[:, ~self._is_corner]].mean(axis=1)[:, None])
        presses = (self._faces_of_corner > 0.0) & (self._is_touched | (forces > 0.0))
        return np.divide(sums, self._faces_of_corner, out=pressure, where=presses)

    def mean_pressure(self, forces: Floats, vertices: Indices) -> float:
        """Of these vertices together [Pa]."""
        return float(forces[vertices].sum() / self._areas[vertices].sum())

    def _evened(self, pressure: Floats) -> Floats:
        """At nodes (n,) the mean of their faces, in each of which it is bilinear, with the force and the
        moments of its nodes: what lies between the shares of the area that they have by their shape
        functions, and those of contact, thirds of triangles, alternates from node to node. Nothing is lost,
        and nowhere is a face pulled."""
        u, v = 2.0 * node_places(9).T - 1.0
        terms = np.stack([np.ones(9), u, v, u * v], axis=1)
        each = pressure[self._faces]
        factors = (self._shares * each) @ terms / (self._shares @ terms**2)
        varying = factors[:, 1:] @ terms[:, 1:].T
        least = -varying.min(axis=1)
        within = np.divide(factors[:, 0], least, out=np.ones(len(least)), where=least > factors[:, 0])
        evened = np.maximum(factors[:, :1] + within[:, None] * varying, 0.0)
        whole = self._counts.all(axis=1)[:, None]
        return self._over_areas(self._sums(self._parts * np.where(whole, evened, each)))

    def _over_areas(self, forces: Floats) -> Floats:
        pressures: Floats = np.divide(forces, self._areas, out=np.zeros_like(forces), where=self._areas > 0.0)
        return pressures

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
        each = np.where(self._counts, values, 0.0).ravel()
        return np.asarray(np.bincount(self._faces.ravel(), each, len(self._is_touched)), dtype=np.float64)
