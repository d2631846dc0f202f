"""The scenes of benchmarks/torture in their small size: judged by ipctk after every step, the same bits for
any number of threads and from a checkpoint on."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import stark

pytest.importorskip("ipctk")

from benchmarks.torture.case import Setup, run, simulate
from benchmarks.torture.scenes import CASES

from stark.recording.states import describe

pytestmark = pytest.mark.filterwarnings("ignore::stark.StarkWarning")

#: Steps that are compared between numbers of threads: the first contacts, and some more.
_STEPS, _SAVED_AFTER = 12, 4
#: Defects that are known, by scene.
KNOWN: dict[str, str] = {}


def named(slow: bool | None = None) -> list[Any]:
    """Scenes as parameters of a test; None: all, the slow ones marked."""
    parameters = []
    for name, case in CASES.items():
        marks = [pytest.mark.slow] if case.slow else []
        marks += [pytest.mark.xfail(strict=True, reason=KNOWN[name])] if name in KNOWN else []
        if slow is None or case.slow == slow:
            parameters.append(pytest.param(name, marks=marks))
    return parameters


@pytest.mark.parametrize("name", named())
def test_scene(name: str) -> None:
    outcome = run(name, CASES[name].build(False))
    assert outcome.problems == []


def hashes(sim: stark.Simulation, setup: Setup, count: int) -> list[str]:
    """Of the states after some steps, or until one fails."""
    result = []
    for _ in range(count):
        if sim.time >= setup.until * (1.0 - 1e-9):
            break
        report = sim.step(max_time_step=setup.until - sim.time)
        result.append(sim.state.hash)
        if report.failed:
            break
    return result


def starts(name: str) -> bool:
    """Whether there is a simulation of it, and it takes steps."""
    return CASES[name].build(False).refused is None and not name.startswith("gap_")


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.slow] if CASES[n].slow else []) for n in CASES if starts(n)],
)
def test_bits_do_not_depend_on_threads_or_on_a_checkpoint(name: str, tmp_path: Path) -> None:
    setup = CASES[name].build(False)
    sim = simulate(setup, threads=1)
    first = hashes(sim, setup, _SAVED_AFTER)
    sim.save(tmp_path / "saved.stark")
    expected = first + hashes(sim, setup, _STEPS - _SAVED_AFTER)

    for threads in (2, 5):
        setup = CASES[name].build(False)
        assert hashes(simulate(setup, threads=threads), setup, _STEPS) == expected, threads

    setup = CASES[name].build(False)
    resumed = simulate(setup, threads=2)
    resumed.load(tmp_path / "saved.stark")
    assert hashes(resumed, setup, _STEPS - _SAVED_AFTER) == expected[len(first) :]


# --- the bench itself: it has to see what is wrong ---


def through(**contact: bool) -> Setup:
    """A ball that falls onto a thin plate, with or without contact."""
    scene = stark.Scene()
    plate = scene.add_box((0.3, 0.3, 0.004), motion="fixed")
    ball = scene.add_sphere(0.02, subdivisions=1, mass=1.0, position=(0, 0, 0.06), velocity=(0, 0, -5.0))
    if not contact.get("contact", True):
        scene.disable_contact(plate, ball)
    return Setup(scene, 0.05, {"time_step": 5e-3})


def test_the_bench_sees_what_intersects_and_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without contact, of which the judge does not know."""
    assert run("stopped", through()).problems == []

    monkeypatch.setattr(
        "benchmarks.torture.meeting.describe", lambda sim: {**describe(sim), "pairs_without_contact": []}
    )
    problems = " ".join(run("passing", through(contact=False)).problems)
    assert "surfaces intersect" in problems
    assert "no clear way" in problems or "passed through a closed surface" in problems


def test_the_bench_sees_forces_that_do_not_balance() -> None:
    """A damper of all motion is no force of contact."""
    setup = through()
    setup.scene.add_sphere(
        0.02, subdivisions=1, mass=1.0, position=(0, 0, 1.0), velocity=(9.0, 0, 0), linear_damping=5.0
    )
    assert any("unbalanced" in problem for problem in run("damped", setup).problems)


def test_the_bench_sees_failures_that_are_not_expected() -> None:
    setup = through()
    setup.settings |= {"newton.max_iterations": 1, "time.min_step": 4e-3}
    outcome = run("failing", setup)
    assert outcome.status == "failed" and outcome.problems
    setup.fails = "max_iterations"
    assert run("failing", setup).problems == []
    setup = through()
    setup.fails = "blocked"
    assert run("not failing", setup).problems


def test_the_bench_counts_what_it_ran() -> None:
    outcome = run("stopped", through())
    assert outcome.steps == 10 and outcome.contacts > 0 and outcome.iterations > 0
    assert 0.0 < outcome.gap < 2.0 and math.isfinite(outcome.seconds) and outcome.hash
