"""Cloths and solids of several parts that touch at vertices of their own: what is said of those that come
apart there."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.bodies.cloth import Cloth
from stark.bodies.solid import Solid
from stark.mesh import EmbeddedMesh
from stark.mesh.cleaning import connected
from stark.selections import Points

Ints = NDArray[np.int64]

_SAME = 1e-6  # distance over the longest side of the mesh: of files with six digits
_FEWEST = 3  # vertices; fewer are parts that meet at a corner or an edge, as hinges do


def unjoined_warnings(
    bodies: Iterable[Any],
    energies: Iterable[Any],
    attachments: Iterable[Any],
    joints: Iterable[Any],
    layers: Iterable[Any],
) -> list[str]:
    """One for each cloth or solid with parts that meet at places where each has vertices of its own, and
    that nothing else may join."""
    found = []
    for body in bodies:
        if not isinstance(body, (Cloth, Solid)) or isinstance(body.mesh, EmbeddedMesh):
            continue
        count, part = _vertices_at_others(body)
        if (
            count >= _FEWEST
            and not any(layer._body == body for layer in layers)
            and not any(attachment.points.body == body for attachment in attachments)
            and not any(joint._given[side].get("body") == body._index for joint in joints for side in "ab")
            and not any(_joins(energy._binding.columns, body, part) for energy in energies)
        ):
            found.append(
                f"{body.kind} '{body.name}': {count} of its vertices lie at the places of vertices of "
                f"another part of its mesh, and nothing joins the parts: they come apart; unite such "
                f"vertices by stark.mesh.merged(mesh, tolerance), or attach the parts"
            )
    return found


def _vertices_at_others(body: Cloth | Solid) -> tuple[int, Ints]:
    """How many vertices that are not pinned lie at the place of an earlier one of another part of the mesh,
    and the part of each vertex, empty if there are none."""
    vertices, none = body.mesh.vertices, np.zeros(0, dtype=np.int64)
    grid = _SAME * float(np.ptp(vertices, axis=0).max())
    if not grid > 0.0:
        return 0, none
    # Numbers of cells, mixed into one; few vertices lie on the borders of a grid of such an origin.
    cells = np.floor(vertices / grid + (0.414, 0.732, 0.236)).astype(np.int64)
    keys = cells @ np.array([0x1F123BB5, 0x5F356495, 0x3C6EF372A5], dtype=np.int64)
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    earlier = first[which.reshape(-1)]
    later = np.flatnonzero(earlier != np.arange(len(vertices)))
    later = later[~np.isin(later, body.pins)]
    if not len(later):
        return 0, none
    part = connected(len(vertices), body.triangles if isinstance(body, Cloth) else body._all_elements())
    near = np.abs(vertices[later] - vertices[earlier[later]]).max(axis=1) <= 2.0 * grid
    return int((near & (part[later] != part[earlier[later]])).sum()), part


def _joins(columns: Iterable[Any], body: Cloth | Solid, part: Ints) -> bool:
    """Whether elements of these points may hold parts of the body together: those within one part do not."""
    columns = list(columns)
    if len(columns) < 2 or not any(body in column.bodies for column in columns):
        return False
    if any(not isinstance(c, Points) or c.body != body or "vertices" not in c._columns for c in columns):
        return True
    labels = [part[column._columns["vertices"]] for column in columns]
    return any(bool((label != labels[0]).any()) for label in labels[1:])
