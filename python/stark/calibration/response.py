"""What a law answers to a test, and the derivatives by its parameters [theory eq. 39].

Free strains u make the energy of the step stationary, which is Newton's method in them. Derivatives by the
parameters are those of the engine: of the free strains by the theorem of implicit functions, of internal
variables carried along the path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stark._core import InvalidArgument
from stark._core import symbolic as core
from stark.calibration.laws import FitParameter, LawFormula, Source
from stark.calibration.loading import Entries, Loading, loading_of
from stark.curves import Curve, Floats

_ITERATIONS = 80
_STEP_TOLERANCE = 1e-13  # of free strains, relative: rounding
_CONVERGED = 1e-9  # a last step below is taken for an end by rounding
_FLAT = 1e-6  # free stretches below are no equilibrium: the law has collapsed
_QUADRATIC = 1e-6  # steps below need no line search: energies are rounded there
_SHEAR_TOLERANCE = 1e-9  # of stresses that materials without directions do not have


class Program:
    """Energy, stresses and updates of a law in a test, compiled."""

    def __init__(
        self,
        law: LawFormula,
        loading: Loading,
        imposed: int,
        free: Sequence[str],
        fixed: Mapping[str, Any],
    ) -> None:
        self.loading = loading
        self._law, self._fixed = law, fixed
        self._all: list[tuple[str, int]]
        self._initial: list[float]
        self._updates: list[Any]
        live: set[tuple[str, int]] = set()
        while True:  # internal variables that stay as they are in this test are constants
            self._record(imposed, free, live)
            moving = {
                key
                for key, start, update in zip(self._all, self._initial, self._updates, strict=True)
                if key not in live and not (update.is_constant and float(update) == start)
            }
            if not moving:
                break
            live |= moving
        kept = [k for k, key in enumerate(self._all) if key in live]
        self.initial: Floats = np.array([self._initial[k] for k in kept])
        self._updates = [self._updates[k] for k in kept]
        self._compile()

    def _record(self, imposed: int, free: Sequence[str], live: set[tuple[str, int]]) -> None:
        graph = core.Graph()

        def new(name: str, count: int) -> list[Any]:
            return [graph.input("element", f"{name}{k}") for k in range(count)]

        self._c, self._u = new("c", imposed), new("u", self.loading.free)
        self._c_prev, self._u_prev = new("c_prev", imposed), new("u_prev", self.loading.free)
        self._clock, self._p = new("clock", 2), new("p", len(free))
        parameters = dict(zip(free, self._p, strict=True))
        self._all, self._initial, alpha = [], [], {}
        for variable in self._law.internals:
            initial = np.broadcast_to(variable.declaration.initial, variable.shape).reshape(-1)
            for k, start in enumerate(initial):
                self._all.append((variable.name, k))
                self._initial.append(float(start))
                is_live = (variable.name, k) in live
                alpha[variable.name, k] = (
                    graph.input("element", f"{variable.name}{k}") if is_live else float(start)
                )
        self._alpha = [alpha[key] for key in self._all if key in live]
        strains = {
            "x": self.loading.entries(self._c, self._u),
            "x_prev": self.loading.entries(self._c_prev, self._u_prev),
        }
        values = [self._value(source, strains, parameters, alpha) for _, source in self._law.inputs]
        outputs = core.substitute(list(self._law.outputs), [node for node, _ in self._law.inputs], values)
        self._psi, self._updates = outputs[0], list(outputs[1:])

    def _value(
        self,
        source: Source,
        strains: Mapping[str, Entries],
        parameters: Mapping[str, Any],
        alpha: Mapping[tuple[str, int], Any],
    ) -> Any:
        """What stands for an input of the law."""
        name, column, component = source
        if name in strains:
            return strains[name].get((column, component), 0.0)
        if name in ("time_step", "time"):
            return self._clock[0 if name == "time_step" else 1]
        if (name, component) in alpha:
            return alpha[name, component]
        if name in parameters:
            return parameters[name]
        return float(np.reshape(self._fixed[name], -1)[component])

    def _compile(self) -> None:
        groups = {
            "c": self._c, "u": self._u, "c_prev": self._c_prev, "u_prev": self._u_prev,
            "alpha": self._alpha, "clock": self._clock, "p": self._p,
        }  # fmt: skip
        self._groups: dict[str, list[Any]] = {name: entries for name, entries in groups.items() if entries}
        stresses = core.jacobian([self._psi], self._c)[0]
        residuals = core.jacobian([self._psi], self._u)[0] if self._u else []
        self.stress_count: int = len(stresses)
        self._energy = self._compiled([self._psi], {"u"}) if self._u else None
        self.wrt: list[str] = [name for name in ("u", "u_prev", "alpha", "p") if name in self._groups]
        self._answer = self._compiled([*stresses, *residuals, *self._updates], set(self.wrt))
        self._shapes = [[len(entries)] for entries in self._groups.values()]

    def _compiled(self, outputs: Sequence[Any], wrt: set[str]) -> Any:
        arguments = [(name, entries, name in wrt) for name, entries in self._groups.items()]
        return core.compile_arrays(list(outputs), arguments, "automatic")

    def _arrays(self, given: Mapping[str, Floats]) -> list[Floats]:
        return [np.ascontiguousarray(given[name], dtype=np.float64) for name in self._groups]

    def energy(self, given: Mapping[str, Floats], order: int) -> tuple[Any, Any, Any]:
        """psi (n,), its derivatives by u (n, k), (n, k, k)."""
        assert self._energy is not None
        batch = [len(given["c"])]
        values, first, second = self._energy.evaluate(
            order, True, order > 0, self._arrays(given), self._shapes, batch
        )
        return values[:, 0], None if first is None else first[:, 0], second

    def answer(self, given: Mapping[str, Floats]) -> tuple[Floats, dict[str, Floats]]:
        """Derivatives of psi by c and by u, then updates (n, m + k + a), and their derivatives by ``wrt``."""
        values, first, _ = self._answer.evaluate(
            1, True, True, self._arrays(given), self._shapes, [len(given["c"])]
        )
        blocks: dict[str, Floats] = {}
        begin = 0
        for name, entries in self._groups.items():
            if name in self.wrt:
                blocks[name] = first[..., begin : begin + len(entries)]
                begin += len(entries)
        return values, blocks


class Response:
    """Predictions of a curve by a law, as a function of its free parameters."""

    def __init__(
        self, law: LawFormula, curve: Curve, free: Sequence[str], fixed: Mapping[str, Any], start: Floats
    ) -> None:
        self.curve = curve
        self._count = curve.measured.shape[1]
        if curve.kind == "bending" and law.kind == "shell":
            law = plate_law(law, curve)
        if law.needs_time and curve.times is None:
            raise InvalidArgument(
                f"fit: curve '{curve.name}' has no times, on which the law '{law.name}' depends: must have "
                f"them; give times=..."
            )
        self._paths = law.needs_path
        self._program = _program(law, curve, free, fixed, start)
        self._last: Floats | None = None  # free strains of the last parameters

    def __call__(self, parameters: Floats) -> tuple[Floats, Floats]:
        """Predictions (n, q) and their derivatives by the parameters (n, q, p); NaN where there is no
        answer."""
        with np.errstate(all="ignore"):
            return self._along_path(parameters) if self._paths else self._at_once(parameters)

    def _at_once(self, p: Floats) -> tuple[Floats, Floats]:
        c = self.curve.imposed
        n = len(c)
        times = np.zeros(n) if self.curve.times is None else self.curve.times
        given = {"c": c, "c_prev": c, "clock": np.stack([np.ones(n), times], axis=1), "p": p}
        given["alpha"] = np.broadcast_to(self._program.initial, (n, len(self._program.initial)))
        guesses = self._program.loading.guesses(c)
        given["u"] = given["u_prev"] = guesses[0]
        if self._last is not None:
            guesses = [self._last, *guesses]
        u = _solved(self._program, given, guesses)
        if np.isfinite(u).all():
            self._last = u
        values, blocks = self._program.answer({**given, "u": u, "u_prev": u})
        m, k = self._program.stress_count, u.shape[1]
        slopes = blocks["p"][:, :m]
        if k:
            inner = _divided(blocks["u"][:, m : m + k], blocks["p"][:, m : m + k])
            slopes = slopes - blocks["u"][:, :m] @ inner
        return self._shown(values[:, :m], slopes)

    def _shown(self, stresses: Floats, slopes: Floats) -> tuple[Floats, Floats]:
        factor, q = self._program.loading.factor, self._count
        return factor * stresses[:, :q], factor * slopes[:, :q]

    def _along_path(self, p: Floats) -> tuple[Floats, Floats]:
        program, loading = self._program, self._program.loading
        m, k, a = program.stress_count, loading.free, len(program.initial)
        values, spans, shown = self.curve.steps()
        rest = np.full((1, values.shape[1]), self.curve.at_rest)
        given: dict[str, Any] = {"c": rest, "p": p, "alpha": program.initial[None]}
        u = loading.guesses(rest)[0]
        slope_u, slope_alpha = np.zeros((k, len(p))), np.zeros((a, len(p)))
        stresses, slopes, time = [], [], 0.0
        for c, h, is_point in zip(values, spans, shown, strict=True):
            time += h
            moved = u + loading.guesses(c[None])[0] - loading.guesses(given["c"])[0]
            given |= {"c_prev": given["c"], "c": c[None], "clock": np.array([[h, time]]), "u_prev": u}
            u = _solved(program, given, [moved, *loading.guesses(c[None])])
            out, blocks = program.answer({**given, "u": u})
            total = blocks["p"][0].copy()
            if k:
                total += blocks["u_prev"][0] @ slope_u
            if a:
                total += blocks["alpha"][0] @ slope_alpha
            if k:
                slope_u = -_divided(blocks["u"][:, m : m + k], total[None, m : m + k])[0]
                total += blocks["u"][0] @ slope_u
            if is_point:
                stresses.append(out[0, :m])
                slopes.append(total[:m])
            slope_alpha, given["alpha"] = total[m + k :], out[:, m + k :]
        return self._shown(np.array(stresses), np.array(slopes))


def _program(
    law: LawFormula, curve: Curve, free: Sequence[str], fixed: Mapping[str, Any], start: Floats
) -> Program:
    """With free shears only where the material shears when it is pulled: where its directions are not the
    axes."""
    kind = "plate" if law.kind == "shell" and curve.kind == "bending" else law.kind
    m = curve.imposed.shape[1]
    straight = loading_of(kind, curve, False)
    slanted = loading_of(kind, curve, True)
    if slanted.shears == straight.shears:
        return Program(law, straight, m, free, fixed)
    program = Program(law, slanted, m, free, fixed)
    c = curve.imposed
    u = slanted.guesses(c)[0]
    given = {"c": c, "c_prev": c, "u": u, "u_prev": u, "p": start, "clock": np.ones((len(c), 2))}
    given["alpha"] = np.broadcast_to(program.initial, (len(c), len(program.initial)))
    with np.errstate(all="ignore"):
        out = program.answer(given)[0][:, : program.stress_count + slanted.free]
    shear = np.abs(out[:, program.stress_count + slanted.stretches :]).max()
    if shear <= _SHEAR_TOLERANCE * np.abs(out).max():
        return Program(law, straight, m, free, fixed)
    return program


def plate_law(law: LawFormula, curve: Curve) -> LawFormula:
    """Bending energy of a plate per area, D/2 ((k1 + k2)^2 - 2 (1 - nu) k1 k2), of the curvatures k1 and
    k2."""
    graph = core.Graph()
    k1, k2, rigidity, nu = (graph.input("element", name) for name in ("k1", "k2", "D", "nu"))
    inputs = [(k1, ("x", 0, 0)), (k2, ("x", 0, 1)), (rigidity, ("flexural_rigidity", 0, 0))]
    psi = 0.5 * rigidity * k1 * k1
    if curve.narrow:
        if all(parameter.name != "poissons_ratio" for parameter in law.parameters):
            raise InvalidArgument(
                f"fit: curve '{curve.name}' is of a narrow strip, and the law '{law.name}' has no "
                f"poissons_ratio: must have one; give the curve of a wide strip"
            )
        psi = 0.5 * rigidity * ((k1 + k2) * (k1 + k2) - 2.0 * (1.0 - nu) * k1 * k2)
        inputs.append((nu, ("poissons_ratio", 0, 0)))
    parameters: tuple[FitParameter, ...] = law.parameters
    return LawFormula(law.name, law.material_type, (psi,), tuple(inputs), parameters, (), law.law, law.base)


def _divided(matrices: Floats, values: Floats) -> Floats:
    """Solutions (n, k, p) of linear systems; NaN where there is none."""
    try:
        return np.asarray(np.linalg.solve(matrices, values), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full_like(values, np.nan)


def _solved(program: Program, given: Mapping[str, Floats], guesses: Sequence[Floats]) -> Floats:
    """Free strains (n, k) that make the energy least, from the guess of the least energy at each point; NaN
    where there are none."""
    if not program.loading.free:
        return guesses[0]
    energies = [program.energy({**given, "u": u}, 0)[0] for u in guesses]
    ranked = np.argmin([np.where(np.isfinite(e), e, np.inf) for e in energies], axis=0)
    u = np.stack(guesses)[ranked, np.arange(len(ranked))]
    size = np.full(len(u), np.inf)
    for _ in range(_ITERATIONS):
        psi, g, H = program.energy({**given, "u": u}, 2)
        ready = np.isfinite(psi) & np.isfinite(g).all(axis=1) & np.isfinite(H).all(axis=(1, 2))
        active = ready & (size > _STEP_TOLERANCE)
        if not active.any():
            break
        steps = np.zeros_like(u)
        w, V = np.linalg.eigh(H[active])
        w = np.maximum(np.abs(w), 1e-12 * np.abs(w).max(axis=1, keepdims=True) + 1e-300)
        steps[active] = -np.einsum("nij,nj,nkj,nk->ni", V, 1.0 / w, V, g[active])
        u = u + _searched(program, given, u, steps, psi, np.einsum("ni,ni->n", g, steps))
        size = np.where(active, np.abs(steps).max(axis=1) / (1.0 + np.abs(u).max(axis=1)), size)
    found = (size <= _CONVERGED) & (u[:, : program.loading.stretches] > _FLAT).all(axis=1)
    return np.where(found[:, None], u, np.nan)


def _searched(
    program: Program, given: Mapping[str, Floats], u: Floats, steps: Floats, psi: Floats, slope: Floats
) -> Floats:
    """Steps shortened until the energy falls and stretches stay above 0."""
    steps = steps.copy()
    stretches = program.loading.stretches
    small = np.abs(steps).max(axis=1) <= _QUADRATIC
    scale = np.ones(len(u))
    for _ in range(40):
        trial = u + steps * scale[:, None]
        energy = program.energy({**given, "u": trial}, 0)[0]
        fine = np.isfinite(energy) & (small | (energy <= psi + 1e-4 * scale * slope + 1e-14 * np.abs(psi)))
        fine &= (trial[:, :stretches] > 0.0).all(axis=1)
        if fine.all():
            break
        scale = np.where(fine, scale, 0.5 * scale)
    return steps * scale[:, None]
