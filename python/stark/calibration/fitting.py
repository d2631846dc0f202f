"""``stark.fit``: parameters of a law from measured curves by least squares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import real_array, real_number
from stark.calibration.laws import FitParameter, LawFormula, flexural_rigidity, law_formula, names_of
from stark.calibration.response import Response
from stark.calibration.result import Fit, Search, fit_of
from stark.curves import Curve, Floats, require_curves

_INSIDE = 1e-6  # of a range or a size: how far from a bound a fit starts at least
_TOLERANCE = 1e-13


def fit(
    law: Any,
    curves: Curve | Sequence[Curve],
    *,
    start: Mapping[str, float] | None = None,
    fixed: Mapping[str, Any] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    max_evaluations: int = 1000,
) -> Fit:
    """Parameters of ``law`` that describe ``curves`` best, with what is known of their errors.

    law: any law of solids, shells or rods: of stark.materials, of ``@stark.material``, stark.j2_plasticity,
    ``stark.SolidMaterial`` for its own; or a material, whose values the fit starts from. curves: of
    stark.curves, one or several. start: where the search starts, by name; a parameter with a default or of
    a material may be left out. fixed: values that are known and stay. bounds: (lowest, highest), beside the
    range that the law declares.

    Minimises the sum of squares of (prediction - measurement) / sigma, with the largest stress of each
    curve in place of sigma where no curve has one, so that every curve counts by its relative errors.
    Derivatives are exact, SciPy (``least_squares``, trust region) does the search, which finds the minimum
    next to the start.

    Warns (StarkWarning) of parameters that the curves do not determine. Raises InvalidArgument for bad input,
    ImportError without SciPy: ``pip install 'stark-sim[fit]'``."""
    optimize = _scipy_optimize()
    formula, found = law_formula(law), require_curves(curves)
    parameters = list(formula.parameters)
    if formula.kind == "shell" and any(curve.kind == "bending" for curve in found):
        parameters.append(flexural_rigidity(formula.base))
    known = {parameter.name: parameter for parameter in parameters}
    for what, given in (("start", start), ("fixed", fixed), ("bounds", bounds)):
        _check_names(given, what, formula, known)
    values = _fixed_values(known, start or {}, fixed or {})
    free = [parameter for parameter in parameters if parameter.name not in values]
    _check_counts(free, found, formula)
    limits = [_limits(parameter, (bounds or {}).get(parameter.name)) for parameter in free]
    begin = np.array([
        _start(parameter, (start or {}).get(parameter.name), low, high, found)
        for parameter, (low, high) in zip(free, limits, strict=True)
    ])  # fmt: skip
    responses = [Response(formula, curve, [p.name for p in free], values, begin) for curve in found]
    problem = _Problem(responses, _weights(found))
    scale = np.where(begin != 0.0, np.abs(begin), 1.0)
    if not np.isfinite(problem(begin)[0]).all():
        raise InvalidArgument(_no_answer(formula, problem, found, free, begin))
    low, high = (np.array(side) / scale for side in zip(*limits, strict=True))
    done = optimize.least_squares(
        lambda x: problem(x * scale)[0],
        begin / scale,
        jac=lambda x: problem(x * scale)[1] * scale,
        bounds=(low, high),
        x_scale="jac",
        xtol=_TOLERANCE, ftol=_TOLERANCE, gtol=_TOLERANCE,
        max_nfev=_evaluations(max_evaluations),
    )  # fmt: skip
    best = done.x * scale
    at_bound = _at_bound(best, problem(best), limits) & (done.status > 0)
    search = Search(done.status > 0, int(done.nfev), scale, at_bound)
    return fit_of(formula, parameters, values, best, responses, problem(best), search)


class _Problem:
    """Residuals over their weights in a row, and their derivatives by the parameters, of the last point."""

    def __init__(self, responses: Sequence[Response], weights: Sequence[float]) -> None:
        self._responses, self._weights = responses, weights
        self._at: Floats | None = None
        self._last: tuple[Floats, Floats]

    def __call__(self, parameters: Floats) -> tuple[Floats, Floats]:
        if self._at is None or not np.array_equal(self._at, parameters):
            self._last = self._evaluated(parameters)
            self._at = parameters.copy()
        return self._last

    def _evaluated(self, parameters: Floats) -> tuple[Floats, Floats]:
        rows, slopes = [], []
        for response, weight in zip(self._responses, self._weights, strict=True):
            predicted, derivatives = response(parameters)
            if not np.isfinite(derivatives).all():
                predicted = np.full_like(predicted, np.nan)  # the search goes back from there
            rows.append(((predicted - response.curve.measured) / weight).reshape(-1))
            slopes.append((derivatives / weight).reshape(-1, len(parameters)))
        return np.concatenate(rows), np.concatenate(slopes)


def _scipy_optimize() -> Any:
    try:
        from scipy import optimize
    except ImportError as error:
        raise ImportError("stark.fit needs SciPy: pip install 'stark-sim[fit]'") from error
    return optimize


def _check_names(
    given: Mapping[str, Any] | None, what: str, law: LawFormula, known: Mapping[str, FitParameter]
) -> None:
    if given is None:
        return
    if not isinstance(given, Mapping):
        raise InvalidArgument(f"fit: {what} = {given!r}: must be a dict from names of parameters to values")
    for name in given:
        if name not in known:
            near = " (bending curves determine it)" if name == "flexural_rigidity" else ""
            raise InvalidArgument(
                f"fit: {what} has '{name}'{near}, which is no parameter of '{law.name}': must be one of "
                f"{names_of(list(known.values()))}"
            )


def _fixed_values(
    known: Mapping[str, FitParameter], start: Mapping[str, Any], fixed: Mapping[str, Any]
) -> dict[str, Any]:
    """Values of the parameters that are not fitted: those that are fixed, and vectors and matrices."""
    values: dict[str, Any] = {}
    for name, parameter in known.items():
        if name in fixed and name in start:
            raise InvalidArgument(f"fit: '{name}' is in start and in fixed: must be in one of the two")
        given = fixed.get(name, parameter.default if parameter.shape else None)
        if parameter.shape and given is None:
            raise InvalidArgument(
                f"fit: {_described(name, parameter.unit)} is made of {int(np.prod(parameter.shape))} "
                f"numbers, which are not fitted: must be in fixed"
            )
        if given is None:
            continue
        array = real_array(given, f"fit: fixed['{name}']")
        if array.shape != parameter.shape:
            raise InvalidArgument(
                f"fit: fixed['{name}'] has the shape {array.shape}: must be {parameter.shape or 'a number'}"
            )
        for number in array.reshape(-1):
            _check_range(float(number), parameter, "fixed")
        values[name] = array if parameter.shape else float(array)
    return values


def _check_range(value: float, parameter: FitParameter, what: str) -> None:
    low, high, low_open, high_open = parameter.range
    fine = np.isfinite(value) and (value > low if low_open else value >= low)
    if fine and (value < high if high_open else value <= high):
        return
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    above = "" if low == -np.inf else f" {'>' if low_open else '>='} {low:g}"
    below = "" if high == np.inf else f" {'<' if high_open else '<='} {high:g}"
    rule = " and".join(side for side in (above, below) if side) or " finite"
    raise InvalidArgument(f"fit: {what}['{parameter.name}'] = {value:g}{unit}: must be{rule}")


def _check_counts(free: Sequence[FitParameter], curves: Sequence[Curve], law: LawFormula) -> None:
    if not free:
        raise InvalidArgument(f"fit: all parameters of '{law.name}' are fixed: must leave one to be fitted")
    count = sum(curve.measured.size for curve in curves)
    if count <= len(free):
        raise InvalidArgument(
            f"fit: {count} measurements for {len(free)} parameters ({names_of(free)}): must be more "
            f"measurements than parameters; measure more points, or give some of them in fixed"
        )


def _limits(parameter: FitParameter, given: Any) -> tuple[float, float]:
    low, high = parameter.range[:2]
    if given is None:
        return low, high
    try:
        first, last = given
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(
            f"fit: bounds['{parameter.name}'] = {given!r}: must be (lowest, highest)"
        ) from None
    name = f"fit: bounds['{parameter.name}']"
    given_low, given_high = real_number(first, f"{name}[0]"), real_number(last, f"{name}[1]")
    low, high = max(low, given_low), min(high, given_high)
    if np.isnan([given_low, given_high]).any() or not low < high:
        raise InvalidArgument(
            f"{name} = {given!r}: must leave a range; the law allows {parameter.range[0]:g} to "
            f"{parameter.range[1]:g}"
        )
    return low, high


def _start(parameter: FitParameter, given: Any, low: float, high: float, curves: Sequence[Curve]) -> float:
    """Where the search starts: given, or the default, and inside the bounds."""
    if given is None and parameter.default is None:
        raise InvalidArgument(
            f"fit: no start for {_described(parameter.name, parameter.unit)}: must be given; "
            f"{_hint(parameter, curves)}start={{'{parameter.name}': ...}}, or fixed={{...}} if it is known"
        )
    value = real_number(parameter.default if given is None else given, f"fit: start['{parameter.name}']")
    _check_range(value, parameter, "start")
    if not low <= value <= high:
        raise InvalidArgument(
            f"fit: start['{parameter.name}'] = {value:g}: must be within its bounds, {low:g} to {high:g}"
        )
    span = high - low if np.isfinite(high - low) else max(abs(value), 1.0)
    return float(min(max(value, low + _INSIDE * span), high - _INSIDE * span))


def _hint(parameter: FitParameter, curves: Sequence[Curve]) -> str:
    if parameter.unit != "Pa":
        return "give "
    curve = curves[0]
    strain = np.abs(curve.imposed[:, 0] - curve.at_rest)
    k = int(np.argmin(np.where(strain > 0.0, strain, np.inf)))
    if not strain[k] > 0.0:
        return "give "
    slope = abs(float(curve.measured[k, 0])) / strain[k]
    return f"the curve '{curve.name}' starts with a slope of {slope:.2g} Pa; give "


def _weights(curves: Sequence[Curve]) -> list[float]:
    given = [curve.sigma is not None for curve in curves]
    if any(given) and not all(given):
        without = next(curve.name for curve in curves if curve.sigma is None)
        raise InvalidArgument(
            f"fit: curve '{without}' has no sigma, and others have: must be given for all curves or for none"
        )
    return [curve.scale if curve.sigma is None else curve.sigma for curve in curves]


def _evaluations(given: Any) -> int:
    if isinstance(given, bool) or not isinstance(given, (int, np.integer)) or given < 1:
        raise InvalidArgument(f"fit: max_evaluations = {given!r}: must be a whole number >= 1")
    return int(given)


def _at_bound(
    best: Floats, problem: tuple[Floats, Floats], limits: Sequence[tuple[float, float]]
) -> NDArray[np.bool_]:
    """Which parameters a bound holds: a step to the minimum without bounds, by the parameter alone, crosses
    it."""
    low, high = (np.array(side) for side in zip(*limits, strict=True))
    residuals, slopes = problem
    curvature = (slopes**2).sum(axis=0)
    step = -(slopes.T @ residuals) / np.where(curvature > 0.0, curvature, np.inf)
    return (best + step < low) | (best + step > high)


def _no_answer(
    law: LawFormula, problem: _Problem, curves: Sequence[Curve], free: Sequence[FitParameter], begin: Floats
) -> str:
    """Why a fit cannot start."""
    rows, first = problem(begin)[0], 0
    name, place = curves[0].name, 0
    for curve in curves:
        wrong = ~np.isfinite(rows[first : first + curve.measured.size])
        if wrong.any():
            name, place = curve.name, int(np.argmax(wrong)) // curve.measured.shape[1]
            break
        first += curve.measured.size
    given = ", ".join(f"{p.name} = {value:g}" for p, value in zip(free, begin, strict=True))
    return (
        f"fit: the law '{law.name}' has no state without lateral stress at point {place} of the curve "
        f"'{name}' with {given}: must have one where the search starts; give another start, or bounds"
    )


def _described(name: str, unit: str) -> str:
    """'stiffness' [N/m]; what has no unit is its name alone."""
    return f"'{name}'" if unit == "1" else f"'{name}' [{unit}]"
