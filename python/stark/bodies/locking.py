"""Solids that are one to three linear elements thick: what is said of those that bend far less than they
should."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.bodies.solid import LINEAR, Solid
from stark.mesh import EmbeddedMesh, TetMesh
from stark.selections import Points

Floats = NDArray[np.float64]

_SLENDER = (
    10.0  # longest side over the mean thickness 2 V / A: of a cube 3, of a beam 5 times as long as wide 10
)
_FREE = 0.5  # more of the vertices than this are free in bodies that can bend
_BENDS = 0.5  # deflections above this share of the right one are not said
_EVEN = (
    1.95  # longest over shortest edge, in the middle: of cubes in tetrahedra 1.73, of fTetWild 1.55 to 1.87
)
_OF_EVEN = 2.0  # error of such tetrahedra one edge across: fitted to 70 cantilevers of fTetWild's meshes
_EVEN_BENDS = 0.45  # deflections above are not said: coarse beams reach up to 0.55 where the fit has 0.46
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
    if not layers:
        return ""
    ratio = _ratio(mesh.vertices, elements)
    if nodes == 4 and layers > 1 and ratio < _EVEN:
        edges = _edges_across(solid)
        share, limit, thick = 1.0 / (1.0 + _OF_EVEN / edges**2), _EVEN_BENDS, f"{edges:.1f} edges"
    else:
        share, limit, thick = _deflection(nodes, ratio, layers), _BENDS, _NUMBER[layers]
    if share > limit or not _can_bend(solid, energies, attachments):
        return ""
    factor = "3 times or more" if nodes == 4 and layers == 1 else f"about {1.0 / share:.2g} times"
    return (
        f"solid '{solid.name}': it is {thick} thick, of {LINEAR[nodes]}: where it bends, it is "
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
    extent = np.ptp(solid.mesh.vertices, axis=0).max()
    return bool(extent > _SLENDER * _mean_thickness(solid))


def _mean_thickness(solid: Solid) -> float:
    """Twice the volume over the area [m]: that of a plate, half of that of a square beam."""
    a, b, c = solid.mesh.vertices[solid.triangles].transpose(1, 0, 2)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 3.0 / area)


def _edges_across(solid: Solid) -> float:
    """The thickness over the mean edge; of curved walls up to twice as much."""
    from stark.mesh import edge_lengths  # with the mesher, which others need not load

    from_middle = solid.mesh.vertices - solid.mesh.vertices.mean(axis=0)
    axes = np.linalg.svd(from_middle, full_matrices=False)[2]
    thickness = min(2.0 * _mean_thickness(solid), np.ptp(from_middle @ axes.T, axis=0).min())
    return float(thickness / edge_lengths(TetMesh(solid.mesh.vertices, solid._all_elements())).mean())


def _ratio(vertices: Floats, elements: NDArray[np.int32]) -> float:
    """Of the longest to the shortest edge of an element, in the middle of all."""
    edges = _EDGES_OF_TETRAHEDRA if elements.shape[1] == 4 else _EDGES_OF_HEXAHEDRA
    ends = vertices[elements[:, np.array(edges)]]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=2)
    return float(np.median(lengths.max(axis=1) / np.maximum(lengths.min(axis=1), np.finfo(float).tiny)))


def _deflection(nodes: int, ratio: float, layers: int) -> float:
    """Of a plate of cells over that of the theory of plates: fitted to cantilevers of cells one to six times
    as long as their layer is thick, without ``mean_dilatation``. The longest edge of tetrahedra is a
    diagonal of the cell."""
    error = 1.5 + 0.74 * (ratio**2 - 1.0) if nodes == 4 else 0.4 * ratio**2
    return 1.0 / (1.0 + error / layers**2)


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
