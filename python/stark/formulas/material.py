"""``@stark.material``: constitutive laws written in Python.

    @stark.material
    def mooney_rivlin(
        F: stark.DeformationGradient,
        c10: float = stark.parameter(unit="Pa", above=0.0),
        c01: float = stark.parameter(unit="Pa", above=0.0),
        bulk: float = stark.parameter(unit="Pa", above=0.0),
    ):
        C = F.T @ F
        I1, I2, I3 = stark.invariants(C)
        J = stark.determinant(F)
        return c10 * (I1 * J ** (-2 / 3) - 3) + c01 * (I2 * J ** (-4 / 3) - 3) + 0.5 * bulk * (J - 1) ** 2

    rubber = mooney_rivlin(c10=3e4, c01=1e4, bulk=2e6, density=1100.0)
    scene.add_solid(mesh, rubber)

The result is the stored energy per rest volume [J/m^3]; the core differentiates and compiles it with its
elements. Laws of rods are in rod_material.py."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from stark.arguments import given_flag
from stark.formulas.arguments import signature_of
from stark.formulas.material_law import MaterialLaw
from stark.formulas.recorded_law import ROD_STRAINS, STRAINS, read_others
from stark.formulas.rod_material import rod_material
from stark.overloads import overload
from stark.symbolic.errors import formula_error
from stark.symbolic.signature import ArgumentType, Matrix
from stark.symbolic.tensor import Mat

if TYPE_CHECKING:
    DeformationGradient: TypeAlias = Mat
    ShellDeformationGradient: TypeAlias = Mat
    CauchyGreen: TypeAlias = Mat
else:
    DeformationGradient = Matrix[3, 3]
    ShellDeformationGradient = Matrix[3, 2]
    CauchyGreen = Matrix[2, 2]

_NEED = (
    "the first argument must be the strain: F: stark.DeformationGradient (3x3, solids), "
    "F: stark.ShellDeformationGradient (3x2) or C: stark.CauchyGreen (2x2, shells), or arguments named "
    "stretch, curvature, twist (rods)"
)


@overload
def material(function: Callable[..., object], /) -> MaterialLaw: ...


@overload
def material(
    *, stress_free: bool = True, objective: bool = True, isotropic: bool | None = None
) -> Callable[[Callable[..., object]], MaterialLaw]: ...


def material(
    function: Callable[..., object] | None = None,
    /,
    *,
    stress_free: bool = True,
    objective: bool = True,
    isotropic: bool | None = None,
) -> Any:
    """Decorator: makes a constitutive law of a function of the strain and parameters, which returns the
    energy per rest volume [J/m^3], of rods per rest length [J/m].

    The first argument is F: stark.DeformationGradient (3x3) for solids, F: stark.ShellDeformationGradient
    (3x2) or C: stark.CauchyGreen (2x2) for shells. Laws of rods start with some of the arguments stretch
    (1 at rest), curvature (two numbers: changes about the axes d1 and d2 [1/m]) and twist (change [rad/m]),
    known by their names. F_prev (C_prev, stretch_prev, ...), stark.TimeStep and stark.Time may follow for
    viscous laws; arguments with the default ``stark.internal(...)`` are what each element
    remembers; all other arguments are parameters as in ``@stark.energy``.

    stress_free, objective: False for a law that has stresses at rest, or depends on the orientation in space,
    on purpose. isotropic: whether the material directions are equivalent, found out by tests if None; cloth
    of other laws takes ``warp_direction``."""
    declared = {
        "stress_free": given_flag(stress_free, "@stark.material: stress_free"),
        "objective": given_flag(objective, "@stark.material: objective"),
        "isotropic": None if isotropic is None else given_flag(isotropic, "@stark.material: isotropic"),
    }
    if function is None:
        return functools.partial(material, **declared)
    name = getattr(function, "__name__", "material")
    signature = signature_of(function, name, dict(sys._getframe(1).f_locals))
    parameters = list(signature.parameters.values())
    if parameters and parameters[0].name in ROD_STRAINS:
        return rod_material(function, name, parameters, declared)
    shape = getattr(parameters[0].annotation, "shape", None) if parameters else None
    if shape not in STRAINS:
        raise formula_error(name, _NEED, function)
    strain = parameters[0].name
    for parameter in parameters[1:]:
        if parameter.name == f"{strain}_prev" and getattr(parameter.annotation, "shape", None) != shape:
            raise formula_error(name, f"'{parameter.name}' must have the type of '{strain}'", function)
    arguments = read_others(parameters[1:], {f"{strain}_prev"}, name, function)
    assert isinstance(parameters[0].annotation, ArgumentType)
    return MaterialLaw(function, (strain, shape), arguments, declared)
