"""Metal plasticity of solids at finite strain, as an incremental potential.

Multiplicative split F = Fe Fp with isotropic elasticity in logarithmic strains (Hencky), the yield criterion
of von Mises and linear isotropic hardening; radial return with the exponential map (Simo 1992, Comput.
Methods Appl. Mech. Engrg. 99, 61-112; Ortiz and Stainier 1999, ibid. 171, 419-444). The energy of a step is
the least over the plastic strain of the step, in closed form, so that stresses and tangents are exact
derivatives [theory eq. 10d, 10e]."""

from __future__ import annotations

from typing import Any

import numpy as np

from stark.formulas.internal import internal
from stark.formulas.material import DeformationGradient, material
from stark.formulas.parameters import parameter
from stark.symbolic.functions import log, maximum, sqrt, where
from stark.symbolic.linear_algebra import determinant, inverse, squared_norm, trace
from stark.symbolic.signature import Mat3
from stark.symbolic.tensor import identity

#: Powers of Z in the series of the logarithm, up to Z^13.
_LOGARITHM_TERMS = 7
#: Powers in the series of the exponential of a quarter of the strain.
_EXPONENTIAL_TERMS = 8


def _deviatoric_strain(b: Any) -> Any:
    """Deviator of the logarithmic strain log(b)/2 of a left Cauchy-Green tensor b with determinant 1.

    log(b)/2 = atanh(Z) = Z + Z^3/3 + ..., Z = (b - 1)(b + 1)^-1: smooth where stretches coincide. The error
    is below 1e-9 for principal strains up to 0.3."""
    one = identity(3)
    Z = (b - one) @ inverse(b + one)
    square = Z @ Z
    series = one * (1.0 / (2 * _LOGARITHM_TERMS - 1))
    for k in reversed(range(_LOGARITHM_TERMS - 1)):
        series = square @ series + one * (1.0 / (2 * k + 1))
    strain = Z @ series
    return strain - one * (trace(strain) / 3.0)


def _exponential(A: Any) -> Any:
    """exp(A) by series of A/4, squared twice: error below 1e-9 for eigenvalues up to 1."""
    one = identity(3)
    quarter = A * 0.25
    result = one + quarter * (1.0 / _EXPONENTIAL_TERMS)
    for k in reversed(range(1, _EXPONENTIAL_TERMS)):
        result = one + (quarter @ result) * (1.0 / k)
    half = result @ result
    return half @ half


@material
def j2_plasticity(
    F: DeformationGradient,
    shear_modulus: float = parameter(unit="Pa", above=0.0),
    bulk_modulus: float = parameter(unit="Pa", above=0.0),
    yield_stress: float = parameter(unit="Pa", above=0.0),
    hardening_modulus: float = parameter(0.0, unit="Pa", min=0.0),
    plastic_metric: Mat3 = internal(np.eye(3), doc="inverse of Fp^T Fp, determinant 1"),
    plastic_strain: float = internal(0.0, doc="equivalent plastic strain, which never falls"),
) -> Any:
    """Metal that yields: energy of a step per rest volume [J/m^3].

    shear_modulus, bulk_modulus [Pa]: of the elastic part. yield_stress [Pa]: von Mises equivalent of the
    Kirchhoff stress at which it starts to yield. hardening_modulus [Pa]: growth of the yield stress with the
    equivalent plastic strain. Elastic isochoric strains must stay below 0.3, the step's trial strain among
    them."""
    J = determinant(F)
    b = (F @ plastic_metric @ F.T) * J ** (-2.0 / 3.0)
    trial = _deviatoric_strain(b)
    # Far below yielding any other equivalent strain does, and the root keeps its derivative.
    elastic_limit = yield_stress / (3.0 * shear_modulus)
    squared = squared_norm(trial) * (2.0 / 3.0)
    strain = sqrt(maximum(squared, (0.5 * elastic_limit) ** 2))
    resistance = yield_stress + hardening_modulus * plastic_strain
    excess = maximum(3.0 * shear_modulus * strain - resistance, 0.0)
    stiffness = 3.0 * shear_modulus + hardening_modulus
    volumetric = 0.5 * bulk_modulus * log(J) ** 2
    stored = 1.5 * shear_modulus * squared + 0.5 * hardening_modulus * plastic_strain**2
    psi = volumetric + stored - 0.5 * excess**2 / stiffness

    slip = excess / stiffness
    relaxed = _exponential(trial * (2.0 * (1.0 - slip / strain)))
    back = inverse(F)
    metric = (back @ relaxed @ back.T) * J ** (2.0 / 3.0)
    metric = metric * determinant(metric) ** (-1.0 / 3.0)
    flows = excess > 0.0
    kept = [[where(flows, metric[i, j], plastic_metric[i, j]) for j in range(3)] for i in range(3)]
    return psi, {"plastic_metric": type(metric)(kept), "plastic_strain": plastic_strain + slip}
