"""Laws of all kinds in one form: expressions of strain, parameters and what is remembered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from stark import _core, materials
from stark._core import InvalidArgument
from stark.formulas.internal import Internal
from stark.formulas.material_law import MaterialLaw
from stark.formulas.parameters import UNBOUNDED
from stark.formulas.parameters import Parameter as LawParameter
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial
from stark.render.laws import membrane_neo_hookean
from stark.symbolic.tensor import Scalar

#: What an input of a law stands for: "x", "x_prev", "time_step", "time" or the name of a parameter or an
#: internal
#: variable, the column of the strain, the component.
Source: TypeAlias = tuple[str, int, int]

_MATERIALS = (SolidMaterial, ShellMaterial, RodMaterial)
_CORE_LAWS = (_core.SolidLaw, _core.ShellLaw, _core.RodLaw)
_NEED = (
    "must be a law or a material: a law of stark.materials such as stark.materials.mooney_rivlin, what "
    "@stark.material makes, stark.j2_plasticity, stark.SolidMaterial for its own law, or a material such as "
    "that of stark.generalized_maxwell(...), whose values the fit starts from"
)


@dataclass(frozen=True)
class FitParameter:
    """A parameter of a law as fits see it."""

    name: str
    shape: tuple[int, ...]
    unit: str
    range: tuple[float, float, bool, bool]
    """Lowest and highest value, and whether they are left out."""
    default: Any


@dataclass(frozen=True)
class LawFormula:
    """A law as expressions of one graph."""

    name: str
    material_type: type[Any]
    outputs: tuple[Scalar, ...]
    """Energy density, then what the internal variables become."""
    inputs: tuple[tuple[Scalar, Source], ...]
    parameters: tuple[FitParameter, ...]
    internals: tuple[Internal, ...]
    law: Any
    """What makes a material: a MaterialLaw, a law of the core, or None for that of the class."""
    base: Any = None
    """A material that the fit was given, or None."""
    given: Any = None
    """What the fit was given."""

    def __reduce__(self) -> tuple[Any, ...]:
        return law_formula, (self.given,)

    @property
    def kind(self) -> str:
        """solid, shell or rod."""
        return {SolidMaterial: "solid", ShellMaterial: "shell", RodMaterial: "rod"}[self.material_type]

    @property
    def needs_time(self) -> bool:
        return any(source[0] in ("time", "time_step") for _, source in self.inputs)

    @property
    def needs_path(self) -> bool:
        """Whether the points of a curve depend on those before."""
        return bool(self.internals) or any(source[0] == "x_prev" for _, source in self.inputs)

    def material(self, values: Mapping[str, Any], fields: Mapping[str, Any]) -> Any:
        """The material with these values of its parameters and further fields."""
        if self.base is not None:
            return self.base.replace(**{**values, **fields})
        if isinstance(self.law, MaterialLaw):
            own = {p.name for p in self.law.parameters}
            return self.law(
                **{k: v for k, v in values.items() if k in own},
                **{**{k: v for k, v in values.items() if k not in own}, **fields},
            )
        return self.material_type(law=self.law, **{**values, **fields})


def law_formula(law: Any) -> LawFormula:
    """The law in one form; InvalidArgument for what is none."""
    return replace(_formula_of(law), given=law)


def _formula_of(law: Any) -> LawFormula:
    base = law if isinstance(law, _MATERIALS) else None
    found = _law_of_material(law) if base is not None else _named(law)
    if isinstance(found, MaterialLaw):
        return _of_recorded(found, base)
    if isinstance(found, _CORE_LAWS):
        return _of_core(found, base, found)
    _refuse_yielding(base)
    if found is RodMaterial:
        linear = next(law for law in _core.rod_laws() if law.name == "linear_rod")
        return _of_core(linear, base, None)
    if found is SolidMaterial:
        return _of_core(materials.solid_laws["stable_neo_hookean"], base, None)
    return _of_membrane(base)


def _refuse_yielding(base: Any) -> None:
    """The laws of shells and rods that yield are not those that are fitted."""
    if base is None:
        return
    limits = {
        ShellMaterial: ("yield_stress", "bending_yield_moment"),
        RodMaterial: ("yield_stress", "yield_force", "yield_moment_1", "yield_moment_2", "yield_torque"),
    }
    for name in limits.get(type(base), ()):
        if (value := float(np.min(getattr(base, name)))) > 0.0 and np.isfinite(value):
            otherwise = "inf" if "stress" in name or type(base) is ShellMaterial else "0"
            raise InvalidArgument(
                f"fit: law = a material with {name} = {value:g}: must be elastic, as yielding of sheets and "
                f"rods is not fitted; use .replace({name}={otherwise}) and the part of the curves below it"
            )


def _named(law: Any) -> Any:
    """The law behind what was given, or a class of materials."""
    if isinstance(law, (MaterialLaw, *_CORE_LAWS)) or (isinstance(law, type) and law in _MATERIALS):
        return law
    name = getattr(law, "__name__", "")
    if name == "generalized_maxwell":
        raise InvalidArgument(
            "fit: law = stark.generalized_maxwell: the number of its branches must be known; give a "
            "material of it with values to start from: stark.generalized_maxwell(shear_modulus=..., "
            "bulk_modulus=..., moduli=[...], times=[...])"
        )
    if name and getattr(materials, name, None) is law:
        known: dict[str, Any] = {**materials.solid_laws, **materials.shell_laws}
        if name in known:
            return known[name]
    raise InvalidArgument(f"fit: law = {law!r}: {_NEED}")


def _law_of_material(material: Any) -> Any:
    if material._recorded is not None:
        recorded = material._recorded[0]
        if isinstance(recorded, MaterialLaw):
            return recorded
        raise InvalidArgument(
            f"fit: law = {material!r}: the law was read from a scene document and is not a function; give "
            f"the law that the document was made with"
        )
    return type(material) if material.law is None else material.law


def _of_recorded(law: MaterialLaw, base: Any) -> LawFormula:
    graph, sources = law.graph(), law.sources
    return LawFormula(
        law.name,
        law.material_type,
        tuple(graph.outputs),
        tuple((node, sources[key]) for key, node in graph.nodes.items() if node.operation == "input"),
        tuple(_recorded_parameter(parameter, base) for parameter in law.parameters),
        law.internals,
        law,
        base,
    )


def _recorded_parameter(parameter: LawParameter, base: Any) -> FitParameter:
    declared = parameter.declaration
    default = declared.default if base is None else _value_in(base, parameter.name)
    if base is not None and parameter.shape:
        default = np.reshape(default, parameter.shape)
    return FitParameter(parameter.name, parameter.shape, parameter.unit, declared.range, default)


def _value_in(base: Any, name: str) -> Any:
    if isinstance(base, RodMaterial) and name in base.section:
        return base.section[name]  # 0 in the material stands for that of the section
    value = getattr(base, name)
    if np.ndim(value) and not name.endswith("direction"):
        width = {row["name"]: row["width"] for row in base.law.parameters}.get(name, 1) if base.law else 1
        if np.size(value) != width:
            raise InvalidArgument(
                f"fit: {name} of the material '{base.name}' has a value for each element: must be one "
                f"value; use .replace({name}=...)"
            )
    return value


def _of_core(law: Any, base: Any, given: Any) -> LawFormula:
    psi, columns, rows = _core.law_density(law)
    inputs: list[tuple[Scalar, Source]] = [
        (entry, ("x", j, i)) for j, column in enumerate(columns) for i, entry in enumerate(column)
    ]
    parameters = []
    for row in rows:
        inputs += [(entry, (row["name"], 0, k)) for k, entry in enumerate(row["inputs"])]
        shape = () if row["width"] == 1 else (row["width"],)
        default = None if base is None else _value_in(base, row["name"])
        parameters.append(FitParameter(row["name"], shape, row["unit"], row["range"], default))
    kind = {_core.SolidLaw: SolidMaterial, _core.ShellLaw: ShellMaterial, _core.RodLaw: RodMaterial}[
        type(law)
    ]
    return LawFormula(law.name, kind, (psi,), tuple(inputs), tuple(parameters), (), given, base)


def _of_membrane(base: Any) -> LawFormula:
    """The law of ShellMaterial itself, which the core has in metrics of edges [theory eq. 11]."""
    formula = membrane_neo_hookean.formula
    ranges = {row["name"]: row["range"] for row in _core.law_density(materials.solid_laws["neo_hookean"])[2]}
    inputs: list[tuple[Scalar, Source]] = []
    parameters = []
    for argument in formula.arguments:
        if argument.name == "F":
            inputs += [(entry, ("x", k % 2, k // 2)) for k, entry in enumerate(argument.entries)]
            continue
        inputs.append((argument.entries[0], (argument.name, 0, 0)))
        unit = "Pa" if argument.name == "youngs_modulus" else "1"
        default = None if base is None else _value_in(base, argument.name)
        limits = ranges.get(argument.name, UNBOUNDED)
        parameters.append(FitParameter(argument.name, (), unit, limits, default))
    outputs = tuple(formula.outputs)
    return LawFormula(formula.name, ShellMaterial, outputs, tuple(inputs), tuple(parameters), (), None, base)


def flexural_rigidity(base: Any) -> FitParameter:
    """What bending curves of shells determine."""
    value = None if base is None else _value_in(base, "flexural_rigidity")
    return FitParameter("flexural_rigidity", (), "N m", (0.0, np.inf, True, True), value or None)


def names_of(parameters: Sequence[FitParameter]) -> str:
    return ", ".join(parameter.name for parameter in parameters)
