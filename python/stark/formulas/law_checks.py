"""Tests of constitutive laws: finite and free of stress at rest, objective, isotropic, stable."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.formulas.checks import CheckReport, Finding
from stark.formulas.recorded_law import RecordedLaw
from stark.rotations import rotation

_SAMPLES = 64
_STRAIN = 0.15  # of the random deformations
_STRESS_TOLERANCE = 1e-9  # at rest, relative to the stiffness: a strain
_INVARIANCE_TOLERANCE = 1e-9  # relative to the energy of the random deformations
#: Stiffness against a strain, over the largest one, that is rounding.
_FREE_TOLERANCE = 1e-11
_STABLE_TOLERANCE = 1e-9
_DIFFERENCE_STEP = 1e-6
_DIFFERENCE_TOLERANCE = 1e-6
_ROWS = 8  # values of parameters that differ by element: this many are tested


@dataclass(frozen=True)
class Problem:
    """Something that makes a law unusable, or probably not what was meant."""

    is_error: bool
    text: str


class Law:
    """A law with values of its parameters, evaluated at any deformation gradients."""

    def __init__(self, law: RecordedLaw, values: Mapping[str, np.ndarray]) -> None:
        self.name: str = law.name
        self.columns: int = law.directions
        self._law, self._values = law, values
        self._rows = max(
            (len(values[p.name]) for p in law.parameters if values[p.name].ndim > len(p.shape)), default=1
        )

    @property
    def identity(self) -> np.ndarray:
        return np.eye(3)[:, : self.columns]

    def at(
        self, F: np.ndarray, F_prev: np.ndarray | None = None, order: int = 2
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """psi (n,) [J/m^3], stress P (n, 3, c) [Pa], its derivative (n, 3c, 3c), for F (n, 3, c). The entries
        of derivatives are column by column. F_prev: the identity if left out."""
        count, n = len(F), 3 * self.columns
        before = np.broadcast_to(self.identity if F_prev is None else F_prev, F.shape)
        flat = {key: self._points(value) for key, value in (("x", F), ("x_prev", before))}
        flat["X"] = flat["x_initial"] = self._points(np.broadcast_to(self.identity, F.shape))
        inputs = {**flat, "values": self._samples(count), "time_step": 0.01, "time": 0.01}
        out = self._law.formula.sample(inputs).evaluate(order).reshape(count, -1)
        stress = (
            out[:, 1 : 1 + n].reshape(count, self.columns, 3).transpose(0, 2, 1) if order > 0 else np.empty(0)
        )
        tangent = np.zeros((count, n, n))
        if order == 2:
            i, j = np.triu_indices(n)
            tangent[:, i, j] = tangent[:, j, i] = out[:, 1 + n :]
        return out[:, 0], stress, tangent

    def _points(self, F: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(np.swapaxes(F, 1, 2)).reshape(-1, 3)

    def _samples(self, count: int) -> dict[str, np.ndarray]:
        values = {}
        for parameter in self._law.parameters:
            value = self._values[parameter.name]
            rows = value.reshape(-1, parameter.width)
            values[parameter.name] = rows[np.arange(count) % len(rows)].reshape(-1).copy()
        return values


class Samples:
    """Random deformations of a law, and what it says to them."""

    def __init__(self, law: RecordedLaw, values: Mapping[str, np.ndarray]) -> None:
        rng = np.random.default_rng(7)
        self.law: Law = Law(law, values)
        self.columns: int = self.law.columns
        self.rest: tuple[NDArray[Any], ...] = self.law.at(np.repeat(self.law.identity[None], _ROWS, axis=0))
        self.F = self.law.identity + rng.uniform(-_STRAIN, _STRAIN, (_SAMPLES, 3, self.columns))
        self.before: NDArray[Any] = self.law.identity + rng.uniform(
            -_STRAIN, _STRAIN, (_SAMPLES, 3, self.columns)
        )
        self.turns: NDArray[Any] = np.stack(
            [rotation(axis=rng.normal(size=3), angle=a) for a in rng.uniform(0.2, 3, _SAMPLES)]
        )
        angles = rng.uniform(0.2, 3.0, _SAMPLES)
        plane = np.stack([rotation(axis="z", angle=a) for a in angles])[:, :2, :2]
        self.material_turns: NDArray[Any] = self.turns if self.columns == 3 else plane
        self.psi: NDArray[Any]
        self.stress: NDArray[Any]
        self.tangent: NDArray[Any]
        self.psi, self.stress, self.tangent = self.law.at(self.F, self.before)
        rest = self.rest[0][np.arange(_SAMPLES) % _ROWS]
        # Constants in psi carry rounding errors but no physics.
        self.scale: float = float(np.abs(self.psi - rest).max() + 1e-6 * np.abs(rest).max()) or 1.0

    @property
    def modulus(self) -> float:
        """Largest stiffness at rest [Pa]."""
        return float(np.abs(self.rest[2]).max())

    @property
    def rest_stress(self) -> float:
        """Largest stress at rest [Pa]."""
        return float(np.abs(self.rest[1]).max())

    @property
    def objectivity_error(self) -> float:
        """Largest change of psi when space is rotated, relative to its changes by deformation."""
        turned = self.law.at(self.turns @ self.F, self.turns @ self.before, 0)[0]
        return float(np.abs(turned - self.psi).max() / self.scale)

    @property
    def isotropy_error(self) -> float:
        """The same for rotations of the material."""
        Q = self.material_turns
        turned = self.law.at(self.F @ Q, self.before @ Q, 0)[0]
        return float(np.abs(turned - self.psi).max() / self.scale)

    def rotation_energy(self, angle: float) -> float:
        """psi [J/m^3] of a rotation by an angle about x, less that of rest; 0 for objective laws."""
        turned = rotation(axis="x", angle=angle) @ self.law.identity
        turned = np.repeat(turned[None], _ROWS, axis=0)
        return float(np.abs(self.law.at(turned, turned, 0)[0] - self.rest[0]).max())

    @cached_property
    def strains(self) -> NDArray[Any]:
        """Directions of F (modes, 3c) that are strains: stretches and shears of length 1."""
        strains = []
        for i, j in combinations_with_replacement(range(self.columns), 2):
            unit = np.zeros((self.columns, self.columns))
            unit[i, j] = unit[j, i] = 1.0 if i == j else math.sqrt(0.5)
            strains.append((self.law.identity @ unit).T.reshape(-1))
        return np.array(strains)

    @property
    def smallest_stiffness(self) -> float:
        """Smallest eigenvalue of the stiffness at rest, relative to the largest. Of objective laws against
        strains alone: along a straight way of F a rotation stretches, which stress at rest resists or helps.
        """
        tangent = self.rest[2]
        if self.objectivity_error <= _INVARIANCE_TOLERANCE:
            tangent = self.strains @ tangent @ self.strains.T
        values = np.linalg.eigvalsh(tangent)
        largest = np.abs(values).max(axis=1)
        return float((values[:, 0] / np.where(largest > 0.0, largest, 1.0)).min())

    @cached_property
    def free_strains(self) -> list[str]:
        """Strains that the law does not resist at rest, to first order."""
        pairs = combinations_with_replacement(range(self.columns), 2)
        names = [f"{'stretch' if i == j else 'shear'} {'xyz'[i]}{'xyz'[j]}" for i, j in pairs]
        values, modes = np.linalg.eigh(self.strains @ self.rest[2] @ self.strains.T)
        stiff = np.abs(values).max(axis=1)[:, None]
        none = (np.abs(values) < _FREE_TOLERANCE * stiff) | (stiff == 0.0)
        row = int(none.sum(axis=1).argmax())
        free = modes[row][:, none[row]]
        own = [name for name, share in zip(names, (free**2).sum(axis=1), strict=True) if share > 0.99]
        rest = free.shape[1] - len(own)
        return own + ([f"{rest} combinations of stretch and shear"] if rest else [])


def is_finite(samples: Samples) -> bool:
    return all(np.isfinite(part).all() for part in samples.rest)


def is_isotropic(law: RecordedLaw, values: Mapping[str, np.ndarray]) -> bool:
    """Whether rotations of the material leave psi as it is, for random deformations."""
    return Samples(law, values).isotropy_error <= _INVARIANCE_TOLERANCE


def problems(law: RecordedLaw, values: Mapping[str, np.ndarray]) -> list[Problem]:
    """What speaks against using a law with these values, errors first."""
    samples = Samples(law, values)
    if not is_finite(samples):
        what = next(
            what
            for what, part in zip(("energy", "stress", "stiffness"), samples.rest, strict=True)
            if not np.isfinite(part).all()
        )
        return [
            Problem(
                True,
                f"{law.name}: the {what} is not finite at rest, where F is the identity: must be; look for a "
                f"division by zero, or a square root, norm or logarithm of zero, and guard it with "
                f"stark.where or a small offset",
            )
        ]
    found = []
    if samples.modulus == 0.0 and np.abs(samples.tangent).max() == 0.0:
        found.append(
            Problem(True, f"{law.name}: no stiffness at rest nor around it: must resist deformation")
        )
    if law.declared["stress_free"] and samples.rest_stress > _STRESS_TOLERANCE * max(samples.modulus, 1e-300):
        found.append(
            Problem(
                True,
                f"{law.name}: the stress at rest, where F is the identity, is {samples.rest_stress:.4g} Pa: "
                f"must be zero, or the body deforms by itself; add the missing term (such as "
                f"-mu * log(J)), or say @stark.material(stress_free=False)",
            )
        )
    error = samples.objectivity_error
    if law.declared["objective"] and not error <= _INVARIANCE_TOLERANCE:
        found.append(Problem(False, f"{law.name}: {_not_objective(samples, error)}"))
    if samples.smallest_stiffness < -_STABLE_TOLERANCE:
        found.append(Problem(False, f"{law.name}: {_unstable(samples)}"))
    elif samples.modulus > 0.0 and samples.free_strains:
        found.append(Problem(False, f"{law.name}: {_free(samples)}"))
    return sorted(found, key=lambda problem: not problem.is_error)


def _not_objective(samples: Samples, error: float) -> str:
    resisted = samples.rotation_energy(0.5)
    if resisted > _INVARIANCE_TOLERANCE * samples.scale:
        defect = f"a rigid rotation by 0.5 rad alone stores {resisted:.3g} J/m^3, so it resists rotation"
    else:
        defect = "it prefers directions of space when it is deformed"
    return (
        f"not objective: rotating the deformed body changes psi by up to {error:.2g} of its range; {defect}. "
        f"Write psi in terms of C = F.T @ F or its invariants, or say @stark.material(objective=False)"
    )


def _unstable(samples: Samples) -> str:
    return (
        f"unstable at rest: the smallest stiffness is {samples.smallest_stiffness:.2g} of the largest, so "
        f"the body collapses or expands at once; look at signs and ranges of the parameters"
    )


def _free(samples: Samples) -> str:
    return (
        f"no stiffness at rest against {', '.join(samples.free_strains)}: a body deforms so without a force; "
        f"add a term that resists, such as 0.5 * mu * squared_norm(E) with E = 0.5 * (F.T @ F - identity)"
    )


def check(law: RecordedLaw, values: Mapping[str, np.ndarray]) -> CheckReport:
    """Report on a law with these values."""
    samples = Samples(law, values)
    findings = [_rest(law, samples)]
    if is_finite(samples):
        findings += [
            _derivative("stress", samples, 0),
            _derivative("stiffness", samples, 1),
            _objectivity(law, samples),
            _isotropy(samples),
            _stability(samples),
        ]
    return CheckReport(f"{law.name}", tuple(findings))


def _rest(law: RecordedLaw, samples: Samples) -> Finding:
    if not is_finite(samples):
        return Finding("rest", "wrong", problems(law, samples.law._values)[0].text, float("nan"))
    stress = samples.rest_stress
    if stress <= _STRESS_TOLERANCE * max(samples.modulus, 1e-300):
        return Finding("rest", "ok", "no stress at rest", stress)
    status = "wrong" if law.declared["stress_free"] else "note"
    return Finding("rest", status, f"the stress at rest is {stress:.4g} Pa", stress)


def _derivative(name: str, samples: Samples, order: int) -> Finding:
    rng = np.random.default_rng(11)
    D = rng.normal(size=samples.F.shape)
    ahead, behind = (
        samples.law.at(samples.F + s * _DIFFERENCE_STEP * D, samples.before, order)[order] for s in (1, -1)
    )
    difference: Any = (ahead - behind) / (2.0 * _DIFFERENCE_STEP)
    if order == 0:
        exact = np.einsum("nij,nij->n", samples.stress, D)
    else:
        flat = np.swapaxes(D, 1, 2).reshape(len(D), -1)
        exact = np.einsum("nij,nj->ni", samples.tangent, flat)
        difference = np.swapaxes(difference, 1, 2).reshape(len(D), -1)
    error = float(np.abs(exact - difference).max() / max(np.abs(exact).max(), 1e-300))
    if error <= _DIFFERENCE_TOLERANCE:
        return Finding(name, "ok", f"agrees with finite differences within {error:.1e}", error)
    text = (
        f"finite differences differ by {error:.1e}: psi has a kink or a jump (abs, minimum, maximum, where)"
    )
    return Finding(name, "wrong", text, error)


def _objectivity(law: RecordedLaw, samples: Samples) -> Finding:
    error = samples.objectivity_error
    if error <= _INVARIANCE_TOLERANCE:
        return Finding("objectivity", "ok", "rotations of space leave psi as it is", error)
    status = "wrong" if law.declared["objective"] else "note"
    return Finding("objectivity", status, _not_objective(samples, error), error)


def _isotropy(samples: Samples) -> Finding:
    error = samples.isotropy_error
    if error <= _INVARIANCE_TOLERANCE:
        return Finding("isotropy", "ok", "all material directions are equivalent", error)
    return Finding(
        "isotropy", "note", f"psi depends on material directions, by {error:.2g} of its range", error
    )


def _stability(samples: Samples) -> Finding:
    value = samples.smallest_stiffness
    if value < -_STABLE_TOLERANCE:
        return Finding("stability", "wrong", _unstable(samples), value)
    if samples.free_strains:
        return Finding("stability", "wrong", _free(samples), 0.0)
    indefinite = float((np.linalg.eigvalsh(samples.tangent)[:, 0] < -1e-10 * samples.modulus).mean())
    text = (
        f"stable at rest; {indefinite:.0%} of random strains up to {_STRAIN:.0%} have an indefinite "
        f"stiffness, as what is compressed has: the solver projects it"
    )
    return Finding("stability", "ok", text, value)
