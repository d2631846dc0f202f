"""Runs that were stopped, killed or failed, and went on: the recording is that of an uninterrupted run."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from _runs import content, write_scene

import stark
from stark import scenes
from stark.checkpoint import Checkpoint, CheckpointError
from stark.cli import main
from stark.recording import Recording, RecordingError

QUIET = {"replay": False, "picture": False}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that was never stopped."""
    folder = tmp_path_factory.mktemp("whole")
    scenes.run(write_scene(folder), out=folder / "run", fps=70.0, **QUIET)
    return folder / "run"


def stopped(folder: Path, after: int, **options: object) -> scenes.RunResult:
    """A run that gets Ctrl-C after so many steps."""

    def on_step(sim: stark.Simulation, report: stark._core.StepReport) -> None:
        if report.step == after:
            raise KeyboardInterrupt

    return scenes.run(
        write_scene(folder), out=folder / "run", fps=70.0, on_step=on_step, **{**QUIET, **options}
    )


@pytest.mark.parametrize("after", [1, 7, 39])
@pytest.mark.parametrize("every", [0.0, 1e9])
def test_a_run_that_was_interrupted(after: int, every: float, tmp_path: Path, whole: Path) -> None:
    result = stopped(tmp_path, after, checkpoint_every=every)
    assert (result.status, len(Recording(tmp_path / "run").telemetry)) == ("interrupted", after)
    resumed = scenes.resume(tmp_path / "run", **QUIET)
    assert (resumed.status, resumed.steps, resumed.message) == ("complete", 40, "check passed")
    assert content(tmp_path / "run") == content(whole)
    assert Recording(tmp_path / "run").manifest["resumed"] == [pytest.approx(0.01 * after)]


def test_resuming_again_and_again(tmp_path: Path, whole: Path) -> None:
    stopped(tmp_path, 3)

    def stop(sim: stark.Simulation, report: stark._core.StepReport) -> None:
        if report.step % 9 == 0:
            raise KeyboardInterrupt

    statuses = [scenes.resume(tmp_path / "run", on_step=stop, **QUIET).status for _ in range(5)]
    assert statuses == ["interrupted"] * 4 + ["complete"]
    assert content(tmp_path / "run") == content(whole)


def test_a_complete_run_can_go_on_to_a_later_end(tmp_path: Path, whole: Path) -> None:
    """The frame of an end that is none any more goes."""
    scenes.run(write_scene(tmp_path), out=tmp_path / "run", until=0.15, fps=70.0, **QUIET)
    assert len(Recording(tmp_path / "run")) == 9  # one every second step, and the last
    scenes.resume(tmp_path / "run", until=0.4, **QUIET)
    assert content(tmp_path / "run") == content(whole)
    before = content(tmp_path / "run")
    scenes.resume(tmp_path / "run", **QUIET)  # nothing is left to do
    assert content(tmp_path / "run") == before
    with pytest.raises(CheckpointError, match=r"is at 0.4 s, after until = 0.1 s; give a later end"):
        scenes.resume(tmp_path / "run", until=0.1, **QUIET)


