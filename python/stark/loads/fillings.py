"""What closed surfaces are filled with, as functions of the volume inside. [theory eq. 15i]"""

from __future__ import annotations

from typing import Any

from stark.formulas import Triangle, Vec3, energy, parameter
from stark.symbolic import Scalar, cross, dot, log, pow, total, where


def _volume(t: Triangle, origin: Vec3, share: Any) -> Scalar:
    a, b, c = t[0].x - origin, t[1].x - origin, t[2].x - origin
    volume: Scalar = total(share / 6.0 * dot(a, cross(b, c)), "volume")
    return volume


@energy(translation_invariant=False)  # a closed surface is, its triangles are not
def gas(
    t: Triangle,
    amount: float = parameter(1.0, min=0.0, doc="gas inside, over that at time 0"),
    pressure_at_start: float = parameter(unit="Pa", above=0.0, doc="absolute, inside at time 0"),
    volume_at_start: float = parameter(unit="m^3", above=0.0, doc="inside at time 0"),
    outside: float = parameter(unit="Pa", min=0.0, doc="absolute pressure outside"),
    origin: Vec3 = parameter(unit="m", doc="any point near the body, the same for all triangles"),
    share: float = parameter(1.0, doc="what a triple counts in the volume inside"),
) -> Scalar:
    """A gas of constant temperature: its absolute pressure times its volume is constant."""
    volume = _volume(t, origin, share)
    product = amount * pressure_at_start * volume_at_start
    return outside * (volume - volume_at_start) - product * log(volume / volume_at_start)


@energy(translation_invariant=False)
def adiabatic_gas(
    t: Triangle,
    amount: float = parameter(1.0, min=0.0, doc="gas inside, over that at time 0"),
    pressure_at_start: float = parameter(unit="Pa", above=0.0, doc="absolute, inside at time 0"),
    volume_at_start: float = parameter(unit="m^3", above=0.0, doc="inside at time 0"),
    exponent: float = parameter(1.4, above=1.0, doc="ratio of the heat capacities"),
    outside: float = parameter(unit="Pa", min=0.0, doc="absolute pressure outside"),
    origin: Vec3 = parameter(unit="m", doc="any point near the body, the same for all triangles"),
    share: float = parameter(1.0, doc="what a triple counts in the volume inside"),
) -> Scalar:
    """A gas that exchanges no heat: p V^exponent is constant."""
    volume = _volume(t, origin, share)
    at_start = pressure_at_start * volume_at_start / (exponent - 1.0)
    inner = amount * at_start * pow(amount * volume_at_start / volume, exponent - 1.0)
    return outside * (volume - volume_at_start) + inner - at_start


@energy(translation_invariant=False)
def liquid(
    t: Triangle,
    filling: float = parameter(unit="m^3", above=0.0, doc="volume of the liquid at the pressure outside"),
    bulk_modulus: float = parameter(unit="Pa", above=0.0, doc="of the liquid"),
    outside: float = parameter(unit="Pa", min=0.0, doc="absolute pressure outside"),
    origin: Vec3 = parameter(unit="m", doc="any point near the body, the same for all triangles"),
    share: float = parameter(1.0, doc="what a triple counts in the volume inside"),
) -> Scalar:
    """A liquid: its pressure over that outside is bulk_modulus (filling - V) / filling. Below an absolute
    pressure of zero it parts, and bubbles of vapour fill the rest."""
    volume = _volume(t, origin, share)
    excess = volume / filling - 1.0
    parting = outside / bulk_modulus
    pressed = 0.5 * bulk_modulus * filling * excess * excess
    parted = outside * filling * (excess - 0.5 * parting)
    stored: Scalar = where(excess < parting, pressed, parted)
    return stored
