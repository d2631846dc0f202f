"""Statistics of compiled formulas: counts by order, sizes of code, what is printed."""

from __future__ import annotations

import pytest

import stark.symbolic as sym
from stark.symbolic.statistics import Statistics


def polynomial(backend: str = "automatic") -> sym.Function:
    @sym.function(backend=backend)
    def cubic(x: sym.Vec2, a: float):
        return a * x[0] ** 3 + x[0] * x[1] ** 2

    return cubic


def test_higher_orders_take_more() -> None:
    found = polynomial().statistics
    assert list(found.operations) == ["value", "gradient", "hessian"]
    for counts in (found.operations, found.instructions):
        assert 0 < counts["value"] < counts["gradient"] <= counts["hessian"]
    assert all(seconds >= 0.0 for seconds in found.build_seconds.values())
    assert found.algorithm != ""


def test_operations_of_the_value_are_those_of_the_graph() -> None:
    f = polynomial()
    assert f.statistics.operations["value"] == f.graph().operation_count


def test_the_interpreter_has_no_machine_code_and_the_same_operations() -> None:
    interpreted, native = polynomial("interpreter").statistics, polynomial().statistics
    assert interpreted.backend == "interpreter"
    assert set(interpreted.code_bytes.values()) == {0}
    assert interpreted.operations == native.operations
    if native.backend != "interpreter":
        assert min(native.code_bytes.values()) > 0


def test_functions_of_several_results_have_a_jacobian() -> None:
    @sym.function
    def both(x: sym.Vec2):
        return sym.vec(x[0] * x[1], x[0] + x[1])

    found = both.statistics
    assert list(found.operations) == ["value", "jacobian"] and found.algorithm == ""


def test_the_table_has_a_row_for_each_order_with_its_numbers() -> None:
    row = {"operations": 3, "instructions": 4, "code_bytes": 100, "build_seconds": 0.0025}
    found = Statistics.of(
        "avx2", {"value": row, "hessian": {**row, "operations": 12, "algorithm": "edge pushing"}}
    )
    first, value, hessian, last = str(found).splitlines()
    assert first.split() == ["operations", "instructions", "code", "[B]", "build", "[ms]"]
    assert value.split() == ["value", "3", "4", "100", "2.50"] and hessian.split()[:2] == ["hessian", "12"]
    assert last == "back end avx2, hessian by edge pushing"
    assert found.operations == pytest.approx({"value": 3, "hessian": 12})
