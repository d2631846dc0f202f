"""What is doubtful about attachments: vertices of a finer border or face that nothing would hold, pairs
that are there twice."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import find_closest_triangles
from stark.bodies import Body
from stark.body_kinds import has_points, row_of
from stark.mesh import TriangleMesh
from stark.selections import Points

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

_NEAR = 0.2  # distance from a seam edge over its length, within which a vertex lies along it
_INNER = 0.02  # part of a seam edge at its ends, where vertices coincide with those of the other border
_FINER = 1.5  # vertices of the border along a seam, over attached points, above which it gapes
_FINER_FACE = 2.0  # mean area of glued faces, over that of the faces below them, above which stresses jump


def gaping_seam(points: Points, carrier: Body | None) -> str:
    """What is wrong with a seam whose points are sewn to a finer border; empty if it is none."""
    body = points.body
    if carrier is None or body is None or carrier is body or points._kind != "vertices":
        return ""
    if not all(has_points(side) and row_of(side).has_triangles for side in (body, carrier)):
        return ""
    attached = np.unique(points._columns["vertices"])
    edges = _border(body.triangles)  # type: ignore[attr-defined]
    edges = edges[np.isin(edges, attached).all(axis=1)]
    if len(edges) == 0:
        return ""
    x, y = (side._scene._core.initial_positions(side._index) for side in (body, carrier))
    border = y[np.unique(_border(carrier.triangles))]
    along, inner, ends = np.zeros(len(border), bool), np.zeros(len(border), bool), set()
    for a, b in edges:
        share = _share(border, x[a], x[b])
        along |= (share >= -_INNER) & (share <= 1.0 + _INNER)
        inside = (share > _INNER) & (share < 1.0 - _INNER)
        inner |= inside
        if inside.any():
            ends |= {int(a), int(b)}
    if not ends or along.sum() <= _FINER * len(ends):
        return ""
    return (
        f"{inner.sum()} vertices of the border of '{carrier.name}' lie between the {len(ends)} points of "
        f"'{body.name}' that are attached there: nothing holds them, so the seam gapes under load; attach "
        f"the finer border to the coarser one (exchange the sides)"
    )


def glued_to_finer(points: Points, carrier: Body | None) -> str:
    """What is wrong with a face of a solid that is glued to finer faces of another; empty if it is none."""
    body = points.body
    if carrier is None or body is None or carrier is body or points._kind != "vertices":
        return ""
    if any(not has_points(side) or row_of(side).is_sheet for side in (body, carrier)):
        return ""
    if not (row_of(body).has_triangles and row_of(carrier).has_triangles):
        return ""
    glued = body.triangles  # type: ignore[attr-defined]
    glued = glued[np.isin(glued, np.unique(points._columns["vertices"])).all(axis=1)]
    if len(glued) == 0:
        return ""
    x, y = (side._scene._core.initial_positions(side._index) for side in (body, carrier))
    below = np.ascontiguousarray(carrier.triangles, dtype=np.int32)
    chosen, _ = find_closest_triangles(np.ascontiguousarray(x[glued].mean(axis=1)), y, below)
    ratio = _mean_area(x, glued) / max(_mean_area(y, below[chosen]), np.finfo(float).tiny)
    if ratio <= _FINER_FACE:
        return ""
    return (
        f"faces of '{body.name}' that are glued have {ratio:.2g} times the area of those of '{carrier.name}' "
        f"below them: nothing holds the vertices between, so the interface is too soft and stresses jump "
        f"from vertex to vertex; attach the finer face to the coarser one (exchange the sides)"
    )


def repeated_points(given: Mapping[str, Any], count: int) -> str:
    """What is wrong with pairs that are there twice and may break; empty if none is."""
    if not given["break_force"] < np.inf:
        return ""
    parts = [given["a"], *given["b"], {"patches": given.get("patches", 0)}]
    columns = [np.asarray(value) for part in parts for value in part.values()]
    rows = [c.reshape(count, -1) for c in columns if c.ndim > 0 and len(c) == count]
    _, first, counts = np.unique(np.concatenate(rows, axis=1), axis=0, return_index=True, return_counts=True)
    if (counts == 1).all():
        return ""
    k = int(first[np.argmax(counts > 1)])
    return (
        f"pair {k} is there {counts.max()} times, and {count - len(first)} of {count} pairs repeat others: "
        f"they share the force of their place, so that it takes a multiple of break_force to break them; "
        f"give each pair once, such as by np.unique(indices)"
    )


def _mean_area(places: Floats, triangles: Integers) -> float:
    return TriangleMesh(places, triangles).area / len(triangles)


def _border(triangles: Integers) -> Integers:
    """Edges of one triangle (n, 2)."""
    sides = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    edges, counts = np.unique(sides, axis=0, return_counts=True)
    border: Integers = edges[counts == 1]
    return border


def _share(places: Floats, start: Floats, end: Floats) -> Floats:
    """Where places are along an edge, over its length; infinite for those that are not near it."""
    way = end - start
    squared = float(way @ way)
    if squared == 0.0:
        return np.full(len(places), np.inf)
    share = (places - start) @ way / squared
    off = np.linalg.norm(places - start - share[:, None] * way, axis=1)
    return np.where(off < _NEAR * np.sqrt(squared), share, np.inf)
