"""Which parameters a fit has not determined, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stark.caller import warn
from stark.curves import Floats

_INFLUENCE = 1e-4  # change of the predictions by a parameter that grows by all of itself: less is none
_PART = 0.3  # of a direction in which predictions stay: which parameters are meant
_EXPLAINED = 0.5  # part of the variance of a curve below which the law is called wrong
_TIED = 0.999  # correlation from which two parameters are named


def judged(
    names: Sequence[str],
    best: Floats,
    slopes: Floats,
    covariance: Floats,
    scale: Floats,
    at_bound: NDArray[np.bool_],
    explained: Mapping[str, float],
    weight: str,
) -> tuple[str, ...]:
    """Warnings in words, issued as StarkWarning, too. ``slopes``: of the weighted residuals (n, k).
    ``explained``: R^2 by curve. ``weight``: what residuals were divided by, in words."""
    texts = [
        f"the law explains {max(part, 0.0):.0%} of the variance of the curve '{name}': it is not that "
        f"of the material, or the search ended at a minimum far from the right one; look at the plot, try "
        f"another start"
        for name, part in explained.items()
        if part < _EXPLAINED
    ]
    texts += [
        f"'{name}' = {value:.4g} ended at a bound, so that its error is not known"
        for name, value, bound in zip(names, best, at_bound, strict=True)
        if bound
    ]
    inside = np.flatnonzero(~at_bound)
    size = np.maximum(np.abs(best), 1e-9 * scale)
    weak: set[int] = set()
    if len(inside):
        scaled = slopes[:, inside] * size[inside] / np.sqrt(len(slopes))
        _, strengths, directions = np.linalg.svd(scaled, full_matrices=False)
        for strength, direction in zip(strengths, directions, strict=True):
            if strength > _INFLUENCE:
                continue
            involved = inside[np.abs(direction) > _PART]
            weak |= set(involved.tolist())
            texts.append(_undetermined([names[k] for k in involved], strength, weight))
    texts += _vague(names, best, covariance, [k for k in inside.tolist() if k not in weak])
    return _issued(texts)


def cut_off(evaluations: int) -> tuple[str, ...]:
    """The warning of a search that ended before it was at a minimum, of which nothing else is known."""
    return _issued([f"not converged in {evaluations} evaluations; raise max_evaluations"])


def _issued(texts: Sequence[str]) -> tuple[str, ...]:
    for text in texts:
        warn(f"fit: {text}")
    return tuple(texts)


def _undetermined(names: Sequence[str], strength: float, weight: str) -> str:
    quoted = ", ".join(f"'{name}'" for name in names)
    change = f"predictions change by {strength:.1g} of {weight}"
    if len(names) == 1:
        text = (
            f"the curves do not determine {quoted}: if it doubles, {change}; fix it, or add a curve that "
            f"depends on it"
        )
    else:
        text = (
            f"the curves determine only a combination of {quoted}: along another, {change}; fix one of them"
        )
    if any(name in ("bulk_modulus", "poissons_ratio", "bulk") for name in names):
        text += " (stark.curves.volumetric determines resistance to change of volume)"
    return text


def _vague(names: Sequence[str], best: Floats, covariance: Floats, inside: Sequence[int]) -> list[str]:
    """Of parameters whose errors are as large as they are, or tied to each other."""
    error = np.sqrt(np.diag(covariance))
    texts = [
        f"'{names[k]}' = {best[k]:.4g} has a standard error of {error[k]:.2g}: it is not known"
        for k in inside
        if error[k] > abs(best[k])
    ]
    for n, i in enumerate(inside):
        for j in inside[n + 1 :]:
            with np.errstate(invalid="ignore", divide="ignore"):
                together = covariance[i, j] / (error[i] * error[j])
            if abs(together) > _TIED:
                texts.append(
                    f"the errors of '{names[i]}' and '{names[j]}' have a correlation of {together:.5f}: the "
                    f"curves hardly tell one from the other"
                )
    return texts
