"""The energies of loads, written as users write theirs."""

from __future__ import annotations

import stark


@stark.energy(translation_invariant=False)  # a closed surface is, its triangles are not
def pressure(
    t: stark.Triangle,
    pressure: float = stark.parameter(unit="Pa", doc="pressure inside over that outside"),
    origin: stark.Vec3 = stark.parameter(unit="m", doc="any point near the body, the same for all triangles"),
):
    """Pressure inside a closed surface: minus pressure times enclosed volume. [theory eq. 15a]"""
    a, b, c = t[0].x - origin, t[1].x - origin, t[2].x - origin
    return -pressure / 6.0 * stark.dot(a, stark.cross(b, c))


@stark.energy
def force(p: stark.Point, force: stark.Vec3 = stark.parameter(unit="N", doc="force on each point")):
    """A force that keeps its direction."""
    return -stark.dot(force, p.x)


@stark.energy
def torque(
    f: stark.Frame,
    h: stark.TimeStep,
    torque: stark.Vec3 = stark.parameter(unit="N m", doc="torque on the body"),
):
    """A torque that keeps its direction, as minus the work that it does in a step."""
    return -h * stark.dot(torque, f.angular_velocity)
