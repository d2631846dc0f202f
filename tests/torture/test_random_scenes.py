"""Small random scenes: of seeds, and of hypothesis, which shrinks what fails to its simplest form."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import pytest

import stark

pytest.importorskip("ipctk")

from benchmarks.torture.campaign import kind_of, read, run_campaign, run_one, summary
from benchmarks.torture.case import run, simulate
from benchmarks.torture.random_scenes import Generator, build, draw
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

pytestmark = pytest.mark.filterwarnings("ignore::stark.StarkWarning")

#: What a random scene may end in: steps that cannot converge are allowed to fail with a message.
_ALLOWED = ("step ", "failed:")
#: Known defects of scenes of the seed below, by number.
KNOWN: dict[int, str] = {}


class Drawn:
    """Numbers of hypothesis, which shrink towards the first choice and the lower bound."""

    def __init__(self, data: st.DataObject) -> None:
        self._data = data

    def number(self, low: float, high: float) -> float:
        return low + (high - low) * self._data.draw(st.integers(0, 1000)) / 1000.0

    def whole(self, low: int, high: int) -> int:
        return self._data.draw(st.integers(low, high))


def wrong(problems: list[str]) -> list[str]:
    """Problems but for steps that failed with a message."""
    return [p for p in problems if not (p.startswith(_ALLOWED[0]) and _ALLOWED[1] in p)]


@pytest.mark.parametrize("first", [0, 10, 20])
def test_scenes_of_a_seed(first: int) -> None:
    for index in range(first, first + 10):
        outcome = run_one(2, index)
        assert wrong(outcome.problems) == [], outcome.name
        assert outcome.status in ("complete", "failed"), outcome.message


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 400, 50))
def test_many_scenes_of_a_seed(first: int) -> None:
    for index in range(first, first + 50):
        outcome = run_one(3, index)
        assert wrong(outcome.problems) == [], outcome.name


@settings(
    max_examples=25,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.explicit, Phase.generate, Phase.shrink],
)
@given(st.data())
def test_scenes_of_hypothesis(data: st.DataObject) -> None:
    description = draw(Drawn(data))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", stark.StarkWarning)
        outcome = run("hypothesis", build(description))
    assert wrong(outcome.problems) == [], json.dumps(description)


@pytest.mark.parametrize("index", range(0, 24, 3))
def test_random_scenes_have_the_same_bits_on_any_number_of_threads_and_from_a_checkpoint(
    index: int, tmp_path: Path
) -> None:
    def steps(sim: stark.Simulation, count: int) -> list[str]:
        return [sim.state.hash for _ in range(count) if not sim.step().failed]

    def make(threads: int) -> stark.Simulation:
        return simulate(build(draw(Generator(2, index))), threads=threads)

    sim = make(1)
    first = steps(sim, 3)
    sim.save(tmp_path / "third.stark")
    expected = first + steps(sim, 3)
    assert steps(make(2), 6) == expected
    assert steps(make(5), 6) == expected
    resumed = make(5)
    resumed.load(tmp_path / "third.stark")
    assert steps(resumed, 3) == expected[len(first) :]


# --- the campaign ---


def test_a_campaign_is_written_down_and_a_crash_shows(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    rows = run_campaign(2, 0, 3, path)
    with path.open("a") as file:
        file.write(json.dumps({"begun": 3}) + "\n")
    found = summary(read(path))
    assert summary(rows)["scenes"] == 3
    assert found["outcomes"]["crash"] == 1 and found["scenes"] == 4
    assert found["where"] == {"crash": [3]}


def test_problems_are_counted_by_kind() -> None:
    assert kind_of("step 12: 0.0123 N are unbalanced") == kind_of("step 3: 4.5 N are unbalanced")
    assert kind_of("step 1: surfaces intersect") == "surfaces intersect"


def test_exceptions_are_outcomes(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("of a test")

    monkeypatch.setattr("benchmarks.torture.campaign.KINDS", {"mixed": (broken, broken)})
    outcome = run_one(2, 0)
    assert outcome.status == "exception" and "of a test" in outcome.message and outcome.problems
