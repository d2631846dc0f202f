"""The energies of loads, written as users write theirs."""

from __future__ import annotations

from stark.formulas import Frame, Point, Triangle, Vec3, energy, parameter
from stark.symbolic import Scalar, cross, dot


@energy(translation_invariant=False)  # a closed surface is, its triangles are not
def pressure(
    t: Triangle,
    pressure: float = parameter(unit="Pa", doc="pressure inside over that outside"),
    origin: Vec3 = parameter(unit="m", doc="any point near the body, the same for all triangles"),
) -> Scalar:
    """Pressure inside a closed surface: minus pressure times enclosed volume. [theory eq. 15a]"""
    a, b, c = t[0].x - origin, t[1].x - origin, t[2].x - origin
    return -pressure / 6.0 * dot(a, cross(b, c))


@energy
def force(p: Point, force: Vec3 = parameter(unit="N", doc="force on each point")) -> Scalar:
    """A force that keeps its direction."""
    return -dot(force, p.x)


@energy
def torque(
    f: Frame,
    torque: Vec3 = parameter(unit="N m", doc="torque on the body"),
) -> Scalar:
    """A torque that keeps its direction, as minus the work that it does in a step: exact
    for turns about its axis up to 1 rad."""
    return -dot(torque, f.turn)
