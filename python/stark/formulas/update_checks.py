"""New values of internal variables of a law that are not finite: which, and on what line of the law."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from stark._core import symbolic as core
from stark.formulas.diagnosis import Lines, first_not_finite
from stark.formulas.kinematics import Inputs
from stark.formulas.recorded_law import RecordedLaw
from stark.symbolic.graph import ExpressionGraph
from stark.symbolic.tensor import Scalar

_STEP = 0.01  # of the first step [s]
_ROWS = 8  # values of parameters that differ by element: this many are tested


def bad_update(law: RecordedLaw, values: Mapping[str, np.ndarray], rest: np.ndarray) -> str:
    """What to say of an internal variable that a first step at rest leaves without a finite value, "" without
    one. rest (points, 3): the points of the formula there."""
    if not law.internals:
        return ""
    inputs = Inputs(list(range(len(rest))))
    size = inputs.builder.time().graph
    lines = Lines(law.function, lambda: len(size))
    _, updates = lines.run(lambda: law.results(inputs))
    for row in range(_row_count(law, values)):
        known = dict(_known(law, values, rest, inputs, row))
        numbers = _evaluated(updates, known)
        for variable, bad in _not_finite(law, numbers):
            text = (
                f"{law.name}: internal variable '{variable}' is not finite after a first step at rest: must "
                f"be; guard it with stark.where, or add a small offset"
            )
            found = first_not_finite(updates[bad], known, slopes=False)
            place = None if found is None else lines.of(found[0])
            if found is None or place is None:
                return f"{text}\n{law.location}"
            return f"{text}; it comes from {found[1]}, on this line:\n{place}"
    return ""


def _row_count(law: RecordedLaw, values: Mapping[str, np.ndarray]) -> int:
    counts = [len(values[p.name]) for p in law.parameters if values[p.name].ndim > len(p.shape)]
    return min(max(counts, default=1), _ROWS)


def _known(
    law: RecordedLaw, values: Mapping[str, np.ndarray], rest: np.ndarray, inputs: Inputs, row: int
) -> Iterator[tuple[int, float]]:
    """Inputs of the formula by node."""
    numbers = {variable.name: np.array(variable.initial) for variable in law.internals}
    for parameter in law.parameters:
        rows = values[parameter.name].reshape(-1, parameter.width)
        numbers[parameter.name] = rows[row % len(rows)]
    for node, (source, point, k) in inputs.sources.items():
        if source in ("time", "time_step"):
            yield node, _STEP
        elif source in ("x", "X", "x_prev", "x_initial"):
            yield node, float(rest[point, k])
        elif source in numbers:
            yield node, float(numbers[source][k])


def _evaluated(updates: list[Scalar], known: Mapping[int, float]) -> list[float]:
    """Values of all updates."""
    nodes = ExpressionGraph("", updates).nodes
    leaves = [key for key, node in nodes.items() if node.operation == "input"]
    arguments = [(f"v{key}", [nodes[key]], False) for key in leaves]
    compiled = core.compile_arrays(updates, arguments, "interpreter")
    arrays = [np.array(known[key]) for key in leaves]
    numbers, _, _ = compiled.evaluate(0, True, False, arrays, [[] for _ in arrays], [])
    found: list[float] = numbers.reshape(-1).tolist()
    return found


def _not_finite(law: RecordedLaw, numbers: list[float]) -> Iterator[tuple[str, int]]:
    """Names of internal variables and positions of their first number that is not finite."""
    first = 0
    for variable in law.internals:
        count = len(variable.initial)
        for k in range(first, first + count):
            if not np.isfinite(numbers[k]):
                yield variable.name, k
                break
        first += count
