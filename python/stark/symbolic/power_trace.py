"""Sums of powers of eigenvalues, in invariants: smooth where eigenvalues meet, as they are not themselves.

For 0 < f < 1 and x > 0, x^f = sin(pi f)/pi * integral over t > 0 of t^(f-1) x / (x + t) [Balakrishnan
1960]. With t = (1 - u)/(1 + u) it is an integral over -1 < u < 1 with the weight (1 - u)^(f-1) (1 + u)^(-f),
of Gauss and Jacobi. Of a matrix, the trace of A (A + t)^-1 takes the place of x / (x + t)."""

from __future__ import annotations

import functools
import math

import numpy as np

from stark._core import TraceError
from stark.arguments import shown_value
from stark.symbolic.functions import held, mark_stage, where
from stark.symbolic.linear_algebra import invariants
from stark.symbolic.tensor import Scalar, vec

#: Of the quadrature. The relative error is below 1e-10 for eigenvalues from 1/16 to 16, 2e-5 from 1/64 to 64.
_NODES = 24
_LARGEST = 16.0  # exponent
#: Mean eigenvalue, or one over it, of matrices that are scaled to 1 first: no strains, but moments and the
#: like, whose size depends on units. Strains are not, as the error of the quadrature jumps there.
_FAR, _LEAST = 32.0, 1e-150


def power_trace(a: object, exponent: float) -> Scalar:
    """tr(A^exponent), the sum of the eigenvalues of a symmetric positive definite matrix of 2 x 2 or 3 x 3,
    each to the power of a fixed number. With C = F.T @ F and exponent = alpha / 2 it is the sum of the
    principal stretches to the power alpha, as in Ogden's law; with 1/2 their sum. Its derivatives exist where
    eigenvalues are equal. Exact for whole exponents; else the relative error is below 1e-10 for principal
    stretches from 1/4 to 4, 2e-5 from 1/8 to 8. Matrices whose mean eigenvalue is below 1/32 or above 32 are
    scaled to a mean of 1 first, so their size does not matter."""
    if isinstance(exponent, bool) or not isinstance(exponent, (int, float, np.integer, np.floating)):
        raise TraceError(
            f"power_trace: exponent = {exponent!r}: must be a fixed number, as the terms of the formula "
            f"depend on it; define the law for each, in a function of the exponent"
        )
    if not abs(exponent) <= _LARGEST:
        raise TraceError(
            f"power_trace: exponent = {shown_value(exponent)}: must be in [-{_LARGEST:g}, {_LARGEST:g}]"
        )
    power = float(exponent)
    given = invariants(a)
    size = len(given)
    if power < 0.0:  # of the inverse
        given = (*(given[k] / given[-1] for k in reversed(range(size - 1))), 1.0 / given[-1])
    mark_stage(vec(*given))
    whole = math.floor(abs(power))
    powers = _whole_powers(given, whole + 2)
    if whole == abs(power):
        return powers[whole]
    # tr(A^f) = c^f tr((A/c)^f) whatever c is, so derivatives need not know of it.
    mean = given[0] / float(size)
    is_far = (mean > _FAR) | ((mean < 1.0 / _FAR) & (mean > _LEAST))
    scale = held(where(is_far, mean, 1.0))
    given = tuple(given[k] / scale ** (k + 1) for k in range(size))
    powers = _whole_powers(given, whole + 2)
    total = 0.0 * given[0]
    for weight, t in _quadrature(abs(power) - whole):
        total = total + weight * _resolvent(given, powers, whole + 1, t)
    return scale ** abs(power) * total


def _whole_powers(given: tuple[Scalar, ...], count: int) -> list[Scalar]:
    """tr(A^k) for k = 0 ... count, by Newton's identities."""
    size, first, second = len(given), given[0], given[1]
    powers = [0.0 * first + float(size), first, first * first - 2.0 * second]
    while len(powers) <= count:
        following = first * powers[-1] - second * powers[-2]
        powers.append(following + given[2] * powers[-3] if size == 3 else following)
    return powers


def _resolvent(given: tuple[Scalar, ...], powers: list[Scalar], k: int, t: float) -> Scalar:
    """tr(A^k (A + t)^-1), k >= 1, by the adjugate of A + t."""
    first, second = given[0], given[1]
    if len(given) == 2:
        return (t * powers[k] + second * powers[k - 1]) / (t * t + t * first + second)
    middle = first * powers[k] - powers[k + 1]
    above = t * t * powers[k] + t * middle + given[2] * powers[k - 1]
    return above / (t**3 + t * t * first + t * second + given[2])


@functools.cache
def _quadrature(fraction: float) -> tuple[tuple[float, float], ...]:
    """Weights and places t for the power ``fraction``, by the eigenvalues of the matrix of the recursion of
    Jacobi's polynomials [Golub, Welsch 1969] with the exponents a = fraction - 1, b = -fraction."""
    a, b = fraction - 1.0, -fraction
    k = np.arange(1.0, _NODES)
    s = 2.0 * k + a + b
    diagonal = np.concatenate([[(b - a) / (a + b + 2.0)], (b * b - a * a) / (s * (s + 2.0))])
    beside = np.full(_NODES - 1, 4.0 * (1.0 + a) * (1.0 + b) / ((2.0 + a + b) ** 2 * (3.0 + a + b)))
    k, s = k[1:], s[1:]
    beside[1:] = 4.0 * k * (k + a) * (k + b) * (k + a + b) / (s * s * (s + 1.0) * (s - 1.0))
    u, vectors = np.linalg.eigh(
        np.diag(diagonal) + np.diag(np.sqrt(beside), 1) + np.diag(np.sqrt(beside), -1)
    )
    weights = 2.0 * vectors[0] ** 2 / (1.0 + u)  # the integral of the weight is pi / sin(pi fraction)
    return tuple(zip(weights.tolist(), ((1.0 - u) / (1.0 + u)).tolist(), strict=True))
