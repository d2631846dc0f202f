"""What ``stark.fit`` returns: parameters, what is known of their errors, what each curve says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import given_path, real_number
from stark.calibration.judging import cut_off, judged
from stark.calibration.laws import FitParameter, LawFormula
from stark.calibration.plotting import Panel, written
from stark.calibration.response import Response
from stark.curves import Curve, Floats

_OPEN = 1e-6  # part of a direction along which predictions stay: from it on an error is infinite


@dataclass(frozen=True)
class Search:
    """How the search for the minimum went."""

    converged: bool
    evaluations: int
    scale: Floats
    """Sizes of the parameters at the start."""
    at_bound: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class CurveFit:
    """A curve and what the fitted law predicts for it."""

    curve: Curve
    predicted: Floats
    """(n, q), as ``curve.measured``."""

    @property
    def name(self) -> str:
        """Name of the curve."""
        return self.curve.name

    @property
    def residuals(self) -> Floats:
        """Prediction less measurement (n, q), in the unit of what was measured."""
        return self.predicted - self.curve.measured

    @property
    def rms(self) -> float:
        """Root of the mean square of the residuals, in the unit of what was measured."""
        return float(np.sqrt((self.residuals**2).mean()))

    @property
    def largest(self) -> float:
        """Largest residual, without its sign."""
        return float(np.abs(self.residuals).max())

    @property
    def r_squared(self) -> float:
        """Part of the variance of the measurements that the law explains, 1 at best; NaN for a constant."""
        measured = self.curve.measured
        variance = float(((measured - measured.mean(axis=0)) ** 2).sum())
        return 1.0 - float((self.residuals**2).sum()) / variance if variance > 0.0 else float("nan")


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """Parameters of a law that were fitted to curves; what ``stark.fit`` returns. Print it for a report."""

    law: str
    """Name of the law."""
    values: Mapping[str, Any]
    """All parameters by name, in SI units: fitted and fixed ones."""
    free: tuple[str, ...]
    """Names of those that were fitted."""
    covariance: Floats
    """Of the fitted parameters (k, k), NaN in rows of those that ended at a bound."""
    degrees_of_freedom: int
    """Measurements less fitted parameters."""
    curves: tuple[CurveFit, ...]
    warnings: tuple[str, ...]
    """What keeps the parameters from being known."""
    converged: bool
    evaluations: int
    """How often the curves were predicted."""
    units: Mapping[str, str]
    """Of the parameters, by name."""
    _formula: LawFormula

    def __getitem__(self, name: str) -> Any:
        """The value of a parameter."""
        if name not in self.values:
            raise InvalidArgument(
                f"fit of '{self.law}': no parameter '{name}': must be {', '.join(self.values)}"
            )
        return self.values[name]

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors of the fitted parameters, in their units: from the scatter of the residuals, by the
        linearised law. They assume that residuals are noise, not that the law is wrong."""
        return dict(zip(self.free, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def correlation(self) -> Floats:
        """Correlations of the errors of the fitted parameters (k, k), in the order of ``free``."""
        error = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore", divide="ignore"):
            correlation: Floats = self.covariance / np.outer(error, error)
            return correlation

    def interval(self, name: str, confidence: float = 0.95) -> tuple[float, float]:
        """Where a fitted parameter is with this probability: its value less and more the quantile of
        Student's distribution times the standard error."""
        if name not in self.free:
            raise InvalidArgument(
                f"fit of '{self.law}': '{name}' was not fitted: must be {', '.join(self.free)}"
            )
        level = real_number(confidence, "confidence")
        if not 0.0 < level < 1.0:
            raise InvalidArgument(f"confidence = {level:g}: must be between 0 and 1")
        from scipy.special import stdtrit

        width = float(stdtrit(self.degrees_of_freedom, 0.5 + 0.5 * level)) * self.errors[name]
        return self.values[name] - width, self.values[name] + width

    def material(self, **fields: Any) -> Any:
        """A material with the fitted parameters. ``fields``: others that it has, such as density and
        thickness."""
        return self._formula.material(self.values, fields)

    def predict(self, curve: Curve) -> Floats:
        """What the fitted law answers to another test (n, q), which need not have been measured:
        ``fit.predict(stark.curves.uniaxial(stretch))``."""
        if not isinstance(curve, Curve):
            raise InvalidArgument(f"predict: curve = {curve!r}: must be a curve of stark.curves")
        if (
            curve.kind == "bending"
            and self._formula.kind == "shell"
            and "flexural_rigidity" not in self.values
        ):
            raise InvalidArgument(
                f"predict: curve '{curve.name}' is of bending: must have been fitted, too; give stark.fit "
                f"a bending curve"
            )
        best = np.array([self.values[name] for name in self.free])
        fixed = {name: value for name, value in self.values.items() if name not in self.free}
        return Response(self._formula, curve, self.free, fixed, best)(best)[0]

    def plot(self, path: str | Path) -> Path:
        """Writes measurements and predictions of all curves as an SVG file and returns its path."""
        file = given_path(path, "plot: path")
        if file.suffix != ".svg":
            raise InvalidArgument(f"plot: path = '{file}': must end in .svg")
        return written(file, [Panel(fit.curve, fit.predicted) for fit in self.curves])

    def report(self) -> str:
        """The parameters with their errors, how well each curve is described, warnings."""
        count = sum(fit.curve.measured.size for fit in self.curves)
        curves = "1 curve" if len(self.curves) == 1 else f"{len(self.curves)} curves"
        parameters = "1 parameter" if len(self.free) == 1 else f"{len(self.free)} parameters"
        lines = [f"{self.law}: {parameters} from {curves}, {count} measurements", ""]
        lines += _table(["parameter", "value", "standard error", "95 % interval"], self._rows())
        rows = [
            [fit.name, str(len(fit.curve)), _number(fit.rms), _number(fit.largest), f"{fit.r_squared:.5f}"]
            for fit in self.curves
        ]
        lines += ["", *_table(["curve", "points", "rms", "largest", "R^2"], rows)]
        if self.warnings:
            lines += ["", *(f"! {text}" for text in self.warnings)]
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        fitted = ", ".join(f"{name} = {_number(self.values[name])}" for name in self.free)
        return f"<stark.Fit of '{self.law}': {fitted}>"

    def _rows(self) -> list[list[str]]:
        rows, errors = [], self.errors
        for name, value in self.values.items():
            unit = "" if self.units[name] == "1" else f" {self.units[name]}"
            if name not in self.free:
                text = (
                    _number(value) if np.ndim(value) == 0 else np.array2string(np.asarray(value), precision=4)
                )
                rows.append([name, f"{text}{unit}", "fixed", ""])
                continue
            low, high = self.interval(name)
            rows.append(
                [name, f"{_number(value)}{unit}", _number(errors[name]), f"{_number(low)} to {_number(high)}"]
            )
        return rows


def fit_of(
    formula: LawFormula,
    parameters: Sequence[FitParameter],
    fixed: Mapping[str, Any],
    best: Floats,
    responses: Sequence[Response],
    problem: tuple[Floats, Floats],
    search: Search,
) -> Fit:
    """The result of a search. ``problem``: weighted residuals and their derivatives at the minimum."""
    residuals, slopes = problem
    names = [parameter.name for parameter in parameters if parameter.name not in fixed]
    values = dict(zip(names, best.tolist(), strict=True))
    ordered = {p.name: values.get(p.name, fixed.get(p.name)) for p in parameters}
    units = {parameter.name: parameter.unit for parameter in parameters}
    fits = tuple(CurveFit(response.curve, response(best)[0]) for response in responses)
    freedom = len(residuals) - len(names)
    covariance = _covariance(residuals, slopes, best, search)
    if search.converged:
        explained = {of.name: of.r_squared for of in fits}
        weight = "the largest stress" if fits[0].curve.sigma is None else "sigma"
        texts = judged(names, best, slopes, covariance, search.scale, search.at_bound, explained, weight)
    else:
        texts = cut_off(search.evaluations)
    return Fit(
        formula.name, ordered, tuple(names), covariance, freedom, fits, texts, search.converged,
        search.evaluations, units, formula,
    )  # fmt: skip


def _covariance(residuals: Floats, slopes: Floats, best: Floats, search: Search) -> Floats:
    """Of the parameters that are inside of their bounds [theory eq. 40]."""
    inside = np.flatnonzero(~search.at_bound)
    freedom = len(residuals) - len(inside)
    covariance = np.full((len(best), len(best)), np.nan)
    size = np.maximum(np.abs(best), 1e-9 * search.scale)[inside]
    if len(inside):
        _, s, V = np.linalg.svd(slopes[:, inside] * size, full_matrices=False)
        is_flat = s <= len(s) * np.finfo(float).eps * s.max()  # predictions stay: others have their errors
        root = (V[~is_flat].T / s[~is_flat]) * size[:, None]
        found = (residuals @ residuals) / freedom * (root @ root.T)
        open_ended = np.linalg.norm(V[is_flat], axis=0) > _OPEN
        found[open_ended] = found[:, open_ended] = np.nan
        found[open_ended, open_ended] = np.inf
        covariance[np.ix_(inside, inside)] = found
    return covariance


def _number(value: float) -> str:
    return f"{value:.4g}"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    return [
        "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip()
        for row in [head, *rows]
    ]
