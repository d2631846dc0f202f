"""Closed surfaces of bodies: which triangles, whether they are closed, the volume inside."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.bodies import Body
from stark.body_kinds import has_points, row_of
from stark.handle import BodyHandle
from stark.loads.element_faces import whole_faces
from stark.mesh import Indices
from stark.selections import Stencils, stencils, vertex_points


class ClosedSurface(NamedTuple):
    """Triples of points of outward triangles, and what each counts in the volume inside."""

    triples: Stencils
    shares: NDArray[np.float64] | None
    """(n,); None: 1 for all."""
    centre: NDArray[np.float64]
    """(3,) [m]."""
    volume: float
    """Inside at time 0 [m^3]."""


def closed_surface(surface: Any, owner: str) -> ClosedSurface:
    """The faces that are meant, turned so that they enclose a positive volume at time 0; of elements of 8
    nodes and more their faces instead of the triangles that these are cut into. InvalidArgument unless they
    are closed."""
    has_faces = isinstance(surface, Body) and has_points(surface) and row_of(surface).has_triangles
    faces = surface.faces if has_faces else surface
    columns = faces.columns if isinstance(faces, Stencils) and faces.point_count == 3 else ()
    body = columns[0].body if columns else None
    if body is None or any(
        "vertices" not in column._columns or column.body is not body for column in columns
    ):
        has_several = len({id(of) for column in columns for of in column.bodies}) > 1
        raise InvalidArgument(
            f"{owner} on {surface!r}: must be a cloth or a solid with a closed surface, or some of its faces"
            + (
                "; two surfaces with one pressure are parts of one body, whose mesh is "
                "stark.mesh.joined([first, second])"
                if has_several
                else ""
            )
        )
    triangles = np.stack([column._columns["vertices"] for column in columns], axis=1)
    _check_closed(body, triangles, owner)
    positions = vertex_points(body, np.arange(len(body.mesh.vertices), dtype=np.int32)).positions
    centre = positions[triangles].mean(axis=(0, 1))
    outward = enclosed_volume(positions - centre, triangles) >= 0.0
    rows, shares = whole_faces(body.mesh, triangles) or (triangles, None)
    if rows is not triangles:
        faces = stencils(body, rows, "triples of nodes")
    if not outward:
        faces = Stencils([faces.columns[k] for k in (0, 2, 1)], faces._noun)
    return ClosedSurface(faces, shares, centre, abs(enclosed_volume(positions - centre, rows, shares)))


def enclosed_volume(
    positions: NDArray[np.float64], triangles: Indices, shares: NDArray[np.float64] | None = None
) -> float:
    """Volume inside a closed surface of outward triangles, which count by their shares [m^3]."""
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    return float(np.einsum("ni,ni->", a if shares is None else a * shares[:, None], np.cross(b, c)) / 6.0)


def _check_closed(body: BodyHandle, triangles: Indices, owner: str) -> None:
    """Every directed edge has to occur once, and once the other way round."""
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    directed, counts = np.unique(edges, axis=0, return_counts=True)
    known = set(map(tuple, directed.tolist()))
    wrong = [
        (i, j) for (i, j), n in zip(directed.tolist(), counts, strict=True) if n > 1 or (j, i) not in known
    ]
    if wrong:
        raise InvalidArgument(
            f"{owner} on '{body.name}': its surface is not closed at {len(wrong)} edges, first between the "
            f"vertices {wrong[0][0]} and {wrong[0][1]}: every edge must have two triangles of the same "
            f"orientation; close the mesh, or repair it with stark.mesh.merged and stark.mesh.oriented; for "
            f"a part of a surface, or an open sheet, take scene.add_face_pressure"
        )
