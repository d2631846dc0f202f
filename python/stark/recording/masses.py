"""Masses of the points of bodies, lumped here from mesh and density and not asked of the core: what a
recording for certification says about inertia shall not come from what is certified."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.body_kinds import has_frames, row_of

from .element_masses import solid_masses

Floats = NDArray[np.float64]


def point_masses(body: Any) -> Floats | None:
    """Masses of the vertices of a cloth or a solid with their layers, or of the nodes of a rod (n,) [kg];
    None for rigid bodies, and for those with fibres that bend, whose frames turn with moments of their
    own."""
    material = body._shared.get("material")
    layers = getattr(body, "layers", [])
    if material is None or any(getattr(layer, "bending", False) for layer in layers):
        return None
    mesh, row = body.mesh, row_of(body)
    if row.is_sheet:
        own = _of_triangles(mesh.vertices, mesh.triangles, material)
    elif row.has_triangles:
        own = solid_masses(mesh, np.asarray(material.density, dtype=np.float64))
    else:
        own = _of_edges(mesh.vertices, mesh.edges, material)
    return own + _of_layers(mesh.vertices, layers)


def second_moments(body: Any) -> Floats | None:
    """Second moments of mass of the sections at the nodes of a rod about its axes d1 and d2 (n, 2) [kg m^2]:
    the integrals of x_k^2 dm."""
    material = body._shared.get("material")
    if not has_frames(body) or material is None:
        return None
    if material.width > 0.0:
        squares = np.array([material.width**2, material.height**2]) / 12.0
    else:
        squares = np.full(2, 0.25 * material.radius**2)
    masses = point_masses(body)
    assert masses is not None
    return masses[:, None] * squares


def edge_lengths(body: Any) -> Floats | None:
    """Of the edges of a rod at rest (k,) [m]."""
    if not has_frames(body):
        return None
    return _lengths(body.mesh.vertices, body.mesh.edges)


def _of_layers(vertices: Floats, layers: Any) -> Floats:
    """Masses that skins and fibres add to the vertices (n,) [kg]."""
    total = np.zeros(len(vertices))
    for layer in layers:
        if row_of(layer).has_triangles:
            total += _of_triangles(vertices, layer.triangles, layer.material)
        else:
            total += _of_edges(vertices, layer.edges, layer.material)
    return total


def _of_triangles(vertices: Floats, triangles: Any, material: Any) -> Floats:
    """Of sheets, whose density is that of their areas."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return _lumped(vertices, triangles, np.asarray(material.density, dtype=np.float64) * areas)


def _of_edges(vertices: Floats, edges: Any, material: Any) -> Floats:
    """Of rods, whose section has a mass per length."""
    density = np.asarray(material.density, dtype=np.float64)
    per_length = material.section["mass"] * density / material._core.get("density")
    return _lumped(vertices, edges, per_length * _lengths(vertices, edges))


def _lengths(vertices: Floats, edges: Any) -> Floats:
    lengths: Floats = np.linalg.norm(np.diff(vertices[edges], axis=1)[:, 0], axis=1)
    return lengths


def _lumped(vertices: Floats, elements: Any, masses: Floats) -> Floats:
    """Equal shares of the masses of elements (m,) for their corners."""
    rows = np.asarray(elements, dtype=np.int32)
    corners = rows.shape[1]
    shares = np.repeat(masses / corners, corners)
    sums = np.bincount(rows.ravel(), weights=shares, minlength=len(vertices))
    return np.asarray(sums, dtype=np.float64)
