"""Tensors in the elements of bodies, and their means at vertices: what fields of pictures are made of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stark.body_kinds import row_of

from .._core import InvalidArgument
from ..arguments import given_choice, shown_value
from .choosing import matching
from .deformation import Deformation, at_body, of_body
from .fields import body_stress


class _Kind(NamedTuple):
    compute: Callable[[Any], tuple[Deformation, np.ndarray]]
    has_means: bool  #: whether neighbours have it in the same axes


def _gradient(body: Any) -> tuple[Deformation, np.ndarray]:
    deformation = of_body(body, body._shared["material"]._fields.get("warp_direction"))
    return deformation, deformation.gradients


_KINDS = {"stress": _Kind(body_stress, True), "deformation_gradient": _Kind(_gradient, False)}


def tensor_values(sim: Any, name: str, bodies: Any = None, *, at: str = "vertices") -> dict[str, np.ndarray]:
    """Tensors of the cloths and solids of a simulation as they are now, by name of body, in the axes of the
    world. ``bodies`` are the only ones to look at, by handle, name or pattern.

    - "stress" [Pa]: Cauchy stress, (n, 3, 3) at vertices, the mean over the elements there weighted by their
      volumes; ``at="elements"``: (m, k, 3, 3), of each element at its k nodes, k = 1 where it is constant;
      nodes of cut cells of a lattice may be beyond its surface, where only its polynomials are.
    - "deformation_gradient" [1]: (m, k, 3, d) of elements alone; d = 3 of solids, 2 of cloth, whose first
      axis at rest is the first edge of each triangle, or its warp direction.

    What counts as stress, and errors: as in ``field_values``."""
    if not isinstance(name, str) or name not in _KINDS:
        raise InvalidArgument(f"tensor {shown_value(name)} is unknown: must be one of {', '.join(_KINDS)}")
    kind, at = _KINDS[name], given_choice(at, ("vertices", "elements"), "tensor_values: at")
    if at == "vertices" and not kind.has_means:
        raise InvalidArgument(f"tensor '{name}': has no values at vertices: must be at='elements'")
    every = list(sim.bodies)
    indices = range(len(every)) if bodies is None else matching(bodies, [b.name for b in every], "bodies")
    found = {}
    for body in (every[i] for i in indices):
        row = row_of(body)
        if row.strains and row.has_triangles:
            if at == "elements":
                found[body.name] = kind.compute(body)[1]
            else:
                found[body.name] = at_body(body, *body_stress(body, of_material=True))
    return found
