"""Solids that are one to three linear elements thick: what is said of those that bend far less than they
should."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.bodies.solid import LINEAR, Solid
from stark.mesh import EmbeddedMesh
from stark.selections import Points

Floats = NDArray[np.float64]

_SLENDER = (
    10.0  # longest side over the mean thickness 2 V / A: of a cube 3, of a beam 5 times as long as wide 10
)
_FREE = 0.5  # more of the vertices than this are free in bodies that can bend
_BENDS = 0.5  # deflections above this share of the right one are not said
_NUMBER = {1: "one element", 2: "two elements", 3: "three elements"}
_PER_VERTEX = {4: 5.2, 8: 0.76}  # elements: three layers have fewer, others need no look at the surface
_AROUND_A_MIDDLE = 12  # tetrahedra around a vertex in the middle of a cell of six faces
_EDGES_OF_TETRAHEDRA = ((0, 0, 0, 1, 1, 2), (1, 2, 3, 2, 3, 3))
_EDGES_OF_HEXAHEDRA = ((0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3), (1, 2, 3, 0, 5, 6, 7, 4, 4, 5, 6, 7))


def thin_warnings(bodies: Iterable[Any], energies: Iterable[Any], attachments: Iterable[Any]) -> list[str]:
    """One for each solid of linear elements that is slender, a few elements thick, and free to bend."""
    found = []
    for solid in bodies:
        if isinstance(solid, Solid) and (text := _said(solid, energies, attachments)):
            found.append(text)
    return found


def _said(solid: Solid, energies: Iterable[Any], attachments: Iterable[Any]) -> str:
    nodes, mesh = solid._element_nodes(), solid.mesh
    if nodes not in (4, 8) or isinstance(mesh, EmbeddedMesh):
        return ""
    elements = solid._all_elements()
    if len(elements) > _PER_VERTEX[nodes] * len(mesh.vertices) or not _is_slender(solid):
        return ""
    layers = _layers(solid, elements)
    share = _deflection(mesh.vertices, elements, layers) if layers else 1.0
    if share > _BENDS or not _can_bend(solid, energies, attachments):
        return ""
    factor = "3 times or more" if nodes == 4 and layers == 1 else f"about {1.0 / share:.2g} times"
    return (
        f"solid '{solid.name}': it is {_NUMBER[layers]} thick, of {LINEAR[nodes]}: where it bends, it is "
        f"{factor} too stiff (docs/solids.md); write stark.mesh.to_quadratic(mesh), or give it more elements "
        f"across; a thin sheet is better a cloth with flexural_rigidity"
    )


def _layers(solid: Solid, elements: NDArray[np.int32]) -> int:
    """Elements across the thickness, by which of them reach the surface; 0 for more than three. Tetrahedra
    around the middle of a cell count as one."""
    inside = np.ones(len(solid.mesh.vertices), dtype=bool)
    inside[solid._surface()[1]] = False
    if inside[elements].sum(axis=1).max(initial=0) <= 1:
        return 1
    middle = inside & (np.bincount(elements.ravel(), minlength=len(inside)) <= _AROUND_A_MIDDLE)
    outer = ~inside[elements].all(axis=1)
    beside = np.zeros(len(inside), dtype=bool)
    beside[elements[outer]] = True
    if elements.shape[1] == 4:
        outer |= (middle & beside)[elements].any(axis=1)
    if outer.all():
        return 2
    deep = inside & ~middle if elements.shape[1] == 4 else inside
    deep[elements[outer]] = False
    return 0 if deep.any() else 3


def _is_slender(solid: Solid) -> bool:
    vertices = solid.mesh.vertices
    a, b, c = vertices[solid.triangles].transpose(1, 0, 2)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    return bool(np.ptp(vertices, axis=0).max() * area > 2.0 * _SLENDER * volume)


def _deflection(vertices: Floats, elements: NDArray[np.int32], layers: int) -> float:
    """Of a plate over that of the theory of plates: fitted to cantilevers of cells one to six times as long
    as their layer is thick, without ``mean_dilatation``."""
    edges = _EDGES_OF_TETRAHEDRA if elements.shape[1] == 4 else _EDGES_OF_HEXAHEDRA
    ends = vertices[elements[:, np.array(edges)]]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=2)
    ratio = np.median(lengths.max(axis=1) / np.maximum(lengths.min(axis=1), np.finfo(float).tiny))
    # Of tetrahedra, the longest edge is a diagonal of the cell.
    error = 1.5 + 0.74 * (ratio**2 - 1.0) if elements.shape[1] == 4 else 0.4 * ratio**2
    return float(1.0 / (1.0 + error / layers**2))


def _can_bend(solid: Solid, energies: Iterable[Any], attachments: Iterable[Any]) -> bool:
    """Not a slice between rollers, nor a pad that is glued to something."""
    held = np.zeros(len(solid.mesh.vertices), dtype=bool)
    held[solid.pins] = True
    for points in _holding(energies, attachments):
        if points.body is solid and "vertices" in points._columns:
            held[points._columns["vertices"]] = True
    return bool(held.mean() < _FREE)


def _holding(energies: Iterable[Any], attachments: Iterable[Any]) -> Iterator[Any]:
    """Points that attachments hold, and those that energies of single points may hold, as rollers do."""
    for energy in energies:
        if len(columns := energy._binding.columns) == 1 and isinstance(columns[0], Points):
            yield columns[0]
    for attachment in attachments:
        yield attachment.points
