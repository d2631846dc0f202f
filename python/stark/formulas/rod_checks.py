"""Tests of laws of rods: finite and free of force at rest, differentiable, stable."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.formulas.checks import CheckReport, Finding
from stark.formulas.law_checks import Problem
from stark.formulas.recorded_law import RecordedLaw

_SAMPLES = 64
_STRETCH = 0.15  # of the random deformations
_TURN = 1.0  # of curvature and twist [1/m]
_FORCE_TOLERANCE = 1e-9  # at rest, relative to the stiffness
_STABLE_TOLERANCE = 1e-9
_DIFFERENCE_STEP = 1e-6
_DIFFERENCE_TOLERANCE = 1e-6
_ROWS = 8  # values of parameters that differ by segment: this many are tested
_STRAINS = [2, 3, 4, 5]  # stretch, curvature 1 and 2, twist among the coordinates of the two points
_REST = np.array([1.0, 0.0, 0.0, 0.0])
_UNITS = ("N", "N m", "N m", "N m")
_WHAT = ("stretch", "curvature about d1", "curvature about d2", "twist")


class Samples:
    """A law with values of its parameters at rest and at random strains."""

    def __init__(self, law: RecordedLaw, values: Mapping[str, np.ndarray]) -> None:
        rng = np.random.default_rng(7)
        size = np.array([_STRETCH, _TURN, _TURN, _TURN])
        self._law, self._values = law, values
        self.rest: tuple[NDArray[Any], ...] = self.at(np.repeat(_REST[None], _ROWS, axis=0))
        self.strains: NDArray[Any] = _REST + size * rng.uniform(-1.0, 1.0, (_SAMPLES, 4))
        self.before: NDArray[Any] = _REST + size * rng.uniform(-1.0, 1.0, (_SAMPLES, 4))
        self.directions: NDArray[Any] = size * rng.normal(size=(_SAMPLES, 4))
        self.psi: NDArray[Any]
        self.forces: NDArray[Any]
        self.stiffness: NDArray[Any]
        self.psi, self.forces, self.stiffness = self.at(self.strains, self.before)

    def at(
        self, strains: np.ndarray, before: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """psi (n,) [J/m], forces and moments (n, 4), stiffness (n, 4, 4) for strains (n, 4): stretch, two
        curvatures, twist."""
        count = len(strains)
        rest = np.broadcast_to(_REST, strains.shape)
        inputs = {
            "x": _points(strains),
            "x_prev": _points(rest if before is None else before),
            "X": _points(rest),
            "x_initial": _points(rest),
            "values": self._rows(count),
            "time_step": 0.01,
            "time": 0.01,
        }
        out = self._law.formula.sample(inputs).evaluate(2).reshape(count, -1)
        hessian = np.zeros((count, 6, 6))
        i, j = np.triu_indices(6)
        hessian[:, i, j] = hessian[:, j, i] = out[:, 7:]
        return out[:, 0], out[:, 1:7][:, _STRAINS], hessian[:, _STRAINS][:, :, _STRAINS]

    def _rows(self, count: int) -> dict[str, np.ndarray]:
        values = {}
        for parameter in self._law.parameters:
            rows = self._values[parameter.name].reshape(-1, parameter.width)
            values[parameter.name] = rows[np.arange(count) % len(rows)].reshape(-1).copy()
        return values

    @property
    def is_finite(self) -> bool:
        return all(np.isfinite(part).all() for part in self.rest)

    @property
    def scale(self) -> np.ndarray:
        """Largest stiffness against each strain, at rest or around it (4,)."""
        diagonal = np.concatenate([self.rest[2], self.stiffness])[:, range(4), range(4)]
        largest: np.ndarray = np.nanmax(np.abs(diagonal), axis=0)
        return largest

    @property
    def smallest_stiffness(self) -> float:
        """Smallest eigenvalue of the stiffness at rest, with strains scaled so that the largest entries of
        the diagonal are 1."""
        unit = np.sqrt(np.where(self.scale > 0.0, self.scale, 1.0))
        return float(np.linalg.eigvalsh(self.rest[2] / (unit[:, None] * unit))[:, 0].min())


def problems(law: RecordedLaw, values: Mapping[str, np.ndarray]) -> list[Problem]:
    """What speaks against using a law with these values, errors first."""
    samples = Samples(law, values)
    if not samples.is_finite:
        return [Problem(True, f"{law.name}: {_NOT_FINITE}")]
    found = []
    if not samples.scale.any():
        found.append(
            Problem(True, f"{law.name}: no stiffness at rest nor around it: must resist deformation")
        )
    strongest = _force_at_rest(samples)
    if law.declared["stress_free"] and strongest is not None:
        found.append(
            Problem(
                True,
                f"{law.name}: at rest, where stretch is 1 and curvature and twist are 0, {strongest}: must "
                f"be zero, or the rod deforms by itself; say @stark.material(stress_free=False) if it is "
                f"meant",
            )
        )
    if samples.smallest_stiffness < -_STABLE_TOLERANCE:
        found.append(Problem(False, f"{law.name}: {_unstable(samples)}"))
    return found


def check(law: RecordedLaw, values: Mapping[str, np.ndarray]) -> CheckReport:
    """Report on a law with these values."""
    samples = Samples(law, values)
    if not samples.is_finite:
        return CheckReport(law.name, (Finding("rest", "wrong", _NOT_FINITE, float("nan")),))
    return CheckReport(
        law.name,
        (
            _rest(law, samples),
            _derivative("force", samples, 0),
            _derivative("stiffness", samples, 1),
            _stability(samples),
        ),
    )


_NOT_FINITE = (
    "psi or a derivative is not finite at rest, where stretch is 1 and curvature and twist are 0: must be; "
    "look for a division by zero, or a square root, norm or logarithm of zero, and guard it with stark.where "
    "or a small offset"
)


def _points(strains: np.ndarray) -> np.ndarray:
    """The two points of the formula."""
    points = np.zeros((len(strains), 6))
    points[:, _STRAINS] = strains
    return points.reshape(-1, 3)


def _force_at_rest(samples: Samples) -> str | None:
    """The force or moment that acts at rest, in words; None where there is none."""
    force = np.abs(samples.rest[1]).max(axis=0)
    excess = force - _FORCE_TOLERANCE * np.maximum(samples.scale, 1e-300)
    k = int(np.argmax(excess))
    if excess[k] <= 0.0:
        return None
    return f"the {'force' if k == 0 else 'moment'} against {_WHAT[k]} is {force[k]:.4g} {_UNITS[k]}"


def _rest(law: RecordedLaw, samples: Samples) -> Finding:
    strongest, value = _force_at_rest(samples), float(np.abs(samples.rest[1]).max())
    if strongest is None:
        return Finding("rest", "ok", "no force and no moment at rest", value)
    return Finding("rest", "wrong" if law.declared["stress_free"] else "note", strongest, value)


def _derivative(name: str, samples: Samples, order: int) -> Finding:
    D = samples.directions
    ahead, behind = (samples.at(samples.strains + s * _DIFFERENCE_STEP * D, samples.before) for s in (1, -1))
    difference = (ahead[order] - behind[order]) / (2.0 * _DIFFERENCE_STEP)
    exact = (
        np.einsum("ni,ni->n", samples.forces, D)
        if order == 0
        else np.einsum("nij,nj->ni", samples.stiffness, D)
    )
    error = float(np.abs(exact - difference).max() / max(np.abs(exact).max(), 1e-300))
    if error <= _DIFFERENCE_TOLERANCE:
        return Finding(name, "ok", f"agrees with finite differences within {error:.1e}", error)
    text = (
        f"finite differences differ by {error:.1e}: psi has a kink or a jump (abs, minimum, maximum, where)"
    )
    return Finding(name, "wrong", text, error)


def _unstable(samples: Samples) -> str:
    return (
        f"unstable at rest: the smallest stiffness is {samples.smallest_stiffness:.2g} of the largest, so "
        f"the rod deforms at once; look at signs and ranges of the parameters"
    )


def _stability(samples: Samples) -> Finding:
    value = samples.smallest_stiffness
    if value < -_STABLE_TOLERANCE:
        return Finding("stability", "wrong", _unstable(samples), value)
    return Finding("stability", "ok", "stable at rest", value)
