"""Properties that hold for every formula, on random ones that hypothesis draws and shrinks.

Each is compared with second-order jets whose tolerances come from error bounds (_jets.py), and its code with
the interpreter bit by bit. 500 formulas are drawn, always the same; STARK_NIGHTLY=1 draws 10 000 new ones."""

from __future__ import annotations

import os

import pytest
from _checks import check_derivatives_as_expressions, check_formula, seen
from _formulas import NAMES, Formula, formulas
from hypothesis import HealthCheck, Phase, given, settings

NIGHTLY = os.environ.get("STARK_NIGHTLY") == "1"
COUNT = 10_000 if NIGHTLY else 500


def profile(count: int) -> settings:
    return settings(
        max_examples=count,
        derandomize=not NIGHTLY,
        database=None,
        deadline=None,
        print_blob=True,
        phases=[Phase.explicit, Phase.generate, Phase.shrink],
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )


@pytest.mark.slow
def test_values_derivatives_bits_and_lanes() -> None:
    seen.clear()

    @profile(COUNT)
    @given(formulas())
    def run(formula: Formula) -> None:
        check_formula(formula)
        seen["formulas"] += 1
        seen.update({operation.name for operation in formula.operations})

    run()
    # The test must not pass because the oracle had nothing to say.
    assert seen["formulas"] >= COUNT
    assert seen["known Hessians"] > 0.6 * seen["elements"]
    assert seen["curved"] > 0.6 * COUNT
    assert all(seen[name] > COUNT // 100 for name in NAMES)


@pytest.mark.slow
def test_every_way_to_the_derivatives() -> None:
    seen.clear()

    @profile(COUNT // 5)
    @given(formulas(most_unknowns=6))
    def run(formula: Formula) -> None:
        check_derivatives_as_expressions(formula)

    run()
    assert len([name for name in seen if "staged" in name]) >= 1
