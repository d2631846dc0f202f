"""Laws of published fits that stark.materials has not."""

from __future__ import annotations

import math
from typing import Any

import stark.symbolic as sym
from stark.formulas import DeformationGradient, material, parameter


@material
def carroll(
    F: DeformationGradient,
    a: float = parameter(unit="Pa", above=0.0),
    b: float = parameter(unit="Pa", min=0.0),
    c: float = parameter(unit="Pa", min=0.0),
    bulk_modulus: float = parameter(unit="Pa", above=0.0),
) -> Any:
    """Rubber up to rupture: a (I1 - 3) + b (I1^4 - 81) + c (sqrt(I2) - sqrt(3)) + K/2 (J - 1)^2 per rest
    volume [J/m^3], of the isochoric invariants (M. M. Carroll, J. Elasticity 103 (2011) 173-187).

    Small strains: shear modulus 2 a + 216 b + c / sqrt(3). b makes it stiffen near rupture, c softens it
    first."""
    J = sym.determinant(F)
    C = (F.T @ F) * J ** (-2.0 / 3.0)
    I1, I2, _ = sym.invariants(C)
    rubber = a * (I1 - 3.0) + b * (I1**4 - 81.0) + c * (sym.sqrt(I2) - math.sqrt(3.0))
    return rubber + 0.5 * bulk_modulus * (J - 1.0) ** 2


@material(isotropic=False)
def dispersed_fibres(
    F: DeformationGradient,
    shear_modulus: float = parameter(unit="Pa", above=0.0),
    fibre_ratio: float = parameter(unit="1", min=0.0),
    fibre_exponent: float = parameter(unit="1", above=0.0),
    dispersion: float = parameter(unit="1", min=0.0, max=1.0 / 3.0),
    angle: float = parameter(unit="rad", min=0.0, max=0.5 * math.pi),
    bulk_modulus: float = parameter(unit="Pa", above=0.0),
) -> Any:
    """Soft tissue: a Neo-Hookean matrix and two families of dispersed fibres, in the plane of the first two
    axes of the material at ``angle`` to both sides of the first (Gasser, Ogden, Holzapfel, J. R. Soc.
    Interface 3 (2006) 15-35).

    Energy per rest volume [J/m^3] mu/2 (I1 - 3) + mu k1 / (2 k2) sum (exp(k2 E^2) - 1) + K/2 (J - 1)^2 with
    E = <kappa I1 + (1 - 3 kappa) I4 - 1> of the isochoric invariants: mu is ``shear_modulus``, k1
    ``fibre_ratio``, k2 ``fibre_exponent``, kappa ``dispersion``: 0 for parallel fibres, 1/3 for fibres in
    all directions. Fibres do not push."""
    J = sym.determinant(F)
    C = (F.T @ F) * J ** (-2.0 / 3.0)
    I1 = sym.trace(C)
    cosine, sine = sym.cos(angle), sym.sin(angle)
    psi = 0.5 * shear_modulus * (I1 - 3.0) + 0.5 * bulk_modulus * (J - 1.0) ** 2
    for side in (1.0, -1.0):
        I4 = cosine**2 * C[0, 0] + sine**2 * C[1, 1] + 2.0 * side * cosine * sine * C[0, 1]
        stretched = sym.maximum(dispersion * I1 + (1.0 - 3.0 * dispersion) * I4 - 1.0, 0.0)
        fibres = sym.exp(fibre_exponent * stretched**2) - 1.0
        psi = psi + 0.5 * shear_modulus * fibre_ratio / fibre_exponent * fibres
    return psi
