"""Masses of the points of bodies, lumped here from mesh and density and not asked of the core: what a
recording for certification says about inertia shall not come from what is certified."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .element_masses import solid_masses

Floats = NDArray[np.float64]


def point_masses(body: Any) -> Floats | None:
    """Masses of the vertices of a cloth or a solid with their layers, or of the nodes of a rod (n,) [kg];
    None for rigid bodies, and for those with fibres that bend, whose frames turn with moments of their
    own."""
    material = body._shared.get("material")
    layers = getattr(body, "layers", [])
    if material is None or any(layer.kind == "fibres" and layer.bending for layer in layers):
        return None
    density = np.asarray(material.density, dtype=np.float64)
    if body.kind == "cloth":
        areas = _areas(body.mesh.vertices, body.mesh.triangles)
        own = _lumped(body.mesh.vertices, body.mesh.triangles, density * areas, 3)
        return own + _of_layers(body.mesh.vertices, layers)
    if body.kind == "solid":
        return solid_masses(body.mesh, density) + _of_layers(body.mesh.vertices, layers)
    if body.kind == "rod":
        return _of_nodes(body, material.section["mass"] * density / material._core.get("density"))
    return None


def second_moments(body: Any) -> Floats | None:
    """Second moments of mass of the sections at the nodes of a rod about its axes d1 and d2 (n, 2) [kg m^2]:
    the integrals of x_k^2 dm."""
    material = body._shared.get("material")
    if body.kind != "rod" or material is None:
        return None
    if material.width > 0.0:
        squares = np.array([material.width**2, material.height**2]) / 12.0
    else:
        squares = np.full(2, 0.25 * material.radius**2)
    masses = point_masses(body)
    assert masses is not None
    return masses[:, None] * squares


def _lumped(vertices: Floats, elements: NDArray[np.int32], masses: Floats, corners: int) -> Floats:
    """Equal shares of the masses of elements (m,) for their corners."""
    shares = np.repeat(masses / corners, corners)
    sums = np.bincount(elements.ravel(), weights=shares, minlength=len(vertices))
    return np.asarray(sums, dtype=np.float64)


def _of_layers(vertices: Floats, layers: Any) -> Floats:
    """Masses that skins and fibres add to the vertices (n,) [kg]."""
    total = np.zeros(len(vertices))
    for layer in layers:
        density = np.asarray(layer.material.density, dtype=np.float64)
        if layer.kind == "skin":
            elements = np.asarray(layer.triangles, dtype=np.int32)
            sizes = density * _areas(vertices, elements)
        else:
            elements = np.asarray(layer.edges, dtype=np.int32)
            per_length = layer.material.section["mass"] * density / layer.material._core.get("density")
            sizes = per_length * np.linalg.norm(np.diff(vertices[elements], axis=1)[:, 0], axis=1)
        total += _lumped(vertices, elements, sizes, elements.shape[1])
    return total


def _areas(vertices: Floats, triangles: NDArray[np.int32]) -> Floats:
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _of_nodes(rod: Any, mass_per_length: Floats) -> Floats:
    """Half of the mass of each segment for either end."""
    points = rod.mesh.vertices
    masses = mass_per_length * np.linalg.norm(np.diff(points, axis=0), axis=1)
    nodes = np.zeros(len(points))
    nodes[:-1] += 0.5 * masses
    nodes[1:] += 0.5 * masses
    return nodes
