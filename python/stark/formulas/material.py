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
import inspect
import sys
import threading
import warnings
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any

import numpy as np

from stark import _core
from stark._core import InvalidArgument
from stark.formulas import law_checks
from stark.formulas.arguments import ClockArgument, read_clock, read_parameter, signature_of
from stark.formulas.inspection import FormulaStatistics
from stark.formulas.kinematics import Inputs
from stark.formulas.parameters import Parameter, check_range, numbers_of
from stark.formulas.tracing import clock_symbol, parameter_symbols, scalar_result, unused_text
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial
from stark.symbolic.errors import definition_of, formula_error, recording
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.signature import ArgumentType, Matrix
from stark.symbolic.tensor import Mat, columns

DeformationGradient = Matrix[3, 3]
ShellDeformationGradient = Matrix[3, 2]
CauchyGreen = Matrix[2, 2]

_RESERVED = frozenset({"law", "name", "source", "base", "time", "time_step", "thickness", "warp_direction"})
ROD_STRAINS = ("stretch", "curvature", "twist")
_STRAINS = {
    (3, 3): ("F", "solid"),
    (3, 2): ("F", "shell"),
    (2, 2): ("C", "shell"),
}
_NEED = (
    "the first argument must be the strain: F: stark.DeformationGradient (3x3, solids), "
    "F: stark.ShellDeformationGradient (3x2) or C: stark.CauchyGreen (2x2, shells), or arguments named "
    "stretch, curvature, twist (rods)"
)


@dataclass(frozen=True)
class Past:
    """The strain at the start of the time step, for viscous laws: an argument F_prev or C_prev."""

    name: str


