"""``energy.check(...)``: tests of a user's own energy, reported in plain words. Derivatives against finite
differences, behaviour under rigid motion, definiteness, values at the start and around it."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import symbolic as core_symbolic
from stark.formulas.binding import BoundEnergy
from stark.formulas.inspection import sample_inputs, stacked
from stark.formulas.numbering import dependence, numbering_text
from stark.rotations import rotation

_MOST_ELEMENTS = 512
_DIFFERENCE_STEP = 1e-6  # of the size of an element: truncation and rounding errors of about 1e-10 meet
_DIFFERENCE_TOLERANCE = 1e-5  # relative; wrong derivatives are off by much more
_INVARIANCE_TOLERANCE = 1e-8  # relative to the largest force
_STILL_TOLERANCE = 1e-9  # of an energy or a force, relative to those of the moved elements
_MOVE = 0.05  # random displacements, of the size of an element
_QUADRATURE = tuple(zip(*np.polynomial.legendre.leggauss(4), strict=True))  # places and weights
_LEAST_PATHS = 8
# Not halves: where a path is cut, as in its middle, which is the start, no kink is seen.
_CUT = 0.47
_CUTS = 28  # until a kink is smooth and a jump is left
_ROUNDED = 1e-11  # changes below this share of a value may be its rounding
_JUMP_TOLERANCE = 1e-3  # of the change along the path; rounding is 1e-4 of it
_BIT_EXACT = "automatic", "interpreter"


@dataclass(frozen=True)
class Finding:
    """One test: its name, "ok", "note" or "wrong", a sentence, and the number that was measured."""

    name: str
    status: str
    text: str
    value: float


@dataclass(frozen=True)
class CheckReport:
    """What ``check`` found. ``print(report)`` for plain words; ``report["gradient"].value`` is a number."""

    title: str
    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong; notes are properties that may well be meant."""
        return all(finding.status != "wrong" for finding in self.findings)

    def __getitem__(self, name: str) -> Finding:
        for finding in self.findings:
            if finding.name == name:
                return finding
        raise KeyError(f"no finding {name!r}; there are {', '.join(f.name for f in self.findings)}")

    def __str__(self) -> str:
        width = max(len(f.name) for f in self.findings)
        lines = [f"  {f.status:5}  {f.name:{width}}  {f.text}" for f in self.findings]
        verdict = "nothing is wrong" if self.ok else "something is wrong"
        return "\n".join([f"{self.title}: {verdict}", *lines])

    def __repr__(self) -> str:
        return f"<CheckReport of {self.title}: {'ok' if self.ok else 'wrong'}>"


