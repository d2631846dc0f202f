"""Plates that are at rest flat though their mesh is not: what is said of those that will spring open."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from stark.bodies.cloth import Cloth

_FLAT = 0.01  # depth over the longest side: of what counts as flat


def unfolding_warnings(bodies: Iterable[Any]) -> list[str]:
    """One for each cloth that bends as a plate, with a curved mesh and rest angles that are left flat."""
    return [
        f"cloth '{body.name}': its mesh is curved, but its plate is flat at rest and springs open; "
        f'write rest_angles="mesh" if it is at rest as meshed'
        for body in bodies
        if isinstance(body, Cloth) and _springs_open(body)
    ]


def _springs_open(cloth: Cloth) -> bool:
    if cloth._shared.get("rest_angles") != "flat" or "natural_curvature" in cloth._rest_values:
        return False
    if not np.any(np.asarray(getattr(cloth.material, "flexural_rigidity", 0.0)) > 0.0):
        return False
    from_middle = cloth.mesh.vertices - cloth.mesh.vertices.mean(axis=0)
    axes = np.linalg.svd(from_middle, full_matrices=False)[2]
    sides = np.ptp(from_middle @ axes.T, axis=0)
    return bool(sides.min() > _FLAT * sides.max())