@pytest.fixture(scope="module")
def certified(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run for certification that was never stopped: 41 states, more than a chunk."""
    folder = tmp_path_factory.mktemp("certified")
    scenes.run(write_scene(folder), out=folder / "run", fps=70.0, certify=True, **QUIET)
    assert stark.verify.verify(folder / "run").verdict == "certified"
    return folder / "run"


@pytest.mark.parametrize("after", [1, 15, 31, 32, 36])
def test_a_run_for_certification(after: int, tmp_path: Path, certified: Path) -> None:
    """States come out the same, chunk by chunk, and the certificate is that of one run."""
    stopped(tmp_path, after, certify=True, checkpoint_every=0.0)
    scenes.resume(tmp_path / "run", **QUIET)
    assert content(tmp_path / "run") == content(certified)
    certificate = stark.verify.verify(tmp_path / "run")
    assert certificate.verdict == "certified"
    assert certificate.recording["states"] == 41
    assert certificate.recording["resumed"] == [pytest.approx(0.01 * after)]


def test_a_killed_run_for_certification(tmp_path: Path, certified: Path) -> None:
    """What was synced with the checkpoint is there; what came after it is made again. The part can be checked
    as it is."""
    written: list[dict[str, bytes]] = []

    def copy(sim: stark.Simulation, report: stark._core.StepReport) -> None:
        if report.step == 36:
            run = tmp_path / "run"
            written.append({str(p.relative_to(run)): p.read_bytes() for p in run.rglob("*") if p.is_file()})

    scenes.run(
        write_scene(tmp_path),
        out=tmp_path / "run",
        fps=70.0,
        certify=True,
        checkpoint_every=0.0,
        on_step=copy,
        **QUIET,
    )
    for name, data in written[0].items():
        (tmp_path / "killed" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "killed" / name).write_bytes(data)
    part = stark.verify.verify(tmp_path / "killed")
    assert part.recording["status"] == "running"
    assert part["steps"].status == "verified" and 30 < part.recording["states"] < 41
    scenes.resume(tmp_path / "killed", **QUIET)
    assert content(tmp_path / "killed") == content(certified)


def test_runs_for_certification_keep_their_settings_and_files(tmp_path: Path) -> None:
    stopped(tmp_path, 20, certify=True)
    with pytest.raises(RecordingError, match=r"settings must stay as they were, newton.max_iterations = "):
        scenes.resume(tmp_path / "run", settings={"newton.max_iterations": 7}, **QUIET)
    chunk = tmp_path / "run/states/chunk_000000.npz"
    data = chunk.read_bytes()
    for damage in (data[:-100], b""):
        chunk.write_bytes(damage)
        with pytest.raises(RecordingError, match=r"chunk_000000.npz' is missing or damaged"):
            scenes.resume(tmp_path / "run", **QUIET)
    chunk.write_bytes(data)
    scene = tmp_path / "run/states/scene.json"
    scene.write_text(scene.read_text().replace('"motion":"dynamic"', '"motion":"fixed"'))
    with pytest.raises(RecordingError, match=r"describes another scene"):
        scenes.resume(tmp_path / "run", **QUIET)


def test_other_threads_and_a_scene_that_was_moved(tmp_path: Path, whole: Path) -> None:
    stopped(tmp_path, 11)
    (tmp_path / "swing.py").rename(tmp_path / "elsewhere.py")
    with pytest.raises(scenes.SceneFileError, match=r"swing.py' does not exist"):
        scenes.resume(tmp_path / "run", **QUIET)
    scenes.resume(tmp_path / "run", scene=tmp_path / "elsewhere.py", settings={"threads": 2}, **QUIET)
    resumed, expected = content(tmp_path / "run"), content(whole)
    assert (resumed["frames"], resumed["telemetry"]) == (expected["frames"], expected["telemetry"])


def test_an_exception_of_the_controller_leaves_the_state_before_it_acted(tmp_path: Path, whole: Path) -> None:
    scene = scenes.load(write_scene(tmp_path), {"fail_at": 0.205})
    with pytest.raises(ArithmeticError):
        scenes.run(scene, out=tmp_path / "run", fps=70.0, **QUIET)
    assert Recording(tmp_path / "run").status == "failed"
    checkpoint = Checkpoint.read(tmp_path / "run/checkpoint.stark")
    assert checkpoint.state.step_count == 21
    assert len(checkpoint.memory["history"]) == 3
    scenes.resume(tmp_path / "run", scene=scenes.load(tmp_path / "swing.py"), **QUIET)
    resumed, expected = content(tmp_path / "run"), content(whole)
    assert (resumed["frames"], resumed["telemetry"]) == (expected["frames"], expected["telemetry"])


def test_a_failed_step_leaves_the_last_good_state_to_go_on_from(tmp_path: Path, whole: Path) -> None:
    """The remedy of the message is a setting; with it the run goes on from where it failed."""
    hopeless = {"newton.max_iterations": 1, "newton.acceleration_tolerance": 1e-9, "time.min_step": 0.009}
    result = scenes.run(write_scene(tmp_path), out=tmp_path / "run", settings=hopeless, fps=70.0, **QUIET)
    assert result.status == "failed" and "max_iterations" in result.message
    run = Recording(tmp_path / "run")
    checkpoint = Checkpoint.read(tmp_path / "run/checkpoint.stark")
    steps = checkpoint.state.step_count
    assert len(run.telemetry) == steps + 1 and run.telemetry.rows[-1]["status"] == "failed"
    again = scenes.resume(tmp_path / "run", **QUIET)
    assert (again.status, again.message) == ("failed", result.message)
    assert len(Recording(tmp_path / "run").telemetry) == steps + 1
    mended = scenes.resume(tmp_path / "run", settings={"newton.max_iterations": 50}, **QUIET)
    assert (mended.status, mended.steps) == ("complete", 40)
    assert Recording(tmp_path / "run").status == "complete"


def test_scenes_that_changed_are_refused(tmp_path: Path) -> None:
    stopped(tmp_path, 5)
    before = content(tmp_path / "run")
    heavy = write_scene(tmp_path, "heavy.py", **{'mass=options["mass"]': "mass=1.25"})
    with pytest.raises(CheckpointError, match=r"another scene: it differs in mass of rigid 'box'"):
        scenes.resume(tmp_path / "run", scene=heavy, **QUIET)
    finer = write_scene(tmp_path, "finer.py", **{"grid(0.1, 0.1, 2)": "grid(0.1, 0.1, 3)"})
    with pytest.raises(CheckpointError, match=r"topology or pins of cloth 'cloth'"):
        scenes.resume(tmp_path / "run", scene=finer, **QUIET)
    assert content(tmp_path / "run") == before


def test_a_scene_file_that_was_edited_since_is_named(tmp_path: Path) -> None:
    """Its bodies are the same, so the run goes on, with the functions of the new file: once that is said."""
    file = write_scene(tmp_path)
    scenes.run(file, out=tmp_path / "run", until=0.1, **QUIET)
    scenes.resume(tmp_path / "run", until=0.15, **QUIET)  # no word: the file is the same
    file.write_text(file.read_text() + "\n\ndef observables(sim):\n    return {'half': 0.5}\n")
    with pytest.warns(stark.StarkWarning, match=r"scene file '.*' is not as it was before 0.15 s: .* anew"):
        scenes.resume(tmp_path / "run", until=0.2, **QUIET)
    scenes.resume(tmp_path / "run", until=0.25, **QUIET)
    assert Recording(tmp_path / "run").manifest["summary"]["observables"] == {"half": 0.5}


def test_folders_that_cannot_be_resumed(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match=r"cannot be resumed: no such folder; run the scene anew"):
        scenes.resume(tmp_path / "nothing")
    stopped(tmp_path, 2, checkpoint_every=None)
    assert not (tmp_path / "run/checkpoint.stark").exists()
    with pytest.raises(CheckpointError, match=r"cannot be resumed: it has no checkpoint"):
        scenes.resume(tmp_path / "run")
    stark.Simulation(scenes.load("stack").build()[0]).save(tmp_path / "run/checkpoint.stark")
    with pytest.raises(CheckpointError, match=r"was not written by 'stark run'"):
        scenes.resume(tmp_path / "run")
    stopped(tmp_path, 5)
    (tmp_path / "run/telemetry.jsonl").write_text("{}\n")
    with pytest.raises(stark.InvalidArgument, match=r"telemetry.jsonl' has 1 lines: must have 5"):
        scenes.resume(tmp_path / "run", **QUIET)
    (tmp_path / "run/frames/chunk_000000.npz").write_bytes(b"")
    with pytest.raises(RecordingError, match=r"chunk_000000.npz' is damaged"):
        scenes.resume(tmp_path / "run", **QUIET)


def test_memories_of_scene_files(tmp_path: Path) -> None:
    """They begin anew with every load, and must be dictionaries."""
    stopped(tmp_path, 3)
    first = scenes.load(tmp_path / "swing.py")
    assert first.memory["integral"] == 0.0 and first.memory["rng"] is None
    wrong = write_scene(tmp_path, "wrong.py", **{'memory = {"integral"': 'memory = 3; unused = {"integral"'})
    with pytest.raises(scenes.SceneFileError, match="memory must be a dictionary"):
        scenes.load(wrong)


def test_a_new_run_does_not_leave_the_checkpoint_of_the_old_one(tmp_path: Path) -> None:
    stopped(tmp_path, 5)
    stopped(tmp_path, 2, checkpoint_every=None)
    assert not (tmp_path / "run/checkpoint.stark").exists()


def _start(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "stark", "run", *words, "--quiet", "--no-replay", "--no-picture"]
    source = str(Path(stark.__file__).parent.parent)
    return subprocess.Popen(command, cwd=folder, env={**os.environ, "PYTHONPATH": source})


def _kill_under_way(process: subprocess.Popen[bytes], folder: Path, wait: float) -> bool:
    """kill -9 some time after the run has made progress; False when it came to its end before."""
    telemetry = folder / "telemetry.jsonl"
    before = telemetry.stat().st_size if telemetry.exists() else 0
    while process.poll() is None and (not telemetry.exists() or telemetry.stat().st_size <= before):
        time.sleep(0.01)
    try:
        process.wait(wait)
        return False
    except subprocess.TimeoutExpired:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        return True


def test_a_run_that_is_killed_again_and_again(tmp_path: Path) -> None:
    """kill -9 at random moments: nothing that is on disk is corrupt, no more than the steps after the last
    checkpoint are lost, and the run comes to the end of one that was never killed."""
    write_scene(tmp_path)
    assert _start(tmp_path, "swing.py", "--out", "whole", "--until", "1.5").wait() == 0
    folder, steps, kills = tmp_path / "out/swing", 0, 0
    process = _start(tmp_path, "swing.py", "--until", "1.5", "--checkpoint-every", "0")
    for wait in np.random.default_rng(3).uniform(0.0, 0.25, size=5):
        if not _kill_under_way(process, folder, wait):
            break
        kills += 1
        checkpoint = Checkpoint.read(folder / "checkpoint.stark")
        assert checkpoint.state.step_count >= steps
        steps = checkpoint.state.step_count
        run = Recording(folder)
        assert len(run) >= checkpoint.run["frames"]
        assert len(run.telemetry) - steps in (0, 1)  # a step that was taken, but not saved
        assert all(np.isfinite(run.positions("cloth", k)).all() for k in range(len(run)))
        process = _start(tmp_path, "--resume", "out/swing")
    assert process.wait() == 0 and kills > 1
    assert content(folder) == content(tmp_path / "whole")
    hashes = [Checkpoint.read(f / "checkpoint.stark").state.hash for f in (folder, tmp_path / "whole")]
    assert hashes[0] == hashes[1]


def test_command_line(tmp_path: Path, capfd: pytest.CaptureFixture[str], whole: Path) -> None:
    stopped(tmp_path, 8)
    assert _start(tmp_path, "--resume", "run").wait() == 0
    assert content(tmp_path / "run") == content(whole)
    assert main(["info", str(tmp_path / "run")]) == 0
    assert f"checkpoint at 0.4 s: stark run --resume {tmp_path / 'run'}" in capfd.readouterr().out
    assert main(["info", str(tmp_path / "run/checkpoint.stark")]) == 0
    assert "checkpoint at 0.4 s, after 40 steps" in (out := capfd.readouterr().out)
    assert "memory integral" in out and "body_position: 1" in out
    manifest = json.loads((tmp_path / "run/manifest.json").read_text())
    assert manifest["resumed"] == [pytest.approx(0.08)]
    for words, message in (
        (("--resume", "run", "--fps", "30"), "--fps is that of the run in run; leave it out"),
        (("--resume", "nowhere"), "'nowhere' cannot be resumed: no such folder"),
        (("swing.py", "--checkpoint-every", "-1"), "checkpoint_every = -1.0 s; must be >= 0 and finite"),
        ((), "give a scene, or --resume DIR"),
    ):
        assert _start(tmp_path, *words).wait() == 2
        assert message in capfd.readouterr().err