class Elements:
    """Some elements of a binding, evaluated at any positions."""

    most: int = _MOST_ELEMENTS
    has_stiffness: bool = True

    def __init__(self, binding: BoundEnergy, rng: np.random.Generator) -> None:
        self.binding = binding
        count = min(binding.element_count, self.most)
        self.rows: NDArray[Any] = np.sort(rng.permutation(binding.element_count)[:count])
        self.start: NDArray[Any] = stacked(binding, "positions", self.rows)
        self.is_direction: NDArray[Any] = np.array([c.is_direction for c in binding.columns])
        spread = self.start - self.start.mean(axis=1, keepdims=True)
        sizes = 2.0 * np.sqrt((spread**2).sum(axis=2).max(axis=1))
        # Points alone, or all in one place, have no size of their own.
        self.size: NDArray[Any] = np.where(
            sizes > 0.0, sizes, max(float(np.ptp(self.start, axis=(0, 1)).max()), 1e-2)
        )
        noise = rng.uniform(-1.0, 1.0, (2, *self.start.shape))
        self.moved: Any = self.start + _MOVE * self.size[:, None, None] * noise[0]
        self.moved_before: Any = self.start + _MOVE * self.size[:, None, None] * noise[1]
        self._sample = self._compiled("automatic", self.moved_before)
        self._sample_at_rest = self._compiled("automatic", self.start)

    def evaluate(
        self, x: np.ndarray, order: int, at_rest: bool = False
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Energies (n,), gradients (n, 3k), Hessians (n, 3k, 3k); empty beyond the order. at_rest: in steps
        from the start instead of random positions."""
        sample = self._sample_at_rest if at_rest else self._sample
        sample.set_positions(np.ascontiguousarray(x).reshape(-1, 3))
        return self._split(sample.evaluate(order), order)

    def at(self, x: np.ndarray, x_prev: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same with other positions at the start of the step."""
        inputs = sample_inputs(self.binding, x, x_prev, self.rows)
        sample = self.binding.trace.formula.sample(inputs)
        return self._split(sample.evaluate(order), order)

    def bits(self, backend: str) -> np.ndarray:
        """All outputs at the moved positions from one back end."""
        outputs: np.ndarray = self._compiled(backend, self.moved_before).evaluate(2)
        return outputs

    def _compiled(self, backend: str, x_prev: np.ndarray) -> Any:
        inputs = sample_inputs(self.binding, self.moved, x_prev, self.rows)
        return self.binding.trace.formula.sample(inputs, backend)

    def _split(self, flat: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        n = 3 * self.start.shape[1]
        values = flat.reshape(len(self.rows), -1)
        hessian = np.zeros((len(self.rows), n, n))
        if order == 2:
            i, j = np.triu_indices(n)
            hessian[:, i, j] = hessian[:, j, i] = values[:, 1 + n :]
        return values[:, 0], values[:, 1 : 1 + n] if order > 0 else np.zeros((len(self.rows), n)), hessian


class Whole(Elements):
    """All elements of an energy of totals, as one element of many points. Of its stiffness only that of
    elements alone is known, so it is left at zero."""

    most: int = sys.maxsize
    has_stiffness: bool = False

    def __init__(self, binding: BoundEnergy, rng: np.random.Generator) -> None:
        super().__init__(binding, rng)
        points = (1, -1, 3)
        self.start: NDArray[Any] = self.start.reshape(points)
        self.moved: Any = self.moved.reshape(points)
        self.moved_before: Any = self.moved_before.reshape(points)
        self.is_direction: NDArray[Any] = np.tile(self.is_direction, len(self.rows))
        self.size: NDArray[Any] = self.size.mean(keepdims=True)

    def _split(self, flat: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        values = flat.reshape(len(self.rows), -1)
        n = 3 * len(self.binding.columns)
        gradient = values[:, 1 : 1 + n] if order > 0 else np.zeros((len(self.rows), n))
        return values[:, 0].sum(keepdims=True), gradient.reshape(1, -1), np.zeros((1, 1, 1))


def check(binding: BoundEnergy, seed: int = 0) -> CheckReport:
    """Tests a bound energy on its own points, moved at random by 5 % of the size of an element."""
    rng = np.random.default_rng(seed)
    is_whole = binding.trace.totals is not None
    elements = (Whole if is_whole else Elements)(binding, rng)
    findings = [_finite(elements)]
    if findings[0].status == "ok":
        findings += (_of_whole if is_whole else _of_elements)(elements, rng)
    of = "the totals of " if is_whole else ""
    return CheckReport(f"{binding.name} on {of}{len(elements.rows)} elements", tuple(findings))


def _of_elements(elements: Elements, rng: np.random.Generator) -> list[Finding]:
    energy, gradient, hessian = elements.evaluate(elements.moved, 2)
    return [
        _gradient(elements, gradient, rng),
        _hessian(elements, hessian, rng),
        *_continuity(elements, rng),
        _backends(elements),
        _translation(elements, gradient),
        _rotation(elements, energy, rng),
        _definiteness(hessian),
        _rest(elements, energy, gradient),
        *_numbering(elements),
    ]


def _of_whole(whole: Elements, rng: np.random.Generator) -> list[Finding]:
    """Without what takes the stiffness."""
    energy, gradient, _ = whole.evaluate(whole.moved, 1)
    return [
        _gradient(whole, gradient, rng),
        *_continuity(whole, rng),
        _backends(whole),
        _translation(whole, gradient),
        _rotation(whole, energy, rng),
        _rest(whole, energy, gradient),
    ]


def _finite(elements: Elements) -> Finding:
    for where, x in (("at the start", elements.start), ("5 % of an element away from it", elements.moved)):
        energy, gradient, hessian = elements.evaluate(x, 2)
        for what, values in (("energy", energy), ("force", gradient), ("stiffness", hessian)):
            bad = ~np.isfinite(values.reshape(len(values), -1)).all(axis=1)
            if bad.any():
                element = elements.rows[np.flatnonzero(bad)[0]]
                text = f"the {what} of element {element} is not finite {where} ({bad.sum()} of {len(bad)})"
                return Finding("finite", "wrong", text, float(bad.mean()))
    return Finding("finite", "ok", "energy, forces and stiffness are finite at the start and around it", 0.0)


def _directional(elements: Elements, rng: np.random.Generator, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Random directions (n, 3k) and central differences of energies or gradients along them."""
    direction = rng.normal(size=elements.start.shape)
    step = _DIFFERENCE_STEP * elements.size
    move = step[:, None, None] * direction
    ahead = elements.evaluate(elements.moved + move, order)[order]
    behind = elements.evaluate(elements.moved - move, order)[order]
    scale = 2.0 * step if order == 0 else 2.0 * step[:, None]
    return direction.reshape(len(direction), -1), (ahead - behind) / scale


def _gradient(elements: Elements, gradient: np.ndarray, rng: np.random.Generator) -> Finding:
    direction, difference = _directional(elements, rng, 0)
    exact = np.einsum("ni,ni->n", gradient, direction)
    energy = np.abs(elements.evaluate(elements.moved, 0)[0])
    # Differences of energies carry their rounding errors divided by the step.
    rounding = 1e-15 * energy / (_DIFFERENCE_STEP * elements.size)
    return _compared("gradient", "forces agree", "the energy", exact, difference, rounding)


def _hessian(elements: Elements, hessian: np.ndarray, rng: np.random.Generator) -> Finding:
    direction, difference = _directional(elements, rng, 1)
    exact = np.einsum("nij,nj->ni", hessian, direction)
    gradient = np.abs(elements.evaluate(elements.moved, 1)[1]).max(axis=1, keepdims=True)
    rounding = 1e-15 * gradient / (_DIFFERENCE_STEP * elements.size[:, None])
    return _compared("hessian", "stiffness agrees", "the forces", exact, difference, rounding)


def _compared(
    name: str, what: str, of: str, exact: np.ndarray, difference: np.ndarray, rounding: np.ndarray
) -> Finding:
    scale = np.abs(exact).max() + np.abs(difference).max()
    if scale == 0.0:
        return Finding(name, "note", f"{what.split()[0]}: zero around the start", 0.0)
    error = float((np.maximum(np.abs(exact - difference) - 10.0 * rounding, 0.0) / scale).max())
    if error <= _DIFFERENCE_TOLERANCE:
        agreement = f"within {error:.1e}" if error > 0.0 else "to rounding"
        return Finding(name, "ok", f"the {what} with finite differences of {of} {agreement}", error)
    # The derivatives come from the formula itself, so it is the formula that is not smooth.
    text = (
        f"finite differences of {of} differ by {error:.1e}: the formula has a kink, a jump or a sharp "
        f"bend near the start (abs, minimum, maximum, where)"
    )
    return Finding(name, "wrong", text, error)


class Path:
    """Straight ways of all elements across the start, of 5 % of their size."""

    def __init__(self, elements: Elements, rng: np.random.Generator, at_rest: bool) -> None:
        self._elements, self._at_rest = elements, at_rest
        size = elements.size[:, None, None]
        self._way: NDArray[Any] = 2.0 * _MOVE * size * rng.uniform(-1.0, 1.0, elements.start.shape)

    def at(self, t: NDArray[Any], order: int) -> tuple[NDArray[Any], NDArray[Any]]:
        """Energies (n, 1) or forces (n, 3k), as order is 0 or 1, and their derivatives by t (n,), where the
        start is at 0."""
        x = self._elements.start + t[:, None, None] * self._way
        known = order + 1 if self._elements.has_stiffness else 1
        found = self._elements.evaluate(x, known, self._at_rest)
        direction = self._way.reshape(len(x), -1)
        if order == 0:
            return found[0][:, None], np.einsum("ni,ni->n", found[1], direction)[:, None]
        if not self._elements.has_stiffness:  # cutting a smooth change reduces all of it, only later
            return found[1], np.zeros_like(found[1])
        return found[1], np.einsum("nij,nj->ni", found[2], direction)

    def unexplained(self, begin: NDArray[Any], end: NDArray[Any], order: int) -> NDArray[Any]:
        """What the change from begin to end has beyond the integral of the derivatives."""
        change: NDArray[Any] = self.at(end, order)[0] - self.at(begin, order)[0]
        for t, weight in _QUADRATURE:
            derivative = self.at(0.5 * (begin + end) + 0.5 * t * (end - begin), order)[1]
            change -= 0.5 * weight * (end - begin)[:, None] * derivative
        return change

    def jump(self, order: int) -> float:
        """The largest jump on a path, over the largest change along one. Every path is cut again and again to
        the piece that its derivatives explain less: there a kink loses what it hides, and a jump keeps it."""
        count = len(self._way)
        begin, end = np.full(count, -0.5), np.full(count, 0.5)
        first, last = (self.at(t, order)[0] for t in (begin, end))
        middle = self.at(np.zeros(count), order)[0]
        changes = [np.abs(last - first).max(), np.abs(last - middle).max(), np.abs(first - middle).max()]
        for _ in range(_CUTS):
            cut = begin + _CUT * (end - begin)
            pieces = [self.unexplained(a, b, order) for a, b in ((begin, cut), (cut, end))]
            left, right = (np.nan_to_num(np.abs(piece), nan=np.inf).max(axis=1) for piece in pieces)
            begin, end = np.where(left >= right, begin, cut), np.where(left >= right, cut, end)
        jump = float(np.nan_to_num(np.abs(self.unexplained(begin, end, order)), nan=np.inf).max())
        return jump / float(max(*changes, _ROUNDED * np.abs(first).max(), np.finfo(float).tiny))


def _continuity(elements: Elements, rng: np.random.Generator) -> list[Finding]:
    """Looks for jumps of energies and of forces on the way across the start, in steps that begin there, and
    elsewhere."""
    count = max(2, _LEAST_PATHS // len(elements.rows))
    paths = [Path(elements, rng, at_rest=k % 2 == 0) for k in range(count)]
    energy, forces = (max(path.jump(order) for path in paths) for order in (0, 1))
    of_energy = _continuous_energy(energy)
    if forces <= _JUMP_TOLERANCE:
        return [of_energy, Finding("continuous forces", "ok", "no jump of the forces near the start", forces)]
    kink = ": the energy has a kink" if of_energy.status == "ok" else ""
    text = (
        f"the forces jump near the start by {100.0 * forces:.3g} % of their change"
        f"{kink}; Newton's method may take many iterations, or fail, "
        f"where a kink is in balance; look at abs, minimum, maximum and where, and round them off, as "
        f"stark.sqrt(d**2 + eps**2) does abs(d)"
    )
    return [of_energy, Finding("continuous forces", "note", text, forces)]


def _continuous_energy(jump: float) -> Finding:
    if jump <= _JUMP_TOLERANCE:
        return Finding("continuous energy", "ok", "no jump of the energy near the start", jump)
    text = (
        f"the energy jumps near the start by {100.0 * jump:.3g} % of its change; line search fails there; "
        f"look at abs, minimum, maximum and where"
    )
    return Finding("continuous energy", "wrong", text, jump)


def _backends(elements: Elements) -> Finding:
    first, second = (elements.bits(backend) for backend in _BIT_EXACT)
    same = bool(np.array_equal(first.view(np.uint64), second.view(np.uint64)))
    best = core_symbolic.best_backend()
    text = f"{best} and the interpreter give {'the same' if same else 'different'} bits"
    return Finding("back ends", "ok" if same else "wrong", text, 0.0 if same else 1.0)


def _translation(elements: Elements, gradient: np.ndarray) -> Finding:
    forces = gradient.reshape(elements.start.shape)[:, ~elements.is_direction]
    if forces.shape[1] == 0:
        return Finding("translation", "ok", "directions only: nothing moves with the origin", 0.0)
    total, largest = np.abs(forces.sum(axis=1)).max(), np.abs(forces).max()
    value = float(total / largest) if largest > 0.0 else 0.0
    if value <= _INVARIANCE_TOLERANCE:
        return Finding("translation", "ok", "forces sum to zero: momentum is kept", value)
    declared = elements.binding.translation_invariant
    text = f"forces sum to {value:.1e} of the largest: momentum is not kept (a field, a drag or fixed points)"
    if declared:
        text = f"declared invariant under translation, but forces sum to {value:.1e} of the largest"
    return Finding("translation", "wrong" if declared else "note", text, value)


def _rotation(elements: Elements, energy: np.ndarray, rng: np.random.Generator) -> Finding:
    """Rotates present and previous positions together, about a point near the elements."""
    changes = []
    x, before = elements.moved, elements.moved_before
    center = np.where(elements.is_direction[:, None], 0.0, x.mean(axis=(0, 1)) + 2.0 * elements.size.max())
    for _ in range(4):
        turn = rotation(axis=rng.normal(size=3), angle=rng.uniform(0.3, 3.0)).T
        turned = elements.at(center + (x - center) @ turn, center + (before - center) @ turn, 0)[0]
        changes.append(np.abs(turned - energy).max())
    scale = float(np.abs(energy).max())
    value = float(max(changes) / scale) if scale > 0.0 else 0.0
    if value <= _INVARIANCE_TOLERANCE:
        return Finding("rotation", "ok", "rotating an element leaves its energy as it is (objective)", value)
    text = (
        f"rotating an element changes its energy by {value:.1e} of it: it depends on directions or "
        f"places of the world; an elastic energy must not, it would resist rigid rotation"
    )
    return Finding("rotation", "note", text, value)


def _numbering(elements: Elements) -> list[Finding]:
    label, value = dependence(elements.binding)
    return [Finding("numbering", "wrong", numbering_text(label), value)] if label else []


def _definiteness(hessian: np.ndarray) -> Finding:
    values = np.linalg.eigvalsh(hessian)
    largest = np.maximum(np.abs(values).max(axis=1), np.finfo(float).tiny)
    relative = values[:, 0] / largest
    share = float((relative < -1e-10).mean())
    if share == 0.0:
        return Finding("definiteness", "ok", "all element Hessians are positive semidefinite", 0.0)
    text = (
        f"{share:.0%} of the element Hessians are indefinite, the most negative eigenvalue is "
        f"{relative.min():.2g} of the largest; the solver projects them, convergence may take more iterations"
    )
    return Finding("definiteness", "note", text, share)


def _rest(elements: Elements, energy: np.ndarray, gradient: np.ndarray) -> Finding:
    at_start = elements.at(elements.start, elements.start, 1)
    force = float(np.abs(at_start[1]).max())
    value = force / max(float(np.abs(gradient).max()), float(np.finfo(float).tiny))
    if value <= _STILL_TOLERANCE:
        level = float(np.abs(at_start[0]).max())
        zero = level <= _STILL_TOLERANCE * max(float(np.abs(energy).max()), np.finfo(float).tiny)
        text = "no forces at the start" + ("" if zero else f", where the energy is up to {level:.3g} J")
        return Finding("start", "ok", text, value)
    text = f"there are forces of up to {force:.3g} N at the start: it is no state of rest of this energy"
    return Finding("start", "note", text, value)