class MaterialLaw:
    """A constitutive law; what ``@stark.material`` makes of a function. Calling it with values gives a
    material for ``add_solid`` or ``add_cloth``."""

    def __init__(
        self,
        function: Callable[..., object],
        strain: tuple[str, tuple[int, ...]],
        arguments: Sequence[Parameter | ClockArgument | Past],
        declared: Mapping[str, bool | None],
    ) -> None:
        self.name = function.__name__
        self.doc = inspect.getdoc(function) or self.name
        self.arguments = tuple(arguments)
        self._function = function
        self._strain = strain
        self.declared = dict(declared)
        self._recorded: tuple[_core.Formula, ExpressionGraph] | None = None
        self._lock = threading.Lock()
        functools.update_wrapper(self, function)
        shown = [
            inspect.Parameter(p.name, inspect.Parameter.KEYWORD_ONLY, default=p.declaration.default)
            for p in self.parameters
        ]
        others = inspect.Parameter("of_material", inspect.Parameter.VAR_KEYWORD)
        self.__signature__ = inspect.Signature([*shown, others])

    def __call__(
        self,
        *args: Any,
        base: SolidMaterial | ShellMaterial | RodMaterial | None = None,
        name: str = "",
        **given: Any,
    ) -> Any:
        """A material of this law. Keywords are the parameters of the law, each a number or an array with a
        value for each element, and those of the material (density, thickness, damping, ...), which come from
        ``base`` where they are left out. Called with a strain instead: its energy density."""
        if args:
            return self._function(*args, **given)
        kind = self.material_type
        if base is not None and not isinstance(base, kind):
            raise InvalidArgument(
                f"{self.name}: base = {base!r}: must be a stark.{kind.__name__}, for which the law is"
            )
        values = {p.name: self._value(p, given.pop(p.name, p.declaration.default)) for p in self.parameters}
        self.checked(values)
        inherited = {} if base is None else base._core.to_dict()
        flat = {p.name: _flattened(p, values[p.name]) for p in self.parameters}
        return kind(law=self.law(values), name=name or self.name, **{**inherited, **given, **flat})

    @property
    def material_type(self) -> type[Any]:
        """The class of its materials."""
        return SolidMaterial if self.is_solid else ShellMaterial

    @property
    def is_solid(self) -> bool:
        """Whether it is a law of solids, else of shells."""
        return _STRAINS[self._strain[1]][1] == "solid"

    @property
    def directions(self) -> int:
        """Number of material directions: columns of the deformation gradient."""
        return 3 if self.is_solid else 2

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(a for a in self.arguments if isinstance(a, Parameter))

    @property
    def formula(self) -> _core.Formula:
        """The recorded formula of the columns of F."""
        return self._trace()[0]

    def graph(self) -> ExpressionGraph:
        """The recorded operations; print it for a listing."""
        return self._trace()[1]

    @property
    def statistics(self) -> FormulaStatistics:
        """Counts of the energy density as a function of F."""
        return FormulaStatistics.of(self.formula)

    @property
    def location(self) -> str:
        """Where the function is defined."""
        return definition_of(self._function)

    def check(self, **given: Any) -> Any:
        """Tests the law with these parameters: rest state, objectivity, isotropy, derivatives, stability.
        Returns a report; print it."""
        values = {p.name: self._value(p, given.pop(p.name, p.declaration.default)) for p in self.parameters}
        return law_checks.check(self, values)

    def checked(self, values: Mapping[str, np.ndarray]) -> None:
        """Raises InvalidArgument for a law that is not finite or has stresses at rest, and warns of one that
        is not objective or not stable, unless it is declared so."""
        for problem in self._problems(values):
            if problem.is_error:
                raise InvalidArgument(f"{problem.text}\n{self.location}")
            from stark.scene import StarkWarning

            warnings.warn(f"{problem.text}\n{self.location}", StarkWarning, stacklevel=3)

    def _problems(self, values: Mapping[str, np.ndarray]) -> list[law_checks.Problem]:
        return law_checks.problems(self, values)

    def law(self, values: Mapping[str, np.ndarray]) -> Any:
        """The law of the core."""
        make = _core.solid_law if self.is_solid else _core.shell_law
        isotropic = self.declared["isotropic"]
        if isotropic is None:
            isotropic = law_checks.is_isotropic(self, values)
        return make(self.name, self.doc, self.formula, isotropic)

    def _value(self, parameter: Parameter, given: Any) -> np.ndarray:
        if given is None:
            rule = parameter.declaration.rule
            raise InvalidArgument(
                f"{self.name}: {parameter.describe()} has no value: must be given"
                + (f", {rule}" if rule else "")
            )
        array = numbers_of(self.name, parameter, given)
        own = len(parameter.shape)
        if array.shape[max(array.ndim - own, 0) :] != parameter.shape or array.ndim > own + 1:
            raise InvalidArgument(
                f"{self.name}: {parameter.describe()} has the shape {array.shape}: must be "
                f"{parameter.shape}, or have one leading dimension more with a value for each element"
            )
        check_range(self.name, parameter, array, array.ndim > own)
        return array

    def _trace(self) -> tuple[_core.Formula, ExpressionGraph]:
        with self._lock:
            if self._recorded is None:
                self._recorded = self._record()
            return self._recorded

    def _record(self) -> tuple[_core.Formula, ExpressionGraph]:
        inputs = Inputs(list(range(self._point_count)))
        values: list[object] = self._strains(inputs)
        for argument in self.arguments:
            if isinstance(argument, Past):
                values.append(self._past(inputs, argument))
            elif isinstance(argument, ClockArgument):
                values.append(clock_symbol(inputs, argument))
            else:
                values.append(parameter_symbols(inputs, argument))
        with recording(self.name):
            result = self._function(*values)
        output = scalar_result(self.name, result, self._function)
        title = f"{self.name}({', '.join([*self._strain_names, *(a.name for a in self.arguments)])})"
        graph = ExpressionGraph(title, [output])
        for name in self._strain_names:
            if not any(node in graph.nodes for node in inputs.nodes_of(name)):
                raise formula_error(self.name, f"the energy does not depend on {name}", self._function)
        formula = inputs.builder.finish([output])
        known = {row["name"] for row in formula.fields}
        for argument in self.arguments:
            occurs = (
                argument.name in known
                if isinstance(argument, Parameter)
                else any(node in graph.nodes for node in inputs.nodes_of(argument.name))
            )
            if not occurs:
                raise formula_error(self.name, unused_text(argument.name), self._function)
        return formula, graph

    @property
    def _point_count(self) -> int:
        """Points of the formula."""
        return self.directions

    @property
    def _strain_names(self) -> tuple[str, ...]:
        """The arguments that are strains; they come first."""
        return (self._strain[0],)

    def _strains(self, inputs: Inputs) -> list[object]:
        return [self._strain_symbols(inputs, "x", self._strain[0])]

    def _past(self, inputs: Inputs, argument: Past) -> object:
        return self._strain_symbols(inputs, "x_prev", argument.name)

    def _strain_symbols(self, inputs: Inputs, kind: str, label: str) -> Mat:
        """F, or C of it, from the columns that are the points of the formula."""
        F = columns([inputs.column(j, kind, label) for j in range(self.directions)])
        return F.T @ F if self._strain[1] == (2, 2) else F

    def __repr__(self) -> str:
        return f"<stark.material {self.name}{self.__signature__}>"


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
    viscous laws; all other arguments are parameters as in ``@stark.energy``.

    stress_free, objective: False for a law that has stresses at rest, or depends on the orientation in space,
    on purpose. isotropic: whether the material directions are equivalent, found out by tests if None; cloth
    of other laws takes ``warp_direction``."""
    declared = {"stress_free": stress_free, "objective": objective, "isotropic": isotropic}
    if function is None:
        return functools.partial(material, **declared)
    name = getattr(function, "__name__", "material")
    signature = signature_of(function, name, dict(sys._getframe(1).f_locals))
    parameters = list(signature.parameters.values())
    if parameters and parameters[0].name in ROD_STRAINS:
        from stark.formulas.rod_material import rod_material

        return rod_material(function, name, parameters, declared)
    shape = getattr(parameters[0].annotation, "shape", None) if parameters else None
    if shape not in _STRAINS:
        raise formula_error(name, _NEED, function)
    strain = parameters[0].name
    for parameter in parameters[1:]:
        if parameter.name == f"{strain}_prev" and getattr(parameter.annotation, "shape", None) != shape:
            raise formula_error(name, f"'{parameter.name}' must have the type of '{strain}'", function)
    arguments = read_others(parameters[1:], {f"{strain}_prev"}, name, function)
    assert isinstance(parameters[0].annotation, ArgumentType)
    return MaterialLaw(function, (strain, shape), arguments, declared)


def read_others(
    parameters: Sequence[inspect.Parameter], pasts: Set[str], name: str, function: Callable[..., object]
) -> list[Parameter | ClockArgument | Past]:
    """Arguments behind the strains: strains of the past, which have the names `pasts`, clocks, parameters."""
    arguments: list[Parameter | ClockArgument | Past] = []
    for parameter in parameters:
        clock = read_clock(parameter)
        if clock is not None:
            arguments.append(clock)
        elif parameter.name in pasts:
            arguments.append(Past(parameter.name))
        elif parameter.name in _RESERVED:
            raise formula_error(
                name, f"a parameter of a law must not be called '{parameter.name}'; choose another", function
            )
        else:
            arguments.append(
                read_parameter(parameter, name, function, "float, stark.Vec3, stark.Mat3 or stark.TimeStep")
            )
    return arguments


def _flattened(parameter: Parameter, value: np.ndarray) -> Any:
    """As materials hold it: matrices in a row."""
    if not parameter.shape:
        return float(value) if value.ndim == 0 else value
    return value.reshape(*value.shape[: value.ndim - len(parameter.shape)], -1)
