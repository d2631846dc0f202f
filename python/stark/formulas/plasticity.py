"""Metal plasticity of solids at finite strain, as an incremental potential.

Multiplicative split F = Fe Fp with isotropic elasticity in logarithmic strains (Hencky), the yield criterion
of von Mises and linear isotropic hardening; radial return with the exponential map (Simo 1992, Comput.
Methods Appl. Mech. Engrg. 99, 61-112; Ortiz and Stainier 1999, ibid. 171, 419-444). The energy of a step is
the least over the plastic strain of the step, in closed form, so that stresses and tangents are exact
derivatives [theory eq. 10d, 10e]. Kinematic hardening is a spring beside what yields (Haward and Thackray
1968, Proc. R. Soc. A 302, 453-472), of metals by Prager (1956), and the overstress that of Perzyna (1966,
Adv. Appl. Mech. 9, 243-377) [theory eq. 10j, 10k]."""

from __future__ import annotations

from typing import Any

import numpy as np

from stark.formulas.arguments import TimeStep
from stark.formulas.internal import internal
from stark.formulas.material import DeformationGradient, material
from stark.formulas.parameters import parameter
from stark.symbolic.functions import log, mark_stage, maximum, sqrt, where
from stark.symbolic.linear_algebra import determinant, inverse, squared_norm, trace
from stark.symbolic.signature import Mat3
from stark.symbolic.tensor import identity, vec

#: Powers of Z in the series of the logarithm, up to Z^13.
_LOGARITHM_TERMS = 7
#: Powers of Z^2 in that of the square of the logarithm, up to Z^16.
_SQUARE_TERMS = 8
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


def _equivalent_strain_squared(b: Any) -> Any:
    """2/3 |e|^2 of the deviatoric strain e above, in invariants of b - 1: derivatives cost a seventh of
    those of matrices [theory eq. 10p]. Smooth, and as accurate for small strains as for large ones."""
    A = b - identity(3)
    second = A[0, 0] * A[1, 1] + A[1, 1] * A[2, 2] + A[2, 2] * A[0, 0]
    second = second - A[0, 1] ** 2 - A[1, 2] ** 2 - A[0, 2] ** 2
    third = determinant(A)
    mark_stage(vec(second, third))
    # det b = 1 leaves the trace of A, -second - third, which would have to be a small difference.
    scale = 1.0 / (8.0 - 2.0 * second - 3.0 * third)
    e1, e2, e3 = -third * scale, (2.0 * second + 3.0 * third) * scale, third * scale  # of Z
    E1, E2, E3 = e1**2 - 2.0 * e2, e2**2 - 2.0 * e1 * e3, e3**2  # of Z^2
    powers = [3.0, E1, E1 * E1 - 2.0 * E2]  # traces of Z^(2m) by Newton's identities
    while len(powers) <= _SQUARE_TERMS:
        powers.append(E1 * powers[-1] - E2 * powers[-2] + E3 * powers[-3])
    total: Any = 0.0
    for m in reversed(range(1, _SQUARE_TERMS + 1)):
        odd = [2 * k + 1 for k in range(m)]
        total = total + powers[m] * sum(1.0 / (k * (2 * m - k)) for k in odd)
    return total * (2.0 / 3.0)


def _exponential(A: Any) -> Any:
    """exp(A) by series of A/4, squared twice: error below 1e-9 for eigenvalues up to 1."""
    one = identity(3)
    quarter = A * 0.25
    result = one + quarter * (1.0 / _EXPONENTIAL_TERMS)
    for k in reversed(range(1, _EXPONENTIAL_TERMS)):
        result = one + (quarter @ result) * (1.0 / k)
    half = result @ result
    return half @ half


