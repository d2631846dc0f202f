"""Times of a recording go forward: a jump back in time is refused and leaves what was recorded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation

import stark
from stark.recording import Recorder, Recording, RecordingError


def fall() -> stark.Simulation:
    scene = stark.Scene("fall")
    scene.add_floor(1.0)
    scene.add_box(0.1, mass=1.0, position=(0, 0, 0.07), name="box")
    return stark.Simulation(scene, time_step=0.01, threads=1)


def episode(recorder: Recorder, sim: stark.Simulation, steps: int = 4) -> None:
    recorder.record(sim)
    recorder.record_state(sim)
    for _ in range(steps):
        recorder.report(sim.step())
        recorder.record(sim)
        recorder.record_state(sim)


@pytest.mark.parametrize("certify", [False, True])
@pytest.mark.parametrize("way", ["reset", "state", "another simulation"])
def test_going_back_in_time_is_refused_and_leaves_a_readable_recording(
    tmp_path: Path, way: str, certify: bool
) -> None:
    sim = fall()
    before = sim.state
    with (
        pytest.raises(RecordingError, match=r"went back .* another Recorder, with a folder of its own"),
        Recorder(tmp_path / "run", sim, certify=certify) as recorder,
    ):
        episode(recorder, sim)
        if way == "reset":
            sim.reset()
        elif way == "state":
            sim.state = before
        else:
            sim = fall()
        episode(recorder, sim)
    run = Recording(tmp_path / "run")
    assert run.status == "failed" and "another Recorder" in run.manifest["message"]
    assert len(run) == 5 and len(run.telemetry) == 4
    if certify:
        verified = stark.verify.verify(tmp_path / "run")
        assert [claim.name for claim in verified.claims if claim.status == "violated"] == []


@pytest.mark.parametrize("what", ["record", "record_state", "report"])
def test_each_of_frames_states_and_lines_is_refused_before_anything_is_written(
    tmp_path: Path, what: str
) -> None:
    sim = fall()
    recorder = Recorder(tmp_path / "run", sim, certify=True)
    episode(recorder, sim)
    counts = recorder.frame_count, recorder.state_count, recorder.line_count
    sim.reset()
    given: Any = sim.step() if what == "report" else sim
    with pytest.raises(RecordingError, match="4 s: the simulation went back"):
        getattr(recorder, what)(given)
    assert (recorder.frame_count, recorder.state_count, recorder.line_count) == counts
    recorder.close()
    assert len(Recording(tmp_path / "run")) == 5
    assert stark.verify.verify(tmp_path / "run").verdict == "certified"


def test_what_was_not_recorded_may_be_taken_back(tmp_path: Path) -> None:
    """A controller that looks ahead, and a frame more of the same moment."""
    sim = fall()
    with Recorder(tmp_path / "run", sim) as recorder:
        episode(recorder, sim, 2)
        here = sim.state
        sim.run_until(0.1)
        sim.state = here
        recorder.record(sim)
        recorder.report(sim.step())
        recorder.record(sim)
    assert np.allclose(Recording(tmp_path / "run").times, [0.0, 0.01, 0.02, 0.02, 0.03])


def test_a_resumed_recording_goes_on_from_its_time(tmp_path: Path) -> None:
    sim = FakeSimulation()
    with Recorder(tmp_path / "run", sim, scene="fake") as recorder:
        recorder.record(sim)
        recorder.report(sim.step())
        recorder.record(sim)
    with Recorder.resume(tmp_path / "run", sim, frames=2, lines=1) as recorder:
        for call, given in ((recorder.record, FakeSimulation()), (recorder.report, FakeSimulation().step())):
            given.time = 0.01
            with pytest.raises(RecordingError, match="went back"):
                call(given)
        recorder.report(sim.step())
        recorder.record(sim)
    assert len(Recording(tmp_path / "run")) == 3


@pytest.mark.parametrize("time", [float("nan"), float("inf")])
def test_a_frame_has_a_finite_time(tmp_path: Path, time: float) -> None:
    sim = FakeSimulation()
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
        with pytest.raises(RecordingError, match="must have a finite time"):
            recorder.record(sim, time=time)
    assert len(Recording(tmp_path / "run")) == 1
