"""Viscoelastic solids at finite strain: the generalised Maxwell model, whose relaxation is a Prony series.

Finite linear viscoelasticity (Simo 1987, Comput. Methods Appl. Mech. Engrg. 60, 153-173): a hyperelastic
spring beside branches of a spring and a dashpot in the isochoric Green strain. The dashpots are internal
variables, eliminated in closed form [theory eq. 10f, 10g]."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Sequence
from typing import Any

from stark._core import InvalidArgument
from stark.arguments import real_number
from stark.formulas.arguments import TimeStep
from stark.formulas.internal import internal
from stark.formulas.material import DeformationGradient, material
from stark.formulas.material_law import MaterialLaw
from stark.formulas.parameters import parameter
from stark.materials import SolidMaterial
from stark.symbolic.functions import exp
from stark.symbolic.linear_algebra import determinant, squared_norm, trace
from stark.symbolic.signature import Mat3
from stark.symbolic.tensor import identity

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

    Relaxation at constant strain is exact for any time step; where the strain changes, errors are of first
    order in the time step over the relaxation times. InvalidArgument names what is wrong."""
    branches = [_positive(value, "moduli", k) for k, value in enumerate(_listed(moduli, "moduli"))]
    spans = [_positive(value, "times", k) for k, value in enumerate(_listed(times, "times"))]
    if len(branches) != len(spans):
        raise InvalidArgument(
            f"generalized_maxwell: {len(branches)} moduli and {len(spans)} times: must be as many, one of "
            f"each for a branch"
        )
    given: dict[str, Any] = {f"modulus_{k}": value for k, value in enumerate(branches, start=1)}
    given |= {f"time_{k}": value for k, value in enumerate(spans, start=1)}
    made = _law(len(branches))(
        shear_modulus=shear_modulus, bulk_modulus=bulk_modulus, base=base, **given, **fields
    )
    assert isinstance(made, SolidMaterial)
    return made


def _listed(values: Any, what: str) -> list[Any]:
    try:
        found = list(values)
    except TypeError:
        raise InvalidArgument(
            f"generalized_maxwell: {what} = {values!r}: must be a sequence of numbers, one for each branch"
        ) from None
    if not 1 <= len(found) <= _MOST_BRANCHES:
        raise InvalidArgument(
            f"generalized_maxwell: {len(found)} {what}: must be 1 to {_MOST_BRANCHES}; without a branch use "
            f"an elastic material"
        )
    return found


def _positive(value: Any, what: str, k: int) -> float:
    number = real_number(value, f"generalized_maxwell: {what}[{k}]")
    if not number > 0.0:
        unit = "Pa" if what == "moduli" else "s"
        raise InvalidArgument(f"generalized_maxwell: {what}[{k}] = {number:g} {unit}: must be > 0")
    return number


@functools.cache
def _law(branches: int) -> MaterialLaw:
    """The law of that many branches."""

    def generalized_maxwell(F: Any, h: Any, shear: Any, bulk: Any, *rest: Any) -> Any:
        """Viscoelastic solid: a Neo-Hookean spring beside branches of a spring and a dashpot."""
        moduli, times, flows = (rest[k * branches : (k + 1) * branches] for k in range(3))
        J = determinant(F)
        C = (F.T @ F) * J ** (-2.0 / 3.0)
        strain = (C - identity(3)) * 0.5
        psi = 0.5 * shear * (trace(C) - 3.0) + 0.5 * bulk * (J - 1.0) ** 2
        updates = {}
        for k, (modulus, time, flow) in enumerate(zip(moduli, times, flows, strict=True), start=1):
            left = exp(-h / time)
            trial = strain - flow
            psi = psi + modulus * left * squared_norm(trial)
            updates[f"flow_{k}"] = flow + trial * (1.0 - left)
        return psi, updates

    generalized_maxwell.__signature__ = inspect.Signature(_arguments(branches))  # type: ignore[attr-defined]
    return material(generalized_maxwell)


def _arguments(branches: int) -> list[inspect.Parameter]:
    kind, count = inspect.Parameter.POSITIONAL_OR_KEYWORD, range(1, branches + 1)

    def made(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
        return inspect.Parameter(name, kind, annotation=annotation, default=default)

    return [
        made("F", DeformationGradient),
        made("h", TimeStep),
        made("shear_modulus", float, parameter(unit="Pa", above=0.0)),
        made("bulk_modulus", float, parameter(unit="Pa", above=0.0)),
        *(made(f"modulus_{k}", float, parameter(unit="Pa", above=0.0)) for k in count),
        *(made(f"time_{k}", float, parameter(unit="s", above=0.0)) for k in count),
        *(made(f"flow_{k}", Mat3, internal(0.0, doc="strain of the dashpot")) for k in count),
    ]
