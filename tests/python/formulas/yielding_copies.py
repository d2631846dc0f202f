"""The built-in potentials that yield once more, in Python, as src/stark/models/yielding.h and what uses
it."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import stark
from stark.formulas.internal import Internal
from stark.formulas.kinematics import Inputs
from stark.formulas.parameters import Parameter
from stark.formulas.tracing import parameter_symbols


def fold_angle(p0: stark.Vec, p1: stark.Vec, p2: stark.Vec, p3: stark.Vec) -> stark.Scalar:
    e = p1 - p0
    a, b = stark.cross(e, p2 - p0), stark.cross(p3 - p0, e)
    return stark.atan2(stark.dot(stark.cross(a, b), e) / stark.norm(e), stark.dot(a, b))


class Remembering:
    """An energy of a stencil with internal variables, which ``@stark.energy`` does not have."""

    def __init__(
        self, points: Any, widths: dict[str, int], function: Callable[..., Any], names: Sequence[str] = ()
    ) -> None:
        """widths: of inputs that are several numbers; those named plastic_... are internal variables; names:
        of the further ones."""
        self._points, self._widths, self._function, self._names = points, widths, function, names

    def trace(self) -> Any:
        inputs = Inputs(list(range(self._points.point_count)))
        values: dict[str, Any] = {"s": self._points(inputs, 0, "s")}
        own = [
            p.name for p in inspect.signature(self._function).parameters.values() if p.kind != p.VAR_KEYWORD
        ]
        for name in [*own[1:], *self._names]:
            width = self._widths.get(name, 1)
            shape = () if width == 1 else (width,)
            if name.startswith("plastic_"):
                values[name] = Internal(name, shape, stark.internal(0.0)).symbols(inputs)
            else:
                values[name] = parameter_symbols(inputs, Parameter(name, shape, stark.parameter()))
        energy, updates = self._function(**values)
        return SimpleNamespace(formula=inputs.builder.finish([energy, *updates]))


def yielding(strains: list, H: Any, p: Any) -> tuple:
    """(square, stiffness, yield force) of each strain; energy, work, what is kept of the strains."""
    energies = [stiffness * squared for squared, stiffness, _ in strains]
    a = [stiffness / stark.square(force) for _, stiffness, force in strains]
    total = 0.0
    for one, energy in zip(a, energies, strict=True):
        total = total + one * energy
    R = 1.0 + H * p
    flows = total > stark.square(R)

    def force(of: list, n: Any) -> tuple:
        squared: Any = 0.0
        slope: Any = 0.0
        for one, energy in zip(a, of, strict=True):
            kept = 1.0 / (1.0 + one * n)
            part = one * energy * stark.square(kept)
            squared = squared + part
            slope = slope + part * one * kept
        return 1.0 / stark.sqrt(stark.maximum(squared, 0.25 * stark.square(R))), slope

    def step(of: list, n: Any) -> Any:
        inverse, slope = force(values, n)
        rate = slope * inverse * stark.square(inverse) + H / R
        off = force(of, n)[0] - (1.0 - H * n) / R
        return stark.where(flows, n - off / stark.where(flows, rate, 1.0), 0.0)

    n: Any = 0.0
    values = energies
    if len(strains) > 1:
        values = [stark.held(energy) for energy in energies]
        for _ in range(4):
            n = step(values, n)
    n = step(energies, n)
    share = n / (1.0 - H * n)
    kept = [1.0 / (1.0 + one * n) for one in a]
    energy = 0.5 * (stark.square(R) * share + H * stark.square(p))
    for one, part in zip(energies, kept, strict=True):
        energy = energy + 0.5 * one * part
    return energy, R * share, kept


@stark.material
def plastic_rod(
    stretch: float,
    curvature: stark.Vec2,
    twist: float,
    axial_stiffness: float,
    bending_stiffness_1: float,
    bending_stiffness_2: float,
    torsional_stiffness: float,
    yield_force: float,
    yield_moment_1: float,
    yield_moment_2: float,
    yield_torque: float,
    yield_hardening: float,
    plastic_strain: stark.Vec4 = stark.internal(0.0),
    plastic_work: float = stark.internal(0.0),
):
    before = [plastic_strain[i] for i in range(4)]
    stiffness = [axial_stiffness, bending_stiffness_1, bending_stiffness_2, torsional_stiffness]
    forces = [yield_force, yield_moment_1, yield_moment_2, yield_torque]
    strain = [stretch - 1.0, curvature[0], curvature[1], twist]
    trial = [a - b for a, b in zip(strain, before, strict=True)]
    squares = [stark.square(t) for t in trial]
    energy, work, kept = yielding(
        list(zip(squares, stiffness, forces, strict=True)), yield_hardening, plastic_work
    )
    after = [b + t * (1.0 - k) for b, t, k in zip(before, trial, kept, strict=True)]
    return energy, {"plastic_strain": stark.vec(*after), "plastic_work": plastic_work + work}


def _plastic_bending(
    s: Any,
    bending_stiffness: Any,
    bending_yield_moment: Any,
    bending_hardening: Any,
    plastic_angle: Any,
    plastic_work: Any,
    rest_angle: Any,
) -> tuple:
    weight, squared_length = s.rest_weight, stark.squared_norm(s.rest_edge)
    trial = s.angle - rest_angle - plastic_angle
    H = bending_hardening * weight / stark.square(bending_yield_moment)
    hinge = (
        stark.square(trial),
        bending_stiffness * weight * squared_length,
        bending_yield_moment * stark.sqrt(squared_length),
    )
    energy, work, kept = yielding([hinge], H, plastic_work)
    return energy, [plastic_angle + trial * (1.0 - kept[0]), plastic_work + work]


plastic_bending = Remembering(stark.Hinge, {}, _plastic_bending)


def plastic_plate(hinges: int) -> Remembering:
    def energy(
        s: Any,
        flexural_rigidity: Any,
        poissons_ratio: Any,
        bending_yield_moment: Any,
        bending_hardening: Any,
        area: Any,
        plastic_curvature: Any,
        plastic_work: Any,
        **numbers: Any,
    ) -> tuple:
        folds = [(0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5)][:hinges]
        bend = [
            fold_angle(*(s[i].x for i in fold)) - numbers[f"rest_angle{k}"] for k, fold in enumerate(folds)
        ]
        rigidity, moment, nu = flexural_rigidity * area, bending_yield_moment * area, poissons_ratio
        stiffness = [rigidity * (1.0 + nu), rigidity * (1.0 - nu), rigidity * 0.5 * (1.0 - nu)]
        forces = [moment * math.sqrt(2.0), moment * math.sqrt(2.0 / 3.0), moment * math.sqrt(1.0 / 3.0)]
        trial = []
        for i in range(3):
            value = -plastic_curvature[i]
            for k in range(hinges):
                value = value + numbers[f"curvature{i}{k}"] * bend[k]
            trial.append(value)
        squares = [stark.square(t) for t in trial]
        H = bending_hardening / (area * stark.square(bending_yield_moment))
        density, work, kept = yielding(list(zip(squares, stiffness, forces, strict=True)), H, plastic_work)
        form: Any = 0.0
        for i in range(hinges):
            for j in range(i, hinges):
                form = form + (0.5 if i == j else 1.0) * numbers[f"form{i}{j}"] * bend[i] * bend[j]
        after = [b + t * (1.0 - k) for b, t, k in zip(plastic_curvature, trial, kept, strict=True)]
        return density + flexural_rigidity * form, [*after, plastic_work + work]

    names = [f"rest_angle{k}" for k in range(hinges)]
    names += [f"curvature{i}{k}" for i in range(3) for k in range(hinges)]
    names += [f"form{i}{j}" for i in range(hinges) for j in range(i, hinges)]
    return Remembering(stark.Stencil[3 + hinges], {"plastic_curvature": 3}, energy, names)


plastic_plate_1, plastic_plate_2, plastic_plate_3 = (plastic_plate(hinges) for hinges in (1, 2, 3))


@stark.material
def plastic_membrane(
    F: stark.ShellDeformationGradient,
    youngs_modulus: float,
    poissons_ratio: float,
    yield_stress: float,
    hardening_modulus: float,
    plastic_metric: stark.Vec3 = stark.internal([1.0, 0.0, 1.0]),
    plastic_work: float = stark.internal(0.0),
):
    E, nu, G = youngs_modulus, poissons_ratio, plastic_metric
    C = F.T @ F
    M = C @ stark.mat([[G[0], G[1]], [G[1], G[2]]])
    half, unlike = 0.5 * stark.trace(M), 0.5 * (M[0, 0] - M[1, 1])
    y = (stark.square(unlike) + M[0, 1] * M[1, 0]) / stark.square(half)
    total = 0.5 * stark.log(stark.determinant(M))
    r = stark.sqrt(stark.maximum(y, 0.04))
    series: Any = 1.0 / 17.0
    for k in range(7, -1, -1):
        series = series * y + 1.0 / (2.0 * k + 1.0)
    s = stark.where(y > 0.04, stark.log((1.0 + r) / (1.0 - r)) / (2.0 * r), series)
    energy, work, kept = yielding(
        [
            (0.5 * stark.square(total), E / (1.0 - nu), yield_stress * math.sqrt(2.0)),
            (0.5 * y * stark.square(s), E / (1.0 + nu), yield_stress * math.sqrt(2.0 / 3.0)),
        ],
        hardening_modulus / stark.square(yield_stress),
        plastic_work,
    )
    x = kept[1] * s * stark.sqrt(stark.maximum(y, 0.0))
    bounded = stark.maximum(x, 1e-3)
    steep = (stark.exp(bounded) - stark.exp(-bounded)) / (2.0 * bounded)
    across = stark.where(x > 1e-3, steep, 1.0 + stark.square(x) / 6.0) * kept[1] * s / half
    even = 0.5 * (stark.exp(x) + stark.exp(-x)) - across * half
    after = stark.inverse(C) @ (even * stark.identity(2) + across * M)
    size, flows = stark.exp(kept[0] * total), work > 0.0
    metric = [
        stark.where(flows, size * after[0, 0], G[0]),
        stark.where(flows, 0.5 * size * (after[0, 1] + after[1, 0]), G[1]),
        stark.where(flows, size * after[1, 1], G[2]),
    ]
    return energy, {"plastic_metric": stark.vec(*metric), "plastic_work": plastic_work + work}
