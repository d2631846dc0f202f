"""Stopping, saving, loading elsewhere and going on gives the bits of never stopping: states and sensors."""

from __future__ import annotations

from pathlib import Path

import pytest
from _zoo import CASES, advance, sensors

import stark

#: The last step, taken again when a checkpoint is loaded, must have the same bits.
pytestmark = pytest.mark.filterwarnings("error:the last step:stark.StarkWarning")


@pytest.mark.parametrize("name", CASES)
def test_a_run_that_was_stopped_has_the_same_bits(name: str, tmp_path: Path) -> None:
    case, memory = CASES[name], {}
    first, second = case.halves
    sim = case.simulate()
    start = advance(case, sim, memory, first)
    sim.save(tmp_path / "half.stark", memory=memory)
    felt = sensors(sim)
    rest = advance(case, sim, memory, second)
    assert len({state for state, _ in start + rest}) == first + second
    for threads in (1, 2, 5):
        other = case.simulate(threads=threads)
        recalled = other.load(tmp_path / "half.stark")
        assert other.state.hash == start[-1][0]
        assert sensors(other) == felt
        assert advance(case, other, recalled, second) == rest, f"with {threads} threads"
        assert recalled == memory


@pytest.mark.parametrize("name", CASES)
def test_a_rewind_in_place_has_the_same_states(name: str, tmp_path: Path) -> None:
    """The file brings back a simulation that went on, too."""
    case, memory = CASES[name], {}
    sim = case.simulate()
    advance(case, sim, memory, 3)
    sim.save(tmp_path / "early.stark", memory=memory)
    rest = advance(case, sim, memory, 4)
    assert advance(case, sim, sim.load(tmp_path / "early.stark"), 4) == rest


def test_cases_do_what_their_names_say() -> None:
    """The tests above would see nothing in a scene where nothing happens."""
    for name in ("clutter", "clutter_bdf2", "rods"):
        sim = CASES[name].simulate()
        advance(CASES[name], sim, {}, 12)
        assert len(sim.contacts) > 0, name
    case = CASES["peel"]
    sim = case.simulate()
    advance(case, sim, {}, 8)
    broken = sim.attachments[0].broken.sum()
    advance(case, sim, {}, 4)
    assert 0 < broken < sim.attachments[0].broken.sum()
    case = CASES["halved_steps"]
    sim = case.simulate()
    rejected = [sim.step().rejected_steps for _ in range(12)]
    assert any(rejected[:6]) and sim.time_step < 0.01


def test_controls_between_the_last_step_and_the_checkpoint_are_kept(tmp_path: Path) -> None:
    case = CASES["mechanism"]

    def controlled(sim: stark.Simulation) -> None:
        sim.actuators[1].target = 0.9
        sim.joints[1].enabled = False
        sim.actuators[2].enabled = False

    sim, memory = case.simulate(), {}
    advance(case, sim, memory, 5)
    controlled(sim)
    felt = sensors(sim)
    sim.save(tmp_path / "a.stark")
    other = case.simulate()
    other.load(tmp_path / "a.stark")
    assert other.state == sim.state and sensors(other) == felt
    for _ in range(3):
        sim.step()
        other.step()
        assert other.state == sim.state and sensors(other) == sensors(sim)


def test_steps_that_were_cut_short(tmp_path: Path) -> None:
    case = CASES["clutter"]
    sim = case.simulate()
    list(sim.run(until=0.047))  # ends with 7 ms
    sim.save(tmp_path / "a.stark")
    other = case.simulate()
    other.load(tmp_path / "a.stark")
    assert sensors(other) == sensors(sim)
    assert advance(case, other, {}, 3) == advance(case, sim, {}, 3)


def test_before_the_first_step(tmp_path: Path) -> None:
    case = CASES["clutter"]
    sim = case.simulate()
    sim.save(tmp_path / "a.stark")
    other = case.simulate()
    advance(case, other, {}, 2)
    other.load(tmp_path / "a.stark")
    assert other.time == 0.0 and len(other.contacts) == 0
    assert advance(case, other, {}, 3) == advance(case, sim, {}, 3)
