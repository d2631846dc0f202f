"""Rubber that softens as it is stretched for the first time: Mullins' effect, as an incremental potential.

Ogden and Roxburgh 1999 (Proc. R. Soc. A 455, 2861-2877): below the largest energy that a point has seen, its
stress is that of the virgin rubber times a factor, which depends on the energy and its maximum. The maximum
is the internal variable; the energy of a step is the integral of the factor over the energy of the virgin
rubber, and what first stretching adds to it and does not give back is dissipated [theory eq. 10n, 10o]."""

from __future__ import annotations

import math
from typing import Any

from stark.formulas.internal import internal
from stark.formulas.material import DeformationGradient, material
from stark.formulas.parameters import parameter
from stark.symbolic.functions import exp, maximum
from stark.symbolic.linear_algebra import determinant, invariants

#: Abramowitz and Stegun 1964, 7.1.26: of the error function, within 1.5e-7.
_ERROR_SCALE = 0.3275911
_ERROR_TERMS = (0.254829592, -0.284496736, 1.421413741, -1.453152027, 1.061405429)


def _integral_of_error_function(x: Any) -> Any:
    """x erf(x) + (exp(-x^2) - 1)/sqrt(pi), x >= 0."""
    bell = exp(-(x**2))
    t = 1.0 / (1.0 + _ERROR_SCALE * x)
    tail: Any = 0.0
    for term in reversed(_ERROR_TERMS):
        tail = (tail + term) * t
    return x * (1.0 - tail * bell) + (bell - 1.0) / math.sqrt(math.pi)


@material
def ogden_roxburgh(
    F: DeformationGradient,
    c10: float = parameter(unit="Pa", above=0.0),
    c01: float = parameter(0.0, unit="Pa", min=0.0),
    bulk_modulus: float = parameter(unit="Pa", above=0.0),
    r: float = parameter(unit="1", min=1.0),
    m: float = parameter(unit="Pa", above=0.0),
    beta: float = parameter(0.0, unit="1", min=0.0),
    peak_energy: float = internal(0.0, unit="Pa", doc="largest energy of the virgin rubber so far"),
) -> Any:
    """Rubber that softens below what it has been stretched to before (Mullins' effect): energy of a step per
    rest volume [J/m^3].

    c10, c01 [Pa]: of Mooney and Rivlin's virgin rubber, whose isochoric energy is W; bulk_modulus [Pa], which
    does not soften. Below the largest W so far, Wm, its stress is multiplied by
    1 - erf((Wm - W)/(m + beta Wm))/r. r, at least 1: 1/r is the part of the stress that may be lost. m [Pa],
    beta: the energy below the peak at which most of it is; a small m softens at small strains, too."""
    J = determinant(F)
    I1, I2, _ = invariants(F.T @ F)
    W = c10 * (I1 * J ** (-2.0 / 3.0) - 3.0) + c01 * (I2 * J ** (-4.0 / 3.0) - 3.0)
    width = m + beta * peak_energy
    lost = _integral_of_error_function(peak_energy / width)
    lost = lost - _integral_of_error_function(maximum(peak_energy - W, 0.0) / width)
    psi = W - width / r * lost + 0.5 * bulk_modulus * (J - 1.0) ** 2
    return psi, {"peak_energy": maximum(peak_energy, W)}
