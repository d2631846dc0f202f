"""Cloths that start far beyond their strain limit: what is said of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.bodies.cloth import Cloth

Floats = NDArray[np.float64]

_FAR = 3.0  # times the limit: loads stretch cloth beyond it, too, which a later simulation may go on with
_MUCH = 0.05  # beyond the limit: what positions of few digits do to a small one


def strained_warnings(bodies: Iterable[Any]) -> list[str]:
    """One for each cloth whose ``initial_positions`` stretch it far beyond its strain limit. Its first steps
    take a great energy away, or throw it apart."""
    found = []
    for body in bodies:
        if not isinstance(body, Cloth) or body._rest_placement is None or body._rest_values:
            continue
        limit = float(getattr(body.material, "strain_limit", np.inf))
        if limit == np.inf or getattr(body.material, "strain_limit_law", "") != "green_strain":
            continue
        strain = _largest_strains(body)
        worst = int(strain.argmax())
        if strain[worst] > max(_FAR * limit, limit + _MUCH):
            found.append(
                f"cloth '{body.name}': its initial_positions stretch it to a Green strain of "
                f"{strain[worst]:.3g} (triangle {worst}), far beyond its strain_limit = {limit:g}, and the "
                f"first steps take the energy away or throw it apart: give positions with about the lengths "
                f"of the mesh, or a larger limit"
            )
    return found


def _largest_strains(cloth: Cloth) -> Floats:
    """Of each triangle, in any direction, from its shape in the mesh to that at time 0."""
    rest, now = (
        _metric(places, cloth.triangles)
        for places in (cloth.mesh.vertices, cloth._scene._core.initial_positions(cloth._index))
    )
    with np.errstate(over="ignore", invalid="ignore"):  # huge positions are refused after this, by name
        change = np.linalg.solve(rest, now)
        half_trace = 0.5 * np.trace(change, axis1=1, axis2=2)
        root = np.sqrt(np.maximum(half_trace**2 - np.linalg.det(change), 0.0))
        strains: Floats = 0.5 * (half_trace + root - 1.0)
    return strains


def _metric(places: Floats, triangles: NDArray[Any]) -> Floats:
    corners = places[triangles]
    sides = corners[:, 1:] - corners[:, :1]
    metric: Floats = np.einsum("tik,tjk->tij", sides, sides)
    return metric
