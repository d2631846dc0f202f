"""Metal plasticity of solids at finite strain, as an incremental potential.

Multiplicative split F = Fe Fp with isotropic elasticity in logarithmic strains (Hencky), the yield criterion
of von Mises and isotropic hardening; radial return with the exponential map (Simo 1992, Comput.
Methods Appl. Mech. Engrg. 99, 61-112; Ortiz and Stainier 1999, ibid. 171, 419-444). The energy of a step is
the least over the plastic strain of the step, in closed form, so that stresses and tangents are exact
derivatives [theory eq. 10d, 10e]. Kinematic hardening is a spring beside what yields (Haward and Thackray
1968, Proc. R. Soc. A 302, 453-472), of metals by Prager (1956), and the overstress that of Perzyna (1966,
Adv. Appl. Mech. 9, 243-377) [theory eq. 10j, 10k]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stark.formulas.arguments import TimeStep
from stark.formulas.internal import internal
from stark.formulas.material import DeformationGradient, material
from stark.formulas.parameters import parameter
from stark.symbolic.functions import exp, held, log, mark_stage, maximum, minimum, sqrt, where
from stark.symbolic.linear_algebra import determinant, inverse, squared_norm, trace
from stark.symbolic.signature import Mat3
from stark.symbolic.tensor import identity, vec

#: Powers of Z in the series of the logarithm, up to Z^13.
_LOGARITHM_TERMS = 7
#: Powers of Z^2 in that of the square of the logarithm, up to Z^16.
_SQUARE_TERMS = 8
#: Powers in the series of the exponential of a quarter of the strain.
_EXPONENTIAL_TERMS = 8
#: Steps of Halley's method for the slip of a hardening that saturates.
_SATURATION_STEPS = 2


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


@dataclass(frozen=True)
class _Hardening:
    """Growth of the yield stress Y with the plastic strain p [theory eq. 10q]."""

    first: Any  # of Y, at p = 0 [Pa]
    modulus: Any  # of the part that is linear [Pa]
    increase: Any  # of Y by the part that saturates, at last [Pa]
    rate: Any  # at which it does, 1 over a plastic strain

    def left(self, p: Any) -> Any:
        """What is left of the part that saturates [Pa]."""
        return self.increase * exp(-self.rate * p)

    def resistance(self, p: Any) -> Any:
        """Yield stress [Pa]."""
        return self.first + self.modulus * p + (self.increase - self.left(p))

    def stored(self, p: Any) -> Any:
        """Energy of hardening [J/m^3], the integral of what Y has grown by."""
        return 0.5 * self.modulus * p**2 + (self.increase * p - (self.increase - self.left(p)) / self.rate)


def _saturating(K: Any, slip: Any, left: Any, rate: Any) -> tuple[Any, Any]:
    """Slip of a step from that of the linear part, and the energy that saturation adds. left [Pa]: growth of
    the yield stress that is to come.

    The root x of K x = left (1 - exp(-rate (slip - x))), by which the slip is less, by Halley's method from
    the least of two bounds above: within 1e-8 of the slip where rate * left is below 10 K, of metals 0.1 K.
    These are steps of values alone: the energy is least in x, so that its derivatives need the first one of x
    only, which one step of Newton's method from the root has. Without saturation x and the energy are 0 to
    the last bit."""
    k, s, all_left, b = held(K), held(slip), held(left), held(rate)
    x = minimum(s * (b * all_left / (k + b * all_left)), all_left / k)
    for _ in range(_SATURATION_STEPS):
        rest = all_left * exp(-b * (s - x))
        value, slope = k * x - (all_left - rest), k + b * rest
        x = x - value * slope / (slope**2 - 0.5 * value * b**2 * rest)
    reached = slip - x
    rest = left * exp(-rate * reached)
    value, slope = K * x - (left - rest), held(K + rate * rest)
    energy = 0.5 * K * x**2 + (left * reached - (left - rest) / rate) - 0.5 * value**2 / slope
    return reached + value / slope, energy


def _step(
    F: Any, mu: Any, bulk: Any, hardening: _Hardening, viscous: Any, kinematic: Any, G: Any, p: Any
) -> tuple[Any, dict[str, Any]]:
    """Energy of a step and updates. viscous [Pa]: overstress over the plastic strain of the step; kinematic
    [Pa]: modulus of the back stress."""
    resistance = hardening.resistance(p)
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
    stiffness = 3.0 * mu + r * (hardening.modulus + viscous)
    slip, saturation = _saturating(stiffness, excess / stiffness, hardening.left(p), r * hardening.rate)
    volumetric = 0.5 * bulk * log(J) ** 2
    back = 0.5 * mu * (1.0 - r) * (squared_norm(F) * J ** (-2.0 / 3.0) - 3.0)
    psi = volumetric + back + r * (1.5 * mu * squared - 0.5 * excess**2 / stiffness + saturation)
    psi = psi + hardening.stored(p)

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
    saturation_increase: float = parameter(0.0, unit="Pa", min=0.0),
    saturation_rate: float = parameter(10.0, above=0.0),
    plastic_metric: Mat3 = internal(np.eye(3), doc="inverse of Fp^T Fp, determinant 1"),
    plastic_strain: float = internal(0.0, doc="equivalent plastic strain, which never falls"),
) -> Any:
    """Metal that yields: energy of a step per rest volume [J/m^3].

    shear_modulus, bulk_modulus [Pa]: of the elastic part. yield_stress [Pa]: von Mises equivalent of the
    Kirchhoff stress at which it starts to yield. hardening_modulus [Pa]: growth of the yield stress with the
    equivalent plastic strain. kinematic_modulus [Pa]: of the back stress, by which the metal yields earlier
    on the way back (Bauschinger's effect). saturation_increase [Pa], saturation_rate [1]: Q and b of a yield
    stress that grows by Q (1 - exp(-b p)) besides, with the plastic strain p (Voce 1948, J. Inst. Metals 74,
    537-562). Elastic isochoric strains must stay below 0.3, the step's trial strain among them."""
    hardening = _Hardening(yield_stress, hardening_modulus, saturation_increase, saturation_rate)
    return _step(
        F, shear_modulus, bulk_modulus, hardening, 0.0, kinematic_modulus, plastic_metric, plastic_strain
    )


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
    saturation_increase: float = parameter(0.0, unit="Pa", min=0.0),
    saturation_rate: float = parameter(10.0, above=0.0),
    plastic_metric: Mat3 = internal(np.eye(3), doc="inverse of Fp^T Fp, determinant 1"),
    plastic_strain: float = internal(0.0, doc="equivalent plastic strain, which never falls"),
) -> Any:
    """``j2_plasticity`` that flows at a rate, after Perzyna: energy of a step per rest volume [J/m^3].

    viscosity [Pa s]: stress above the yield stress over the rate of the equivalent plastic strain. The other
    parameters are those of ``j2_plasticity``."""
    hardening = _Hardening(yield_stress, hardening_modulus, saturation_increase, saturation_rate)
    return _step(
        F, shear_modulus, bulk_modulus, hardening, viscosity / h, kinematic_modulus, plastic_metric,
        plastic_strain,
    )  # fmt: skip
