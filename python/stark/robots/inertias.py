"""Inertias of shapes of a given density, for files that leave those of links to their reader."""

from __future__ import annotations

import math

import numpy as np

from stark import _core
from stark.mesh import oriented
from stark.robots.description import Geometry, Inertia
from stark.robots.meshes import mesh_of


def inertia_of(shape: Geometry, density: float, source: str, title: str) -> Inertia | None:
    """Of a solid shape of a ``density`` [kg/m^3], in the frame of its link; None for meshes that are open.
    InvalidArgument as of ``mesh_of``."""
    if shape.kind == "mesh":
        surface = mesh_of(shape, source, title)
        if not surface.is_closed:
            return None
        surface = oriented(surface)
        found = _core.compute_solid_mass_properties(surface.vertices, surface.triangles, density)
        return Inertia(float(found["mass"]), np.array(found["centre"]), np.array(found["inertia"]))
    mass, moments = _analytic(shape, density)
    return Inertia(mass, np.zeros(3), np.diag(moments)).moved(shape.position, shape.rotation)


def _analytic(shape: Geometry, density: float) -> tuple[float, tuple[float, float, float]]:
    """Mass [kg] and moments [kg m^2] about the centre of a box, sphere, cylinder or capsule, the last two
    about z."""
    if shape.kind == "box":
        a, b, c = shape.size
        mass = density * a * b * c
        return mass, (mass * (b * b + c * c) / 12, mass * (a * a + c * c) / 12, mass * (a * a + b * b) / 12)
    r = shape.size[0]
    ball = density * 4.0 / 3.0 * math.pi * r**3
    if shape.kind == "sphere":
        return ball, (0.4 * ball * r * r,) * 3
    length = shape.size[1]
    rod = density * math.pi * r * r * length
    across, along = rod * (3 * r * r + length * length) / 12, 0.5 * rod * r * r
    if shape.kind == "cylinder":
        return rod, (across, across, along)
    # Half spheres whose centres are half of the length away from that of the capsule.
    across += ball * (0.4 * r * r + 0.25 * length * length + 0.375 * length * r)
    return rod + ball, (across, across, along + 0.4 * ball * r * r)
