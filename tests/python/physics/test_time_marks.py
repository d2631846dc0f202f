"""Times of steps: products rounded once, whole last steps, the same after rewinding and resuming."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark

BODY = {"size": (0.1, 0.1, 0.1), "mass": 1.0}


def _falling(step: float, **settings: object) -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box(**BODY)
    return stark.Simulation(scene, time_step=step, **settings)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize(("step", "count"), [(0.005, 441), (1 / 60, 300), (1e-3, 700)])
def test_steps_end_on_marks(step: float, count: int, integrator: str) -> None:
    sim = _falling(step, **{"time.integrator": integrator})
    reports = list(sim.run(until=count * step))
    assert [r.time for r in reports] == [k * step for k in range(1, count + 1)]
    assert {r.time_step for r in reports} == {step}
    assert sim.time == reports[-1].time == sim.state.time


@pytest.mark.parametrize(
    ("step", "until", "count"), [(0.01, 2.5, 250), (1 / 60, 4.1, 246), (0.005, 2.205, 441)]
)
def test_ends_written_as_decimals_take_whole_steps(step: float, until: float, count: int) -> None:
    reports = list(_falling(step).run(until=until))
    assert len(reports) == count
    assert reports[-1].time_step == step
    assert reports[-1].time == pytest.approx(until, abs=1e-15 * until)


def test_runs_in_pieces_take_the_steps_of_one_run() -> None:
    whole, pieces = _falling(1 / 240), _falling(1 / 240)
    whole.run_until(2.0)
    for frame in range(1, 61):
        pieces.run_until(frame / 30)
        assert pieces.state.step_count == 8 * frame
    assert pieces.state == whole.state


def test_an_end_between_marks_is_met_in_every_bit() -> None:
    sim = _falling(0.005)
    reports = list(sim.run(until=0.0172))
    assert sim.time == 0.0172
    assert [report.time_step for report in reports[2:]] == pytest.approx([0.0036, 0.0036])
    list(sim.run(until=0.0172 + 0.5))
    assert sim.state.step_count == 4 + 100
    assert sim.time == 0.0172 + 100 * 0.005
    first = _falling(1.0)
    first.run_until(0.1)
    assert first.time == 0.1


def test_motions_are_evaluated_on_marks() -> None:
    times: list[float] = []
    scene = stark.Scene()
    box = scene.add_box(**BODY, motion="scripted")

    def position(time: float) -> tuple[float, float, float]:
        times.append(time)
        return (time, 0.0, 0.0)

    box.follow(position=position)
    sim = stark.Simulation(scene, time_step=0.005)
    times.clear()
    sim.run_until(0.5)
    assert times == [k * 0.005 for k in range(1, 101)]


def _stiff_drop() -> stark.Simulation:
    """Steps that have to be halved: 6 Newton iterations are not enough for an impact of a soft box."""
    scene = stark.Scene()
    scene.add_floor()
    scene.add_solid(stark.mesh.tet_box(0.2, 3), position=(0, 0, 0.11), velocity=(0, 0, -3))
    return stark.Simulation(scene, time_step=0.016, **{"newton.max_iterations": 6})


def test_retried_steps_return_to_the_marks(tmp_path: Path) -> None:
    sim = _stiff_drop()
    reports = list(sim.run(until=25 * 0.016))
    assert any(r.rejected_steps for r in reports)
    marks = {k * 0.016 for k in range(1, 26)}
    assert marks <= {r.time for r in reports}
    assert sim.time == 25 * 0.016
    times = [0.0, *(r.time for r in reports)]
    assert np.diff(times) == pytest.approx([r.time_step for r in reports], rel=1e-12)


def test_resuming_between_marks_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    sim, states = _stiff_drop(), []
    for report in sim.run(until=12 * 0.016):
        states.append(sim.state)
        if report.rejected_steps and not (tmp_path / "at").exists():
            sim.save(tmp_path / "at")
            kept = len(states)
    again = _stiff_drop()
    again.load(tmp_path / "at")
    assert again.state == states[kept - 1]
    for state in states[kept:]:
        again.step()
        assert again.state == state


def test_states_with_other_marks_are_refused_or_counted_anew() -> None:
    sim = _falling(0.01)
    sim.run_until(0.05)
    arrays = sim.state.arrays()
    with pytest.raises(stark.InvalidArgument, match="mark_count = -1: must be >= 0"):
        sim.state = stark._core.State.of_arrays({**arrays, "mark_count": np.array(-1)})
    other = _falling(0.004)
    other.state = sim.state
    other.step()
    assert other.time == 0.05 + 0.004
    sim.state = stark._core.State.of_arrays({**arrays, "time": np.array(3.0)})
    sim.step()
    assert sim.time == 3.01
