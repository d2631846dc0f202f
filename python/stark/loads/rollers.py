"""Roller supports: points that stay in a plane and move freely in it, as in planes of symmetry."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.bodies import Cloth, Rod, Solid
from stark.bodies.layers import Fibres, Skin
from stark.formulas import Point, Triangle, Vec3, energy, parameter
from stark.formulas.law_checks import Law
from stark.formulas.material_law import MaterialLaw
from stark.materials import SolidMaterial
from stark.mesh import EmbeddedMesh, Indices
from stark.selections import Points, Stencils, stencils
from stark.symbolic import Scalar, dot, squared_norm

Floats = NDArray[np.float64]

#: Of a support over that of a cell of the body: what gives way is a thousandth of what cells do.
_STIFF = 1e3
#: Triangles whose normal has this cosine, or more, with that of rollers are held against bending alone.
_FACING = 0.9

# Part of an edge across the normal, from which it is an edge across it.
_ACROSS = 0.9
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@energy(translation_invariant=False)  # the plane stays
def rollers(
    p: Point,
    shift: float = parameter(0.0, unit="m", doc="of the plane along its normal since time 0"),
    place: Vec3 = parameter(unit="m", doc="of each point at time 0"),
    normal: Vec3 = parameter(doc="of the plane, a unit vector"),
    stiffness: float = parameter(unit="N/m", above=0.0, doc="of the support of each point"),
) -> Scalar:
    """Points that a plane holds along its normal."""
    off = dot(normal, p.x - place) - shift
    return 0.5 * stiffness * off * off


@energy(translation_invariant=True)
def slopes(
    t: Triangle,
    start: float = parameter(doc="sine of the slope at time 0"),
    normal: Vec3 = parameter(doc="of the plane of symmetry, a unit vector"),
    stiffness: float = parameter(unit="J", above=0.0, doc="of each triangle at the plane"),
) -> Scalar:
    """Triangles at a plane of symmetry, which keep their slope against it."""
    off = dot(normal, t.normal) - start
    return 0.5 * stiffness * off * off


@energy(translation_invariant=True)
def directions(
    node: Point,
    tip: Point,
    reach: float = parameter(unit="m", above=0.0, doc="from a node to its tip"),
    normal: Vec3 = parameter(doc="of the plane of symmetry, a unit vector"),
    stiffness: float = parameter(unit="N m", above=0.0, doc="of each node at the plane"),
) -> Scalar:
    """Nodes of rods at a plane of symmetry: what of their section is along the normal stays so."""
    return 0.5 * stiffness * squared_norm((tip.x - node.x) / reach - normal)


class Directions(NamedTuple):
    """What ``directions`` takes for the nodes of a rod at a plane of symmetry."""

    nodes: Points
    tips: Any
    reach: float
    stiffness: float


class Slopes(NamedTuple):
    """What ``slopes`` takes for the triangles of cloths and skins at a plane of symmetry."""

    triangles: Stencils
    start: Floats
    stiffness: Floats


def slopes_at(points: Points, normal: Floats) -> Slopes | None:
    """The triangles of cloths, and of skins, with an edge between the points; None where none bends."""
    body: Any = points.body
    vertices = points._columns.get("vertices")
    if not isinstance(body, (Cloth, Solid)) or vertices is None:
        return None
    sheets: list[Any] = [body] if isinstance(body, Cloth) else []
    sheets += [layer for layer in body.layers if isinstance(layer, Skin)]
    if not sheets:
        return None
    triangles, bending = _one_sheet(sheets)
    inside = np.isin(triangles, vertices)
    rows = np.flatnonzero((inside.sum(axis=1) == 2) & (bending > 0.0))
    if not len(rows):
        return None
    x = body.vertices.positions[triangles[rows]]
    free = np.argmin(inside[rows], axis=1)  # the corner beyond the edge
    at = np.arange(len(rows))
    edge = np.linalg.norm(x[at, (free + 2) % 3] - x[at, (free + 1) % 3], axis=1)
    areas = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    double_area = np.linalg.norm(areas, axis=1)
    # The triangle bends no edge of its own at the plane. Its slope is that of its middle, half its height
    # away, so this is the energy of its own curvature: D (2 slope/height)^2/2 times its area.
    stiffness = 2.0 * bending[rows] * edge**2 / double_area
    return Slopes(stencils(body, triangles[rows], "triangles"), areas @ normal / double_area, stiffness)


def _one_sheet(sheets: list[Any]) -> tuple[Indices, Floats]:
    """The triangles (n, 3) of sheets that lie on each other, each once, and their rigidities (n,) [N m]."""
    triangles = np.concatenate([sheet.triangles for sheet in sheets])
    bending = np.concatenate([_bending_of(sheet.material, len(sheet.triangles)) for sheet in sheets])
    corners = np.sort(triangles, axis=1)
    _, first, number = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    total: Floats = np.bincount(number.ravel(), weights=bending).astype(np.float64)
    return triangles[first[order]], total[order]


def _bending_of(material: Any, count: int) -> Floats:
    """Rigidity (count,) [N m] of the triangles of a sheet."""
    bending = np.maximum(material.flexural_rigidity, 3.0 * np.asarray(material.bending_stiffness))
    return np.broadcast_to(bending, count)


def hinged_fibres(points: Points) -> list[str]:
    """The fibres that bend and begin or end at the points: nothing holds their slopes there."""
    vertices = points._columns.get("vertices")
    if vertices is None:
        return []
    fibres = [layer for layer in getattr(points.body, "layers", ()) if isinstance(layer, Fibres)]
    return [
        layer.name
        for layer in fibres
        if layer.bending and (np.isin(layer.edges, vertices).sum(axis=1) == 1).any()
    ]


def directions_at(points: Points, normal: Floats) -> Directions | None:
    """The nodes of a rod; None of other bodies."""
    rod: Any = points.body
    vertices = points._columns.get("vertices")
    if not isinstance(rod, Rod) or vertices is None:
        return None
    section = rod.material.section
    bending = max(float(np.max(section[f"bending_stiffness_{k}"])) for k in (1, 2))
    reach = float(np.linalg.norm(np.diff(rod.mesh.vertices, axis=0), axis=1).mean())
    frames = rod._scene._core.initial_frames(rod._index).reshape(-1, 3, 3)[vertices]
    tips = rod.points(vertices, reach * (normal @ frames))
    return Directions(points, tips, reach, _STIFF * bending / reach)


def unit_normal(normal: str | ArrayLike, owner: str) -> Floats:
    """(3,) of "x", "y", "z" or a vector; InvalidArgument for anything else."""
    try:
        vector = np.asarray(_AXES[normal] if isinstance(normal, str) else normal, dtype=np.float64)
    except (KeyError, TypeError, ValueError, OverflowError):
        vector = np.zeros(0)
    length = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    if not 0.0 < length < np.inf:
        raise InvalidArgument(f"{owner}: normal = {normal!r}: must be 'x', 'y', 'z' or a vector (3,), not 0")
    return vector / length


def check_points(points: Any, owner: str) -> Points:
    """Those of a body, or InvalidArgument."""
    if not isinstance(points, Points) or points.is_direction:
        raise InvalidArgument(
            f"{owner}: points = {points!r}: must be points of a body, such as solid.vertices[mask]"
        )
    return points


def depth_of(points: Points, normal: Floats) -> tuple[float, float]:
    """How far points are apart along a normal at time 0, and how far those of their body are apart [m]."""
    body: Any = points.body
    if body is None or len(points) == 0:  # refused by what adds them
        return 0.0, 0.0
    places = body._scene._core.initial_positions(body._index)
    return float(np.ptp(points.positions @ normal)), float(np.linalg.norm(np.ptp(places, axis=0)))


def stiffness_of(points: Points, normal: Floats, owner: str) -> float:
    """[N/m] of the support of a point: a thousand times that of a cell of its body, along the normal."""
    body: Any = points.body
    if isinstance(body, Rod) and body.material.law is None:
        lengths = np.linalg.norm(np.diff(body.mesh.vertices, axis=0), axis=1)
        return _STIFF * float(np.max(body.material.section["axial_stiffness"]) / lengths.mean())
    modulus = _modulus(body.material) if isinstance(body, (Cloth, Solid)) else None
    if modulus is None:
        raise InvalidArgument(
            f"{owner}: {body!r} has no Young's modulus that says how stiff the support has to be; give "
            f"stiffness= [N/m] of each point, a thousand times that of what it holds"
        )
    if isinstance(body, Cloth):
        return _STIFF * modulus * float(body.material.thickness) * max(1.0, _flatness(points, normal, 1))
    size = float(_cell_size(body))
    return _STIFF * modulus * max(size, _flatness(points, normal, 2))


def _flatness(points: Points, normal: Floats, sides: int) -> float:
    """How large the cells at the points are across the normal over how large they are along it, in the
    middle: a length over a length in sheets (``sides`` 1), an area [m^2] over a length in solids. Zero for
    sheets across the normal, and for lattices, whose cells are cubes."""
    body: Any = points.body
    if isinstance(body.mesh, EmbeddedMesh):
        return 0.0
    cells = body.triangles if sides == 1 else body._all_elements()
    chosen = points._columns.get("vertices")
    if chosen is not None:
        cells = cells[np.isin(cells, chosen).any(axis=1)]
    x = body.vertices.positions[cells]
    if sides == 1:
        facing = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
        x = x[np.abs(facing @ normal) < _FACING * np.linalg.norm(facing, axis=1)]
    if not len(x):
        return 0.0
    extent = np.ptp(x @ _axes_across(normal, x[0]).T, axis=1)
    across = np.hypot(extent[:, 1], extent[:, 2]) if sides == 1 else extent[:, 1] * extent[:, 2]
    return float(np.median(across / extent[:, 0]))


def _axes_across(normal: Floats, cell: Floats) -> Floats:
    """Rows: the normal, and two directions across it that turn with a cell: along its first edge across the
    normal, or the one that is nearest to that."""
    edges = cell[1:] - cell[0]
    across = edges - np.outer(edges @ normal, normal)
    share = np.linalg.norm(across, axis=1) / np.linalg.norm(edges, axis=1)
    first = across[np.argmax(np.minimum(share, _ACROSS))]
    first = first / np.linalg.norm(first)
    return np.stack([normal, first, np.cross(normal, first)])


def _modulus(material: Any) -> float | None:
    """[Pa]: that of the law; the Young's modulus of a material means nothing to laws without one. None where
    nothing is known."""
    law = material.law
    if law is None:
        return _held_sideways(material)
    recorded = None if material._recorded is None else material._recorded[0]
    if isinstance(recorded, MaterialLaw):
        values = recorded.values_of(material)
        rows = max(len(np.atleast_1d(value)) for value in values.values()) if values else 1
        sampled = Law(recorded, values)
        return float(np.abs(sampled.at(np.repeat(sampled.identity[None], rows, axis=0))[2]).max())
    names = {row["name"] for row in law.parameters}
    moduli = [float(np.max(getattr(material, row["name"]))) for row in law.parameters if row["unit"] == "Pa"]
    if {"youngs_modulus", "poissons_ratio"} <= names:
        moduli.append(_held_sideways(material))
    return max(moduli, default=0.0) or None


def _held_sideways(material: Any) -> float:
    """[Pa]: of the stress over the strain of solids that other rollers keep from getting thicker. It grows
    without bound towards Poisson's ratio 0.5; cloths get thicker freely."""
    modulus, ratio = np.asarray(material.youngs_modulus), np.asarray(material.poissons_ratio)
    if not isinstance(material, SolidMaterial):
        return float(np.max(modulus))
    return float(np.max(modulus * (1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio))))


def _cell_size(solid: Solid) -> float:
    """[m]: of a cube that is as large as a cell is in the mean."""
    vertices = solid.mesh.vertices
    extent = np.ptp(vertices, axis=0)
    return float(np.cbrt(np.prod(extent) / len(vertices)))