def _step(
    F: Any, mu: Any, bulk: Any, resistance: Any, modulus: Any, kinematic: Any, G: Any, p: Any
) -> tuple[Any, dict[str, Any]]:
    """Energy of a step and updates. resistance [Pa]: yield stress at the start of the step; modulus [Pa]: its
    growth with the plastic strain of the step; kinematic [Pa]: of the back stress."""
    J = mark_stage(determinant(F))
    b = (F @ G @ F.T) * J ** (-2.0 / 3.0)
    b = type(b)([[b[min(i, j), max(i, j)] for j in range(3)] for i in range(3)])  # symmetric to the last bit
    trial = _deviatoric_strain(b)
    # A spring beside the part r of the stiffness that yields is kinematic hardening [theory eq. 10j].
    r = 3.0 * mu / (3.0 * mu + kinematic)
    # Far below yielding any other equivalent strain does, and the root keeps its derivative.
    elastic_limit = resistance / (3.0 * mu)
    squared = _equivalent_strain_squared(b)
    strain = sqrt(maximum(squared, (0.5 * elastic_limit) ** 2))
    excess = maximum(3.0 * mu * strain - resistance, 0.0)
    stiffness = 3.0 * mu + r * modulus
    volumetric = 0.5 * bulk * log(J) ** 2
    back = 0.5 * mu * (1.0 - r) * (squared_norm(F) * J ** (-2.0 / 3.0) - 3.0)
    psi = volumetric + back + r * (1.5 * mu * squared - 0.5 * excess**2 / stiffness)

    slip = excess / stiffness
    relaxed = _exponential(trial * (2.0 * (1.0 - slip / strain)))
    inverted = inverse(F)
    metric = (inverted @ relaxed @ inverted.T) * J ** (2.0 / 3.0)
    metric = metric * determinant(metric) ** (-1.0 / 3.0)
    flows = excess > 0.0
    kept = [[where(flows, metric[i, j], G[i, j]) for j in range(3)] for i in range(3)]
    return psi, {"plastic_metric": type(metric)(kept), "plastic_strain": p + r * slip}


@material
def j2_plasticity(
    F: DeformationGradient,
    shear_modulus: float = parameter(unit="Pa", above=0.0),
    bulk_modulus: float = parameter(unit="Pa", above=0.0),
    yield_stress: float = parameter(unit="Pa", above=0.0),
    hardening_modulus: float = parameter(0.0, unit="Pa", min=0.0),
    kinematic_modulus: float = parameter(0.0, unit="Pa", min=0.0),
    plastic_metric: Mat3 = internal(np.eye(3), doc="inverse of Fp^T Fp, determinant 1"),
    plastic_strain: float = internal(0.0, doc="equivalent plastic strain, which never falls"),
) -> Any:
    """Metal that yields: energy of a step per rest volume [J/m^3].

    shear_modulus, bulk_modulus [Pa]: of the elastic part. yield_stress [Pa]: von Mises equivalent of the
    Kirchhoff stress at which it starts to yield. hardening_modulus [Pa]: growth of the yield stress with the
    equivalent plastic strain. kinematic_modulus [Pa]: of the back stress, by which the metal yields earlier
    on the way back (Bauschinger's effect). Elastic isochoric strains must stay below 0.3, the step's trial
    strain among them."""
    resistance = yield_stress + hardening_modulus * plastic_strain
    psi, updates = _step(
        F, shear_modulus, bulk_modulus, resistance, hardening_modulus, kinematic_modulus, plastic_metric,
        plastic_strain,
    )  # fmt: skip
    return psi + 0.5 * hardening_modulus * plastic_strain**2, updates


@material
def j2_viscoplasticity(
    F: DeformationGradient,
    h: TimeStep,
    shear_modulus: float = parameter(unit="Pa", above=0.0),
    bulk_modulus: float = parameter(unit="Pa", above=0.0),
    yield_stress: float = parameter(unit="Pa", above=0.0),
    viscosity: float = parameter(unit="Pa s", above=0.0),
    hardening_modulus: float = parameter(0.0, unit="Pa", min=0.0),
    kinematic_modulus: float = parameter(0.0, unit="Pa", min=0.0),
    plastic_metric: Mat3 = internal(np.eye(3), doc="inverse of Fp^T Fp, determinant 1"),
    plastic_strain: float = internal(0.0, doc="equivalent plastic strain, which never falls"),
) -> Any:
    """``j2_plasticity`` that flows at a rate, after Perzyna: energy of a step per rest volume [J/m^3].

    viscosity [Pa s]: stress above the yield stress over the rate of the equivalent plastic strain. The other
    parameters are those of ``j2_plasticity``."""
    resistance = yield_stress + hardening_modulus * plastic_strain
    psi, updates = _step(
        F, shear_modulus, bulk_modulus, resistance, hardening_modulus + viscosity / h, kinematic_modulus,
        plastic_metric, plastic_strain,
    )  # fmt: skip
    return psi + 0.5 * hardening_modulus * plastic_strain**2, updates
