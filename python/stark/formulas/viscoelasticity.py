"""Viscoelastic solids, shells and rods: the generalised Maxwell model, whose relaxation is a Prony series.

Finite linear viscoelasticity (Simo 1987, Comput. Methods Appl. Mech. Engrg. 60, 153-173): a hyperelastic
spring beside branches of a spring and a dashpot: of solids in the isochoric Green strain, of shells in the
Green strain in their plane, of rods in stretch, curvature and twist. The dashpots are internal variables,
eliminated in closed form [theory eq. 10f, 10g, 10l]."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from stark._core import InvalidArgument
from stark.arguments import real_number
from stark.formulas.arguments import TimeStep
from stark.formulas.internal import internal
from stark.formulas.material import DeformationGradient, ShellDeformationGradient, material
from stark.formulas.material_law import MaterialLaw
from stark.formulas.parameters import parameter
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial
from stark.symbolic.functions import exp, log
from stark.symbolic.linear_algebra import determinant, squared_norm, trace
from stark.symbolic.signature import Mat2, Mat3, Vec2, Vec4
from stark.symbolic.tensor import identity, vec

_MOST_BRANCHES = 20


def generalized_maxwell(
    *,
    shear_modulus: float,
    bulk_modulus: float,
    moduli: Sequence[float],
    times: Sequence[float],
    base: SolidMaterial | None = None,
    **fields: Any,
) -> SolidMaterial:
    """A viscoelastic solid, whose shear modulus relaxes as the Prony series
    G(t) = shear_modulus + sum_k moduli[k] exp(-t / times[k]).

    shear_modulus [Pa]: what is left after a long time, of a Neo-Hookean spring. bulk_modulus [Pa]: does not
    relax. ``moduli`` [Pa], ``times`` [s]: of 1 to 20 branches; from relative moduli g_k of the instantaneous
    modulus G0: moduli = g_k G0, shear_modulus = (1 - sum g_k) G0. ``base`` and further fields as for every
    law: density, damping, limits of strain.

    Relaxation at constant strain is exact for any time step; where the strain changes, errors are of the
    order of ``time.integrator`` in the time step over the relaxation times. InvalidArgument names what is
    wrong."""
    branches, spans = _series("generalized_maxwell", moduli, times)
    made = _solid_law(len(branches))(
        shear_modulus=shear_modulus,
        bulk_modulus=bulk_modulus,
        base=base,
        **_numbered(modulus=branches, time=spans),
        **fields,
    )
    assert isinstance(made, SolidMaterial)
    return made


def generalized_maxwell_shell(
    base: ShellMaterial, *, moduli: Sequence[float], times: Sequence[float], **fields: Any
) -> ShellMaterial:
    """A viscoelastic membrane, whose Young's modulus relaxes as the Prony series
    E(t) = base.youngs_modulus + sum_k moduli[k] exp(-t / times[k]), at the same Poisson's ratio.

    ``base``: the membrane after a long time, Neo-Hookean in plane stress; its bending is as it was, with
    ``bending_damping``. ``moduli`` [Pa], ``times`` [s]: of 1 to 20 branches. Further fields replace those of
    ``base``. InvalidArgument names what is wrong."""
    branches, spans = _series("generalized_maxwell_shell", moduli, times)
    _require_elastic("generalized_maxwell_shell", base, ShellMaterial)
    base = base.replace(**fields)
    ratios = [value / base.youngs_modulus for value in branches]
    made = _shell_law(len(branches))(
        youngs_modulus=base.youngs_modulus,
        poissons_ratio=base.poissons_ratio,
        base=base,
        name=base.name,
        **_numbered(ratio=ratios, time=spans),
    )
    assert isinstance(made, ShellMaterial)
    return made


def generalized_maxwell_rod(
    base: RodMaterial, *, moduli: Sequence[float], times: Sequence[float], **fields: Any
) -> RodMaterial:
    """A viscoelastic rod, whose Young's modulus relaxes as the Prony series
    E(t) = base.youngs_modulus + sum_k moduli[k] exp(-t / times[k]), and its stiffnesses against stretch,
    bending and twist alike.

    ``base``: the rod after a long time. ``moduli`` [Pa], ``times`` [s]: of 1 to 20 branches. Further fields
    replace those of ``base``. InvalidArgument names what is wrong."""
    branches, spans = _series("generalized_maxwell_rod", moduli, times)
    _require_elastic("generalized_maxwell_rod", base, RodMaterial)
    base = base.replace(**fields)
    ratios = [value / base.youngs_modulus for value in branches]
    made = _rod_law(len(branches))(
        base=base,
        name=base.name,
        **{name: base.section[name] for name in _STIFFNESSES},
        **_numbered(ratio=ratios, time=spans),
    )
    assert isinstance(made, RodMaterial)
    return made


def _require_elastic(owner: str, base: Any, kind: type[Any]) -> None:
    if not isinstance(base, kind):
        raise InvalidArgument(f"{owner}: base = {base!r}: must be a stark.{kind.__name__}")
    if base.law is not None:
        raise InvalidArgument(
            f"{owner}: base has the law '{base.law.name}': must have none, the series is one"
        )
    if base._fields:
        raise InvalidArgument(
            f"{owner}: base has {', '.join(base._fields)} by element: must be one number each; make a "
            f"body of each part"
        )
    if np.isfinite(base.yield_stress):
        raise InvalidArgument(
            f"{owner}: base has yield_stress = {base.yield_stress:g} Pa: must be infinite; what relaxes does "
            f"not yield"
        )


def _series(owner: str, moduli: Any, times: Any) -> tuple[list[float], list[float]]:
    branches = [
        _positive(owner, value, "moduli", k) for k, value in enumerate(_listed(owner, moduli, "moduli"))
    ]
    spans = [_positive(owner, value, "times", k) for k, value in enumerate(_listed(owner, times, "times"))]
    if len(branches) != len(spans):
        raise InvalidArgument(
            f"{owner}: {len(branches)} moduli and {len(spans)} times: must be as many, one of each for a "
            f"branch"
        )
    return branches, spans


def _numbered(**columns: Sequence[float]) -> dict[str, Any]:
    return {
        f"{name}_{k}": value for name, column in columns.items() for k, value in enumerate(column, start=1)
    }


def _listed(owner: str, values: Any, what: str) -> list[Any]:
    try:
        found = list(values)
    except TypeError:
        raise InvalidArgument(
            f"{owner}: {what} = {values!r}: must be a sequence of numbers, one for each branch"
        ) from None
    if not 1 <= len(found) <= _MOST_BRANCHES:
        raise InvalidArgument(
            f"{owner}: {len(found)} {what}: must be 1 to {_MOST_BRANCHES}; without a branch use an elastic "
            f"material"
        )
    return found


def _positive(owner: str, value: Any, what: str, k: int) -> float:
    number = real_number(value, f"{owner}: {what}[{k}]")
    if not number > 0.0:
        unit = "Pa" if what == "moduli" else "s"
        raise InvalidArgument(f"{owner}: {what}[{k}] = {number:g} {unit}: must be > 0")
    return number


def _branches(
    psi: Any, h: Any, strain: Any, energy: Callable[[Any], Any], rest: Sequence[Any], count: int
) -> tuple[Any, dict[str, Any]]:
    """psi with the branches, and the updates. energy: of the spring of a branch of the modulus 1."""
    moduli, times, flows = (rest[k * count : (k + 1) * count] for k in range(3))
    updates = {}
    for k, (modulus, time, flow) in enumerate(zip(moduli, times, flows, strict=True), start=1):
        left = exp(-h / time)
        trial = strain - flow
        psi = psi + modulus * left * energy(trial)
        updates[f"flow_{k}"] = flow + trial * (1.0 - left)
    return psi, updates


@functools.cache
def _solid_law(count: int) -> MaterialLaw:
    """The law of that many branches."""

    def generalized_maxwell(F: Any, h: Any, shear: Any, bulk: Any, *rest: Any) -> Any:
        """Viscoelastic solid: a Neo-Hookean spring beside branches of a spring and a dashpot."""
        J = determinant(F)
        C = (F.T @ F) * J ** (-2.0 / 3.0)
        psi = 0.5 * shear * (trace(C) - 3.0) + 0.5 * bulk * (J - 1.0) ** 2
        return _branches(psi, h, (C - identity(3)) * 0.5, squared_norm, rest, count)

    own = [_made("shear_modulus", float, parameter(unit="Pa", above=0.0))]
    own.append(_made("bulk_modulus", float, parameter(unit="Pa", above=0.0)))
    modulus = ("modulus", parameter(unit="Pa", above=0.0))
    return _recorded(
        _solid_law, generalized_maxwell, [_made("F", DeformationGradient)], own, modulus, Mat3, count
    )


@functools.cache
def _shell_law(count: int) -> MaterialLaw:
    def generalized_maxwell_shell(F: Any, h: Any, E: Any, nu: Any, *rest: Any) -> Any:
        """Viscoelastic membrane: a Neo-Hookean spring beside branches of a spring and a dashpot."""
        mu, lame = E / (2.0 * (1.0 + nu)), E * nu / (1.0 - nu**2)
        C = F.T @ F
        log_J = 0.5 * log(determinant(C))
        psi = 0.5 * mu * (trace(C) - 2.0) - mu * log_J + 0.5 * lame * log_J**2

        def energy(strain: Any) -> Any:
            return mu * squared_norm(strain) + 0.5 * lame * trace(strain) ** 2

        return _branches(psi, h, (C - identity(2)) * 0.5, energy, rest, count)

    own = [_made("youngs_modulus", float, parameter(unit="Pa", above=0.0))]
    own.append(_made("poissons_ratio", float, parameter(unit="1", min=0.0, below=0.5)))
    ratio = ("ratio", parameter(unit="1", above=0.0))
    return _recorded(
        _shell_law, generalized_maxwell_shell, [_made("F", ShellDeformationGradient)], own, ratio, Mat2, count
    )


_STIFFNESSES = {
    "axial_stiffness": "N",
    "bending_stiffness_1": "N m^2",
    "bending_stiffness_2": "N m^2",
    "torsional_stiffness": "N m^2",
}


@functools.cache
def _rod_law(count: int) -> MaterialLaw:
    def generalized_maxwell_rod(stretch: Any, curvature: Any, twist: Any, h: Any, *rest: Any) -> Any:
        """Viscoelastic rod: springs beside branches of a spring and a dashpot."""
        strain = vec(stretch - 1.0, curvature[0], curvature[1], twist)

        def energy(e: Any) -> Any:
            return 0.5 * sum((K * e[i] ** 2 for i, K in enumerate(rest[:4])), start=0.0)

        return _branches(energy(strain), h, strain, energy, rest[4:], count)

    own = [_made(name, float, parameter(unit=unit, above=0.0)) for name, unit in _STIFFNESSES.items()]
    strains = [_made("stretch", float), _made("curvature", Vec2), _made("twist", float)]
    ratio = ("ratio", parameter(unit="1", above=0.0))
    return _recorded(_rod_law, generalized_maxwell_rod, strains, own, ratio, Vec4, count)


def _made(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
    return inspect.Parameter(
        name, inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=annotation, default=default
    )


def _recorded(
    factory: Callable[[int], MaterialLaw],
    function: Callable[..., Any],
    strains: list[inspect.Parameter],
    own: list[inspect.Parameter],
    strength: tuple[str, Any],
    shape: Any,
    count: int,
) -> MaterialLaw:
    """The law of strains, the time step, parameters of its own, then strengths, times and flows of
    branches; ``factory`` makes it again of a pickle."""
    numbers = range(1, count + 1)
    name, declared = strength
    arguments = [
        *strains,
        _made("h", TimeStep),
        *own,
        *(_made(f"{name}_{k}", float, declared) for k in numbers),
        *(_made(f"time_{k}", float, parameter(unit="s", above=0.0)) for k in numbers),
        *(_made(f"flow_{k}", shape, internal(0.0, doc="strain of the dashpot")) for k in numbers),
    ]
    function.__signature__ = inspect.Signature(arguments)  # type: ignore[attr-defined]
    law: MaterialLaw = material(function)
    law._origin = factory, (count,)
    return law
