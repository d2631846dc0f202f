"""Meshes of a picture: the surfaces of bodies, what a clip plane leaves of them, with their colours."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stark.body_kinds import row_of

from .._core import InvalidArgument
from ..mesh import TriangleMesh
from ..recording.format import shown_mesh, surface
from ..tubes import rings
from .caps import cap
from .clipping import Plane, cut_triangles, section

#: Of bodies without values in a picture that shows values.
NEUTRAL = (0.80, 0.81, 0.83)
#: How far a section lies behind the clip plane, of its own extent.
_RECESS = 1e-4


@dataclass(frozen=True)
class Piece:
    """A mesh to draw."""

    name: str
    positions: np.ndarray  #: (n, 3) [m]
    triangles: np.ndarray  #: (m, 3)
    color: tuple[float, float, float]  #: sRGB in [0, 1]
    smooth: bool = False  #: no edges, however sharp; the back is paler
    scenery: bool = False  #: dissolves far away
    opacity: float = 1.0
    values: np.ndarray | None = None  #: of the vertices (n,), shown by colour
    outlined: bool = True  #: shows its edges where the picture shows edges


def pieces_of(
    bodies: Sequence[Any],
    colors: Sequence[tuple[float, float, float]],
    scenery: Sequence[bool],
    opacity: Sequence[float],
    values: Mapping[str, np.ndarray],
    planes: Sequence[Plane | None],
    thinnest: Callable[[np.ndarray], np.ndarray] | None = None,
) -> list[Piece]:
    """Pieces of all bodies; ``values`` by name, at each vertex of a body. Where there are any, other bodies
    are neutral. Scenery is not clipped. ``thinnest`` has the least radius of rods and fibres at points
    (n, 3) [m]."""
    result = []
    rows = zip(bodies, colors, scenery, opacity, planes, strict=True)
    for body, color, far, share, plane in rows:
        positions, triangles = surface(body)
        require_finite(body.name, positions)
        if thinnest is not None and not row_of(body).has_triangles:
            positions = _widened(positions, triangles, thinnest)
        own = values.get(body.name)
        piece = Piece(
            name=str(body.name),
            positions=positions.astype(np.float64),
            triangles=triangles.astype(np.int32),
            color=NEUTRAL if values and own is None else color,
            smooth=row_of(body).is_sheet,
            scenery=far,
            opacity=share,
            values=None if own is None else at_surface(body, own),
        )
        result += [piece] if plane is None or far else _clipped(piece, body, own, plane)
    return result


def _widened(
    positions: np.ndarray, triangles: np.ndarray, thinnest: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Tubes of rods and fibres with a radius that can be seen; other surfaces as they are."""
    sections = rings(len(positions), triangles)
    if sections is None:
        return positions
    corners = positions[sections]
    middles = corners.mean(axis=1, keepdims=True)
    radii = np.linalg.norm(corners - middles, axis=2).max(axis=1)
    factors = np.maximum(1.0, thinnest(middles[:, 0]) / np.maximum(radii, 1e-300))
    if (factors == 1.0).all():
        return positions
    wider = positions.astype(np.float64)
    wider[sections] = middles + factors[:, None, None] * (corners - middles)
    return wider


def require_finite(name: str, positions: np.ndarray) -> None:
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):
        raise InvalidArgument(
            f"body '{name}': vertex {bad[0]} is not finite; only finite positions can be drawn"
        )


def at_surface(body: Any, values: np.ndarray) -> np.ndarray:
    """Values of the drawn vertices, of those of all vertices."""
    if shown_mesh(body) is not None:
        return np.asarray(values[_touching(body)])
    if hasattr(type(body), "_surface"):  # a solid: those of its vertices that are on its surface
        used = body._surface()[1]
        return values if len(values) == len(used) else np.asarray(values[used])
    mesh = getattr(body, "_mesh", None)
    if isinstance(mesh, TriangleMesh) and len(values) == len(mesh.vertices):  # cloth and rigid bodies
        return values
    drawn = len(surface(body)[0])
    is_tube = not row_of(body).has_triangles
    if is_tube and drawn > len(values):  # rings around the nodes, then the middles of both ends
        return np.concatenate([np.repeat(values, (drawn - 2) // len(values)), values[[0, -1]]])
    if len(values) == drawn:
        return values
    return np.asarray(values[np.unique(body.triangles)])


def _touching(body: Any) -> np.ndarray:
    """The vertex of the surface that touches next to each one that is shown instead (n,)."""
    known: np.ndarray | None = body._shared.get("touching")
    if known is None:
        found = []
        for rows in np.array_split(body.shown.vertices, 1 + len(body.shown.vertices) // 256):
            away = ((rows[:, None] - body.mesh.vertices) ** 2).sum(axis=2)
            found.append(away.argmin(axis=1))
        known = body._shared["touching"] = np.concatenate(found)
    return known


def _clipped(piece: Piece, body: Any, values: np.ndarray | None, plane: Plane) -> list[Piece]:
    """What is left of a piece, and its section: of a solid with its values inside, of other closed bodies
    without."""
    parts = [_cut(piece, plane)]
    tets = _tetrahedra(body)
    if tets is not None:
        numbers = np.zeros(len(body.positions)) if values is None else values
        data, faces = section(plane, np.column_stack([body.positions, numbers]), tets)
        parts.append(
            dataclasses.replace(
                piece, positions=data[:, :3], triangles=faces, values=None if values is None else data[:, 3]
            )
        )
    elif not piece.smooth:
        parts += _capped(piece, plane)
    return [part for part in parts if len(part.triangles)]


def _capped(piece: Piece, plane: Plane) -> list[Piece]:
    """The section of what a piece bounds, in its own colour: values inside are not known."""
    filled = cap(plane, piece.positions, piece.triangles)
    if filled is None:
        return []
    points, faces = filled
    if len(points):  # sections of small bodies lie in front: what a hollow one contains stays in sight
        points = points - _RECESS * float(np.ptp(points, axis=0).max()) * plane.normal
    color = piece.color if piece.values is None else NEUTRAL
    return [
        dataclasses.replace(
            piece, positions=points, triangles=faces, color=color, values=None, outlined=False
        )
    ]


def _cut(piece: Piece, plane: Plane) -> Piece:
    numbers = np.zeros(len(piece.positions)) if piece.values is None else piece.values
    data, triangles = cut_triangles(plane, np.column_stack([piece.positions, numbers]), piece.triangles)
    return dataclasses.replace(
        piece,
        positions=data[:, :3],
        triangles=triangles,
        values=None if piece.values is None else data[:, 3],
    )


def _tetrahedra(body: Any) -> np.ndarray | None:
    """Of solids, elements of higher order by their corners; None of all else."""
    mesh = getattr(body, "mesh", None)
    tets = getattr(mesh, "tets", None)
    if tets is not None:
        return np.asarray(tets)
    elements = getattr(mesh, "elements", None)
    if elements is None or hasattr(mesh, "filling"):  # cells of a lattice reach beyond the surface in them
        return None
    if elements.shape[1] in (4, 10):
        return np.asarray(elements[:, :4])
    return np.asarray(elements[:, _HEXAHEDRON].reshape(-1, 4))


#: Six tetrahedra around the diagonal of a hexahedron, corners in the order of VTK.
_HEXAHEDRON = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])

CREASE_ANGLE = 0.65  # [rad]


def crease_angle(piece: Piece) -> float:
    """Edges sharper than this are drawn as edges [rad]."""
    return math.pi if piece.smooth else CREASE_ANGLE
