"""Roller supports: points that stay in a plane and move freely in it, as in planes of symmetry."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.bodies import Cloth, Solid
from stark.formulas import Point, Vec3, energy, parameter
from stark.selections import Points
from stark.symbolic import Scalar, dot

Floats = NDArray[np.float64]

#: Of a support over that of a cell of the body: what gives way is a thousandth of what cells do.
_STIFF = 1e3
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


def unit_normal(normal: str | ArrayLike, owner: str) -> Floats:
    """(3,) of "x", "y", "z" or a vector; InvalidArgument for anything else."""
    try:
        vector = np.asarray(_AXES[normal] if isinstance(normal, str) else normal, dtype=np.float64)
    except (KeyError, TypeError, ValueError):
        vector = np.zeros(0)
    length = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    if not 0.0 < length < np.inf:
        raise InvalidArgument(f"{owner}: normal = {normal!r}: must be 'x', 'y', 'z' or a vector (3,), not 0")
    return vector / length


def check_points(points: Any, owner: str) -> Points:
    """Those of a cloth or a solid, or InvalidArgument."""
    if not isinstance(points, Points) or points.is_direction:
        raise InvalidArgument(
            f"{owner}: points = {points!r}: must be points of a body, such as solid.vertices[mask]"
        )
    return points


def stiffness_of(points: Points, owner: str) -> float:
    """[N/m] of the support of a point: a thousand times that of a cell of its body."""
    body: Any = points.body
    modulus = _modulus(getattr(body, "material", None))
    if not isinstance(body, (Cloth, Solid)) or modulus is None:
        raise InvalidArgument(
            f"{owner}: {body!r} has no Young's modulus that says how stiff the support has to be; give "
            f"stiffness= [N/m] of each point, a thousand times that of what it holds"
        )
    size = body.material.thickness if isinstance(body, Cloth) else _cell_size(body)
    return _STIFF * float(np.max(modulus)) * float(size)


def _modulus(material: Any) -> Any:
    """Young's modulus [Pa], 9 K G/(3 K + G) also of a bulk and a shear modulus; None where there is none."""
    if all(hasattr(material, name) for name in ("shear_modulus", "bulk_modulus")):
        G, K = np.asarray(material.shear_modulus), np.asarray(material.bulk_modulus)
        return 9.0 * K * G / (3.0 * K + G)
    return getattr(material, "youngs_modulus", None)


def _cell_size(solid: Solid) -> float:
    """[m]: of a cube that is as large as a cell is in the mean."""
    vertices = solid.mesh.vertices
    extent = np.ptp(vertices, axis=0)
    return float(np.cbrt(np.prod(extent) / len(vertices)))
