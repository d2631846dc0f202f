"""Recordings as they are written: once a chunk, complete up to a kill, refused bodies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record

from stark.recording import Recorder, Recording, RecordingError


def test_still_bodies_are_stored_once_a_chunk(tmp_path: Path) -> None:
    record(tmp_path / "run", 20)
    with np.load(tmp_path / "run/frames/chunk_000000.npz") as chunk:
        assert chunk["positions_0000"].shape[0] == 21
        assert chunk["positions_0002"].shape[0] == 1


def test_a_recording_is_replaced_but_other_folders_are_refused(tmp_path: Path) -> None:
    record(tmp_path / "run", 40)
    assert len(record(tmp_path / "run", 3)) == 4
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/thesis.txt").write_text("precious")
    with pytest.raises(RecordingError, match="not empty and holds no recording; choose another"):
        record(tmp_path / "mine", 1)
    assert (tmp_path / "mine/thesis.txt").read_text() == "precious"
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="is a file"):
        record(tmp_path / "file", 1)


_KILLED = """
import sys
sys.path.insert(0, {tests!r})
from fake_simulation import FakeSimulation
from stark.recording import Recorder
sim = FakeSimulation(20)
recorder = Recorder({folder!r}, sim, chunk_frames=8)
print("go", flush=True)
while True:
    recorder.record(sim)
    recorder.report(sim.step())
"""

_LOOP = """
import os, signal, sys
from pathlib import Path
import stark
from stark.recording import Recorder

scene = stark.Scene()
scene.add_floor(1.0)
scene.add_box(0.1, mass=0.5, position=(0.0, 0.0, 0.2), name="box")
sim = stark.Simulation(scene, time_step=0.01)
folder, kill = sys.argv[1], int(sys.argv[2])
saved = Path(folder + ".stark")
if saved.exists():
    recorder = Recorder.resume(folder, sim, **sim.load(saved)["recorded"])
else:
    recorder = Recorder(folder, sim, chunk_frames=8)
    recorder.record(sim)
with recorder:
    for step in sim.run(until=0.4):
        recorder.report(step)
        recorder.record(sim)
        number = round(step.time / 0.01)
        if number % 5 == 0:
            sim.save(saved, memory={"recorded": recorder.sync()})
        if number == kill:
            os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_loop_goes_on_with_its_recording(tmp_path: Path) -> None:
    def loop(name: str, kill: int) -> int:
        command = [sys.executable, "-c", _LOOP, str(tmp_path / name), str(kill)]
        return subprocess.run(command, check=False).returncode

    assert loop("whole", -1) == 0
    for kill in (7, 13, 25, 38):
        assert loop("killed", kill) == -signal.SIGKILL
    assert loop("killed", -1) == 0
    whole, killed = Recording(tmp_path / "whole"), Recording(tmp_path / "killed")
    assert len(killed) == 41 and np.array_equal(killed.times, whole.times)
    assert all(np.array_equal(killed.positions("box", k), whole.positions("box", k)) for k in range(41))
    for name in ("time", "energy.kinetic", "contact_count"):
        assert np.array_equal(killed.telemetry[name], whole.telemetry[name])
    assert killed.manifest["resumed"] == pytest.approx([0.05, 0.1, 0.25, 0.35])


def test_a_killed_run_is_readable(tmp_path: Path) -> None:
    folder = str(tmp_path / "run")
    code = _KILLED.format(tests=str(Path(__file__).parents[1]), folder=folder)
    for wait in (0.05, 0.11, 0.23):
        process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        try:
            process.wait(wait)
        except subprocess.TimeoutExpired:
            os.kill(process.pid, signal.SIGKILL)
        process.wait()
        process.stdout.close()
        run = Recording(folder)
        assert run.status == "running"
        assert len(run) % 8 == 0
        assert len(run.telemetry) >= len(run) - 1
        for frame in run.frames():
            assert np.isfinite(frame.bodies[0].positions).all()


def test_an_exception_closes_the_recording_as_failed(tmp_path: Path) -> None:
    sim = FakeSimulation()
    with pytest.raises(ZeroDivisionError), Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
        raise ZeroDivisionError("oh")
    run = Recording(tmp_path / "run")
    assert (run.status, len(run)) == ("failed", 1)
    assert "ZeroDivisionError: oh" in run.manifest["message"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": np.zeros((4, 2))}, r"shape \(4, 2\); must be \(n, 3\)"),
        ({"triangles": np.array([[0, 1, 99]])}, "names vertex 99; it has 49"),
        ({"triangles": np.array([0, 1, 2])}, r"must be \(m, 3\)"),
    ],
)
def test_bodies_that_cannot_be_recorded(tmp_path: Path, change, message: str) -> None:
    sim = FakeSimulation()
    sim.bodies[0].__dict__.update(change)
    with pytest.raises(RecordingError, match=message):
        Recorder(tmp_path / "run", sim)


def test_what_is_given_in_the_wrong_place_is_refused(tmp_path: Path) -> None:
    """A simulation has a time, too, and was taken for the report of a step without numbers."""
    sim = FakeSimulation()
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
        for wrong in (sim, None, 3):
            with pytest.raises(
                RecordingError, match=r"report: .*must be the report that sim.step\(\) returned"
            ):
                recorder.report(wrong)
        with pytest.raises(RecordingError, match=r"sim = .*: must be a stark.Simulation"):
            recorder.record(sim.step())
        recorder.report(sim.step())
    with pytest.raises(RecordingError, match="is closed; reports can no longer be added"):
        recorder.report(sim.step())
    run = Recording(tmp_path / "run")
    assert len(run) == 1 and len(run.telemetry["time"]) == 1
