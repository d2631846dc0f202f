"""``stark run`` ends at the time it was given, between whole steps too, and can go on from there as if it had
not ended."""

from __future__ import annotations

from pathlib import Path

import pytest
from _runs import content, write_scene

import stark
from stark import scenes
from stark.checkpoint import Checkpoint, CheckpointError
from stark.cli import main
from stark.recording import Recording

QUIET = {"replay": False, "picture": False}


@pytest.mark.parametrize(("until", "steps"), [(0.08, 5), (0.1, 6), (1 / 30, 2), (0.01, 1)])
def test_runs_end_when_they_are_told_to(tmp_path: Path, until: float, steps: int) -> None:
    """The default step is 1/60 s."""
    scene = write_scene(tmp_path, "fall.py", **{'"time_step": 0.01, ': ""})
    words = ["run", str(scene), "--until", repr(until), "--out", str(tmp_path / "run"), "--quiet"]
    assert main([*words, "--no-replay", "--no-picture"]) == 0
    run = Recording(tmp_path / "run")
    assert run.manifest["summary"]["simulated"] == pytest.approx(until, abs=1e-12)
    assert run.times[-1] == pytest.approx(until, abs=1e-12)
    assert len(run.telemetry) == steps
    whole = [1 / 60] * max(0, steps - 2)
    rest, last = until - sum(whole), min(steps, 2)
    assert run.telemetry["time_step"] == pytest.approx([*whole, *[rest / last] * last])


def test_the_end_of_a_scene_file_is_met_and_checked(tmp_path: Path) -> None:
    scene = write_scene(tmp_path, "odd.py", **{"until = 0.4": "until = 0.377"})
    result = scenes.run(scene, out=tmp_path / "run", **QUIET)
    assert (result.simulated, result.steps) == (pytest.approx(0.377, abs=1e-12), 38)
    assert result.message == "check passed"


@pytest.mark.parametrize("certify", [False, True])
@pytest.mark.parametrize("every", [0.0, 1e9])
def test_going_on_from_an_end_between_steps(tmp_path: Path, certify: bool, every: float) -> None:
    """A run to 0.237 s that goes on to 0.4 s is the run to 0.4 s, bit for bit: the shortened steps go."""
    options = {**QUIET, "fps": 70.0, "certify": certify, "checkpoint_every": every}
    scene = write_scene(tmp_path)
    scenes.run(scene, out=tmp_path / "whole", **options)
    short = scenes.run(scene, out=tmp_path / "run", until=0.237, **options)
    assert short.simulated == pytest.approx(0.237, abs=1e-12)
    ended = content(tmp_path / "run")
    assert Checkpoint.read(tmp_path / "run/checkpoint.stark").state.time == pytest.approx(0.22)
    scenes.resume(tmp_path / "run", **QUIET)  # nothing is left to do: the last step is made again
    assert content(tmp_path / "run") == ended
    resumed = scenes.resume(tmp_path / "run", until=0.4, **QUIET)
    assert resumed.steps == 40
    assert content(tmp_path / "run") == content(tmp_path / "whole")
    if certify:
        assert stark.verify.verify(tmp_path / "run").verdict == "certified"


@pytest.mark.parametrize("after", [5, 22, 23, 24])
def test_stopped_before_an_end_between_steps(tmp_path: Path, after: int) -> None:
    """Before, at and after the steps that are shortened."""
    scene = write_scene(tmp_path)
    scenes.run(scene, out=tmp_path / "whole", until=0.237, fps=70.0, **QUIET)

    def stop(sim: stark.Simulation, report: stark._core.StepReport) -> None:
        if report.step == after:
            raise KeyboardInterrupt

    stopped = scenes.run(scene, out=tmp_path / "run", until=0.237, fps=70.0, on_step=stop, **QUIET)
    assert stopped.status == "interrupted"
    assert scenes.resume(tmp_path / "run", **QUIET).steps == 24
    assert content(tmp_path / "run") == content(tmp_path / "whole")


def test_an_earlier_end_than_where_the_run_is(tmp_path: Path) -> None:
    scenes.run(write_scene(tmp_path), out=tmp_path / "run", until=0.1, **QUIET)
    with pytest.raises(CheckpointError, match=r"is at 0.1 s, after until = 0.095 s; give a later end"):
        scenes.resume(tmp_path / "run", until=0.095, **QUIET)
