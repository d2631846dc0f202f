"""``@stark.material`` for rods: laws of stretch, curvature and twist.

    @stark.material
    def kirchhoff(
        stretch, curvature, twist,
        EA: float = stark.parameter(unit="N", above=0.0),
        EI: float = stark.parameter(unit="N m^2", above=0.0),
        GJ: float = stark.parameter(unit="N m^2", above=0.0),
    ):
        bending = curvature[0] ** 2 + curvature[1] ** 2
        return 0.5 * (EA * (stretch - 1) ** 2 + EI * bending + GJ * twist**2)

    scene.add_rod(points, kirchhoff(EA=10.0, EI=1e-4, GJ=1e-4, density=1000.0, radius=1e-3))

The result is the stored energy per rest length [J/m]. Strains are those of src/stark/mechanics/rod_law.h."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from stark import _core
from stark.formulas import rod_checks
from stark.formulas.kinematics import Inputs
from stark.formulas.law_checks import Problem
from stark.formulas.material_law import MaterialLaw
from stark.formulas.recorded_law import ROD_STRAINS, LawArgument, Past, read_others
from stark.materials import RodMaterial
from stark.symbolic.errors import formula_error
from stark.symbolic.signature import ArgumentType
from stark.symbolic.tensor import Scalar, Vec

_SHAPES = {"stretch": (), "curvature": (2,), "twist": ()}


class RodMaterialLaw(MaterialLaw):
    """A law of rods. Calling it with values gives a material for ``add_rod``."""

    def __init__(
        self,
        function: Callable[..., object],
        strains: Sequence[str],
        arguments: Sequence[LawArgument],
        declared: Mapping[str, bool | None],
    ) -> None:
        super().__init__(function, ("stretch", ()), arguments, declared)
        self._names = tuple(strains)

    @property
    def material_type(self) -> type[Any]:
        return RodMaterial

    @property
    def is_solid(self) -> bool:
        return False

    @property
    def directions(self) -> int:
        return 1

    def check(self, **given: Any) -> Any:
        """Tests the law with these parameters: rest state, derivatives, stability. Returns a report; print
        it."""
        values = {p.name: self.value(p, given.pop(p.name, p.declaration.default)) for p in self.parameters}
        return rod_checks.check(self, values)

    def law(self, values: Mapping[str, np.ndarray]) -> Any:
        """The law of the core."""
        return _core.rod_law(self.name, self.doc, self.formula)

    def _is_isotropic(self, values: Mapping[str, np.ndarray]) -> bool:
        return True  # its strains know no directions of the material

    def _problems(self, values: Mapping[str, np.ndarray]) -> list[Problem]:
        return rod_checks.problems(self, values)

    @property
    def _point_count(self) -> int:
        return 2  # (0, 0, stretch) and (curvature 1, curvature 2, twist)

    @property
    def _rest_points(self) -> np.ndarray:
        return np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])

    @property
    def _strain_names(self) -> tuple[str, ...]:
        return self._names

    def _strains(self, inputs: Inputs) -> list[object]:
        return [self._strain_of(inputs, "x", name, name) for name in self._names]

    def _past(self, inputs: Inputs, argument: Past) -> object:
        return self._strain_of(inputs, "x_prev", argument.name.removesuffix("_prev"), argument.name)

    def _strain_of(self, inputs: Inputs, kind: str, strain: str, label: str) -> Scalar | Vec:
        if strain == "curvature":
            value = Vec(getattr(inputs.builder, kind)(1))
            for i in range(2):
                inputs.strain(value[i], (kind, 1, i), label, f"{label}[{i}]")
            return Vec([value[0], value[1]])
        point = 0 if strain == "stretch" else 1
        entry = Vec(getattr(inputs.builder, kind)(point))[2]
        inputs.strain(entry, (kind, point, 2), label, label)
        return entry


def rod_material(
    function: Callable[..., object],
    name: str,
    parameters: Sequence[inspect.Parameter],
    declared: Mapping[str, bool | None],
) -> RodMaterialLaw:
    """The law of a function whose first arguments are strains of rods."""
    strains: list[str] = []
    for parameter in parameters:
        if parameter.name not in ROD_STRAINS:
            break
        strains.append(parameter.name)
    for parameter in parameters:
        strain = parameter.name.removesuffix("_prev")
        if strain not in ROD_STRAINS:
            continue
        if parameter.name == strain and parameter.name not in strains:
            raise formula_error(
                name, f"'{strain}' must come before all other arguments, with the other strains", function
            )
        _check_annotation(parameter, strain, name, function)
    pasts = {f"{strain}_prev" for strain in ROD_STRAINS}
    others = read_others(parameters[len(strains) :], pasts, name, function)
    return RodMaterialLaw(function, strains, others, declared)


def _check_annotation(
    parameter: inspect.Parameter, strain: str, name: str, function: Callable[..., object]
) -> None:
    kind = parameter.annotation
    if kind is parameter.empty:
        return
    shape = () if kind in (float, Scalar) else kind.shape if isinstance(kind, ArgumentType) else None
    if shape != _SHAPES[strain]:
        need = "stark.Vec2" if strain == "curvature" else "float"
        raise formula_error(
            name, f"'{parameter.name}' has the annotation {kind!r}: must be {need}, or none", function
        )
