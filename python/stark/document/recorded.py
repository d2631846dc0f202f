"""Formulas of users as data, and back: what ``@stark.energy``, ``@stark.material``, ``@stark.joint`` and
``@stark.actuator`` recorded. Nothing of the Python functions is kept; to read them executes nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from stark import _core
from stark.actuators.definition import ActuatorFormula
from stark.formulas.energy import EnergyFormula
from stark.formulas.internal import Internal, InternalDeclaration
from stark.formulas.listing import OPERATIONS, Input, listed, replayed, stages_of
from stark.formulas.parameters import UNBOUNDED, Declaration, Parameter
from stark.formulas.totals import totals_of
from stark.formulas.tracing import Trace, is_translation_invariant
from stark.joints.definition import JointFormula
from stark.symbolic.graph import ExpressionGraph

from .errors import DocumentError

_INFINITE: dict[Any, float] = {"inf": math.inf, "-inf": -math.inf}

Sources = Mapping[int, tuple[str, int, int]]


# --- to data ---


def of_energy(binding: Any) -> dict[str, Any]:
    trace = binding.trace
    return {
        "kind": "energy",
        **_described(binding.name, binding.energy.doc, trace.formula, trace.graph, trace.sources,
                     binding.energy.parameters),
        **({} if trace.totals is None else {"totals": list(trace.totals.names)}),
        "translation_invariant": bool(binding.translation_invariant),
    }  # fmt: skip


def of_law(function: Any, isotropic: bool, law: Any) -> dict[str, Any]:
    """Of a material: ``function`` is a MaterialLaw or a ReadLaw, ``law`` what the core has of it."""
    kind = {"SolidLaw": "solid_law", "ShellLaw": "shell_law", "RodLaw": "rod_law"}[type(law).__name__]
    described = _described(
        law.name, law.doc, function.formula, function.graph(), function.sources, function.parameters
    )
    internals = [
        {
            "name": variable.name,
            "shape": list(variable.shape),
            "unit": variable.declaration.unit,
            "doc": variable.declaration.doc,
            "initial": variable.initial,
        }
        for variable in function.internals
    ]
    options = {} if kind == "rod_law" else {"isotropic": isotropic}
    return {"kind": kind, **described, "internals": internals, **options}


def of_joint(formula: JointFormula) -> dict[str, Any]:
    assert formula.residuals is not None
    return {
        "kind": "joint",
        **_described(formula.name, formula.doc, formula.recorded, formula.residuals, formula.sources,
                     formula.parameters),
        "holds": [{"unit": unit, "count": count} for unit, count in formula.groups],
        "coordinates": [{"name": name, "unit": unit} for name, unit in formula.coordinates],
    }  # fmt: skip


def of_actuator(formula: ActuatorFormula) -> dict[str, Any]:
    assert formula.outputs is not None
    return {
        "kind": "actuator",
        **_described(formula.name, formula.doc, formula.recorded, formula.outputs, formula.sources,
                     formula.parameters),
        "coordinates": formula.coordinate_count,
        "one_sided": list(formula.one_sided),
        "memories": list(formula.memories),
    }  # fmt: skip


def _described(
    name: str,
    doc: str,
    formula: Any,
    graph: ExpressionGraph,
    sources: Sources,
    parameters: Sequence[Parameter],
) -> dict[str, Any]:
    known = {parameter.name: parameter for parameter in parameters}
    nodes, outputs = listed(graph, sources)
    return {
        "name": name,
        "doc": doc,
        "points": formula.point_count,
        "inputs": [_input(row, known.get(row["name"])) for row in formula.fields],
        "nodes": [[_number(entry) for entry in node] for node in nodes],
        "outputs": outputs,
        **({"stages": stages} if (stages := stages_of(graph)) else {}),
    }


def _input(row: Mapping[str, Any], parameter: Parameter | None) -> dict[str, Any]:
    low, high, low_open, high_open = UNBOUNDED if parameter is None else parameter.declaration.range
    shape = ([] if row["width"] == 1 else [row["width"]]) if parameter is None else list(parameter.shape)
    role = "data" if row["is_data"] else "constant" if parameter is None else "parameter"
    default = None if parameter is None else parameter.declaration.default
    return {
        "name": row["name"],
        "shape": shape,
        "unit": row["unit"],
        "doc": row["doc"],
        "range": [_number(low), _number(high)],
        "open": [low_open, high_open],
        "role": role,
        "default": _number(float(default)) if isinstance(default, (int, float)) else None,
    }


def _number(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return "inf" if value > 0.0 else "-inf"
    return value


# --- from data ---


class ReadFormula(EnergyFormula):
    """An energy of a document: as what ``@stark.energy`` makes, without a function."""

    is_read = True

    def __init__(self, row: Mapping[str, Any], trace: Trace, parameters: Sequence[Parameter]) -> None:
        # Not that of the base, which reads a function.
        self.name: str = row["name"]
        self.doc: str = row["doc"]
        self.arguments: tuple[Parameter, ...] = tuple(parameters)
        self._declared_invariant = row["translation_invariant"]
        self._trace_read = trace

    def trace(self, frames: Sequence[str] = (), spanning: Sequence[str] = ()) -> Trace:
        return self._trace_read

    @property
    def location(self) -> str:
        return "of a scene document"

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        raise DocumentError(
            f"{self.name}: was read from a scene document, which has no function to call; "
            f"check() of its handle in scene.energies goes without"
        )

    def __repr__(self) -> str:
        return f"<stark.energy {self.name} of a scene document>"


def made(row: Mapping[str, Any], where: str) -> Any:
    """A ReadFormula, a law of the core, a JointFormula or an ActuatorFormula."""
    _check_nodes(row, where)
    parameters = [_parameter(entry) for entry in row["inputs"] if entry["role"] == "parameter"]
    try:
        formula, graph, sources = replayed(
            row["points"], [_row(entry) for entry in row["inputs"]], row["nodes"], row["outputs"],
            _internals(row), row.get("stages", ()),
            row.get("totals"),
        )  # fmt: skip
        return _MAKERS[row["kind"]](row, formula, graph, sources, parameters)
    except DocumentError:
        raise
    except (_core.Error, KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        text = f"no input {error}" if isinstance(error, KeyError) else str(error)
        raise DocumentError(f"{where} '{row['name'][:80]}': {text}") from error


def _internals(row: Mapping[str, Any]) -> tuple[Internal, ...]:
    """Internal variables of a law."""
    made = []
    for entry in row.get("internals", ()):
        if len(entry["initial"]) != _width(entry):
            raise DocumentError(
                f"internal variable '{entry['name'][:80]}' has {len(entry['initial'])} initial numbers: "
                f"must be {_width(entry)}"
            )
        initial = np.array(entry["initial"], dtype=np.float64).reshape(entry["shape"])
        declaration = InternalDeclaration(initial, entry["unit"], entry["doc"])
        made.append(Internal(entry["name"], tuple(entry["shape"]), declaration))
    return tuple(made)


def _check_nodes(row: Mapping[str, Any], where: str) -> None:
    for k, node in enumerate(row["nodes"]):
        place = f"{where}.nodes[{k}]"
        operation, operands = (node[0], node[1:]) if node else ("", [])
        if operation == "constant":
            node[1:] = [_INFINITE.get(operand, operand) for operand in operands]
            if len(operands) != 1 or not isinstance(node[1], float):
                raise DocumentError(f'{place}: must be ["constant", value]')
        elif operation == "input":
            whole = [float(number).is_integer() for number in operands[1:] if isinstance(number, float)]
            if len(operands) != 3 or not isinstance(operands[0], str) or whole != [True, True]:
                raise DocumentError(f'{place}: must be ["input", source, point, component]')
            node[2:] = [int(number) for number in operands[1:]]
        elif operation in OPERATIONS:
            _check_operands(node, k, OPERATIONS[operation][0], place)
        else:
            raise DocumentError(f"{place}: unknown operation {str(operation)[:40]!r}")
    if not row["outputs"] or max(row["outputs"]) >= len(row["nodes"]):
        raise DocumentError(f"{where}.outputs: must be numbers of nodes")
    if row.get("stages") and max(row["stages"]) >= len(row["nodes"]):
        raise DocumentError(f"{where}.stages: must be numbers of nodes")


def _check_operands(node: list[Any], k: int, count: int, place: str) -> None:
    numbers = node[1:]
    if len(numbers) != count or not all(
        isinstance(n, float) and n.is_integer() and 0 <= n < k for n in numbers
    ):
        raise DocumentError(f"{place}: must have {count} operands, numbers of nodes before it")
    node[1:] = [int(n) for n in numbers]


def _row(entry: Mapping[str, Any]) -> Input:
    limits = (*_ends(entry), entry["open"][0], entry["open"][1])
    return (
        entry["name"], _width(entry), entry["unit"], entry["doc"] or entry["name"], limits,
        entry["role"] == "data",
    )  # fmt: skip


def _ends(entry: Mapping[str, Any]) -> tuple[float, float]:
    low, high = entry["range"]
    return low, high


def _width(entry: Mapping[str, Any]) -> int:
    width = int(math.prod(entry["shape"]))
    if width > 1000:
        raise DocumentError(f"input '{entry['name'][:80]}' has {width} numbers: must be at most 1000")
    return width


def _parameter(entry: Mapping[str, Any]) -> Parameter:
    low, high = _ends(entry) if len(entry["range"]) == 2 else (-math.inf, math.inf)
    low_open, high_open = entry["open"] if len(entry["open"]) == 2 else (True, True)
    declaration = Declaration(
        entry["default"],
        entry["unit"],
        None if low_open or low == -math.inf else low,
        None if high_open or high == math.inf else high,
        low if low_open and low > -math.inf else None,
        high if high_open and high < math.inf else None,
        entry["doc"],
    )
    return Parameter(entry["name"], tuple(entry["shape"]), declaration)


def _energy(
    row: Mapping[str, Any], formula: Any, graph: Any, sources: Sources, given: list[Parameter]
) -> ReadFormula:
    count = row["points"]
    unknowns = {key: component for key, (source, _, component) in sources.items() if source == "x"}
    if len(graph.outputs) != 1 or not unknowns or not 1 <= count <= 8:
        raise DocumentError(
            f"'{row['name'][:80]}': must have one output, and 1 to 8 points that it depends on"
        )
    if graph.outputs[0].is_condition:
        raise DocumentError(f"'{row['name'][:80]}': its output is a condition: must be a number")
    trace = Trace(
        formula,
        graph,
        tuple(range(count)),
        tuple(field["name"] for field in formula.fields),
        is_translation_invariant(graph.outputs[0], unknowns),
        tuple(f"p[{k}]" for k in range(count)),
        dict(sources),
        totals_of(graph.outputs[0], sources),
    )
    return ReadFormula(row, trace, given)


def _law(
    row: Mapping[str, Any], formula: Any, graph: Any, sources: Sources, given: list[Parameter]
) -> ReadLaw:
    points = {"solid_law": 3, "shell_law": 2, "rod_law": 2}[row["kind"]]
    internals = _internals(row)
    count = 1 + sum(len(variable.initial) for variable in internals)
    if row["points"] != points or len(graph.outputs) != count or any(o.is_condition for o in graph.outputs):
        raise DocumentError(
            f"'{row['name'][:80]}': must have {points} points and {count} outputs, which are numbers"
        )
    make: Callable[..., Any] = getattr(_core, row["kind"])
    options = () if row["kind"] == "rod_law" else (row["isotropic"],)
    core = make(row["name"], row["doc"] or row["name"], formula, *options)
    return ReadLaw(core, formula, graph, dict(sources), tuple(given), row.get("isotropic", True), internals)


class ReadLaw:
    """The law of a document: what it takes to save it again, in place of a function."""

    def __init__(
        self,
        core: Any,
        formula: Any,
        graph: ExpressionGraph,
        sources: Sources,
        parameters: tuple[Parameter, ...],
        isotropic: bool,
        internals: tuple[Internal, ...],
    ) -> None:
        self.core: Any = core
        self.formula: Any = formula
        self.sources: Sources = sources
        self.parameters: tuple[Parameter, ...] = parameters
        self._graph = graph
        self.isotropic: bool = isotropic
        self.internals: tuple[Internal, ...] = internals

    def graph(self) -> ExpressionGraph:
        return self._graph


def _joint(
    row: Mapping[str, Any], formula: Any, graph: Any, sources: Sources, given: list[Parameter]
) -> JointFormula:
    groups = tuple((hold["unit"], hold["count"]) for hold in row["holds"])
    coordinates = [(c["name"], c["unit"]) for c in row["coordinates"]]
    if row["points"] != 8 or len(graph.outputs) != sum(n for _, n in groups) + len(coordinates):
        raise DocumentError(
            f"'{row['name'][:80]}': must have 8 points, and an output for each residual and coordinate"
        )
    doc = row["doc"] or row["name"]
    core = _core.make_joint(row["name"], doc, formula, list(groups), coordinates)
    return JointFormula(
        row["name"], doc, tuple(given), core, graph, dict(sources), groups, "of a scene document", formula
    )


def _actuator(
    row: Mapping[str, Any], formula: Any, graph: Any, sources: Sources, given: list[Parameter]
) -> ActuatorFormula:
    rows, memories = list(row["one_sided"]), list(row["memories"])
    if row["points"] != 1 or len(graph.outputs) != 1 + len(rows) + len(memories):
        raise DocumentError(
            f"'{row['name'][:80]}': must have one point, and outputs: energy, residuals, memories"
        )
    doc = row["doc"] or row["name"]
    defaults = {parameter.name: parameter.declaration.default for parameter in given}
    core = _core.make_actuator(row["name"], doc, formula, row["coordinates"], rows, memories, defaults)
    return ActuatorFormula(
        row["name"], doc, core, graph, "of a scene document", len(rows), tuple(rows), tuple(memories),
        tuple(given), dict(sources), formula,
    )  # fmt: skip


_MAKERS: dict[str, Callable[..., Any]] = {
    "energy": _energy,
    "solid_law": _law,
    "shell_law": _law,
    "rod_law": _law,
    "joint": _joint,
    "actuator": _actuator,
}

__all__ = ["ReadFormula", "ReadLaw", "made", "of_actuator", "of_energy", "of_joint", "of_law"]
