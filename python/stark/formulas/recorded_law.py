"""Constitutive laws as formulas: strains, parameters, and what of them is recorded."""

from __future__ import annotations

import functools
import inspect
import threading
from collections.abc import Callable, Hashable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from stark import _core
from stark._core import InvalidArgument
from stark.formulas.arguments import ClockArgument, read_clock, read_parameter
from stark.formulas.captured import captured, warn_of_changes
from stark.formulas.internal import Internal, read_internal, split_result
from stark.formulas.kinematics import Inputs
from stark.formulas.parameters import Parameter, check_range, numbers_of
from stark.formulas.statistics import FormulaStatistics
from stark.formulas.tracing import clock_symbol, parameter_symbols, scalar_result, unused_text
from stark.symbolic.errors import definition_of, formula_error, recording
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Mat, Scalar, columns

Sources: TypeAlias = Mapping[int, tuple[str, int, int]]

_RESERVED = frozenset({"law", "name", "source", "base", "time", "time_step", "thickness", "warp_direction"})
ROD_STRAINS = ("stretch", "curvature", "twist")
STRAINS: dict[tuple[int, ...], tuple[str, str]] = {
    (3, 3): ("F", "solid"),
    (3, 2): ("F", "shell"),
    (2, 2): ("C", "shell"),
}


@dataclass(frozen=True)
class Past:
    """The strain at the start of the time step, for viscous laws: an argument F_prev or C_prev."""

    name: str


LawArgument: TypeAlias = Parameter | ClockArgument | Past | Internal


class RecordedLaw:
    """A constitutive law as a formula: a function of strains and parameters that is recorded once."""

    def __init__(
        self,
        function: Callable[..., object],
        strain: tuple[str, tuple[int, ...]],
        arguments: Sequence[LawArgument],
        declared: Mapping[str, bool | None],
    ) -> None:
        self.name: str = function.__name__
        self.doc: str = inspect.getdoc(function) or self.name
        self.arguments: tuple[LawArgument, ...] = tuple(arguments)
        self._function = function
        self._strain = strain
        self.declared: dict[str, bool | None] = dict(declared)
        self._recorded: tuple[_core.Formula, ExpressionGraph, Sources] | None = None
        self._captured: dict[str, Hashable] = {}
        self._lock = threading.Lock()
        # What makes it again, a function and its arguments, where it is not found by its name.
        self._origin: tuple[Any, ...] | None = None
        self.__qualname__: str  # of the function
        functools.update_wrapper(self, function)  # type: ignore[arg-type]
        shown = [
            inspect.Parameter(p.name, inspect.Parameter.KEYWORD_ONLY, default=p.declaration.default)
            for p in self.parameters
        ]
        others = inspect.Parameter("of_material", inspect.Parameter.VAR_KEYWORD)
        self.__signature__: inspect.Signature = inspect.Signature([*shown, others])

    def __reduce__(self) -> str | tuple[Any, ...]:
        # Pickled by name, as functions are, or made again.
        return self.__qualname__ if self._origin is None else self._origin

    @property
    def is_solid(self) -> bool:
        """Whether it is a law of solids, else of shells."""
        return STRAINS[self._strain[1]][1] == "solid"

    @property
    def directions(self) -> int:
        """Number of material directions: columns of the deformation gradient."""
        return 3 if self.is_solid else 2

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Its parameters, in the order of the function."""
        return tuple(a for a in self.arguments if isinstance(a, Parameter))

    @property
    def internals(self) -> tuple[Internal, ...]:
        """What it remembers, in order."""
        return tuple(a for a in self.arguments if isinstance(a, Internal))

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

    def value(self, parameter: Parameter, given: Any) -> np.ndarray:
        """A value of a parameter as an array of its shape, or with one value for each element. Raises
        InvalidArgument where none is given, and for another shape."""
        if given is None:
            rule = parameter.declaration.rule
            raise InvalidArgument(
                f"{self.name}: {parameter.describe()} has no value: must be given"
                + (f", {rule}" if rule else "")
            )
        array = numbers_of(self.name, parameter, given)
        own = len(parameter.shape)
        is_shaped = array.shape[max(array.ndim - own, 0) :] == parameter.shape
        if not is_shaped or array.ndim > own + 1 or array.size == 0:
            raise InvalidArgument(
                f"{self.name}: {parameter.describe()} has the shape {array.shape}: must be "
                f"{parameter.shape}, or have one leading dimension more with a value for each element"
            )
        check_range(self.name, parameter, array, array.ndim > own)
        return array

    @property
    def sources(self) -> Sources:
        """What the inputs of the graph are, by number: of what, which column, which component."""
        return self._trace()[2]

    def _trace(self) -> tuple[_core.Formula, ExpressionGraph, Sources]:
        with self._lock:
            if self._recorded is None:
                self._captured = captured(self._function)
                self._recorded = self._record()
            return self._recorded

    def _warn_of_changes(self) -> None:
        """Of numbers around the function that are not what they were when it was recorded."""
        if self._recorded is not None:
            warn_of_changes(self.name, "law", self._function, self._captured, self.location)

    @property
    def function(self) -> Callable[..., object]:
        """What was decorated."""
        return self._function

    def results(self, inputs: Inputs) -> tuple[Scalar, list[Scalar]]:
        """The energy and the new values of all internal variables, of one run of the function."""
        values: list[object] = self._strains(inputs)
        for argument in self.arguments:
            if isinstance(argument, Past):
                values.append(self._past(inputs, argument))
            elif isinstance(argument, ClockArgument):
                values.append(clock_symbol(inputs, argument))
            elif isinstance(argument, Internal):
                values.append(argument.symbols(inputs))
            else:
                values.append(parameter_symbols(inputs, argument))
        with recording(self.name):
            result = self._function(*values)
        result, updates = split_result(self.name, result, self.internals, self._function)
        return scalar_result(self.name, result, self._function), updates

    def _record(self) -> tuple[_core.Formula, ExpressionGraph, Sources]:
        inputs = Inputs(list(range(self._point_count)))
        output, updates = self.results(inputs)
        title = f"{self.name}({', '.join([*self._strain_names, *(a.name for a in self.arguments)])})"
        graph = ExpressionGraph(title, [output, *updates])
        for name in self._strain_names:
            if not any(node in graph.nodes for node in inputs.nodes_of(name)):
                raise formula_error(self.name, f"the energy does not depend on {name}", self._function)
        formula = inputs.builder.finish([output, *updates])
        known = {row["name"] for row in formula.fields}
        for argument in self.arguments:
            if isinstance(argument, Internal):
                continue
            occurs = (
                argument.name in known
                if isinstance(argument, Parameter)
                else any(node in graph.nodes for node in inputs.nodes_of(argument.name))
            )
            if not occurs:
                raise formula_error(self.name, unused_text(argument.name), self._function)
        return formula, graph, inputs.sources

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


def read_others(
    parameters: Sequence[inspect.Parameter], pasts: Set[str], name: str, function: Callable[..., object]
) -> list[LawArgument]:
    """Arguments behind the strains: strains of the past, which have the names `pasts`, clocks, parameters."""
    arguments: list[LawArgument] = []
    for parameter in parameters:
        clock = read_clock(parameter)
        variable = read_internal(parameter, name, function)
        if clock is not None:
            arguments.append(clock)
        elif variable is not None:
            arguments.append(variable)
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
