"""kill -9 at every moment of a run, and of resuming it: the folder can be resumed and ends up as that of a
run that was never killed, or it has no checkpoint yet and can be run anew."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from _kills import Snapshot, every_moment, restore
from _runs import content, write_scene

import stark
from stark import scenes
from stark.checkpoint import CheckpointError
from stark.recording import Recorder
from stark.verify import UnreadableRecording, verify

QUIET = {"replay": False, "picture": False}
UNTIL = 0.1  # [s] 10 steps


@pytest.fixture(autouse=True)
def short_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of four frames and states, so that a short run has several. Waiting for the disk matters when
    the machine goes down, not when a process is killed."""
    monkeypatch.setitem(Recorder.__init__.__kwdefaults__, "chunk_frames", 4)
    monkeypatch.setattr(os, "fsync", lambda file: None)


def _run(folder: Path, every: float) -> None:
    scenes.run(
        write_scene(folder),
        out=folder / "run",
        until=UNTIL,
        fps=70.0,
        certify=True,
        checkpoint_every=every,
        **QUIET,
    )


def _require_resumable(moment: Snapshot, folder: Path, whole: dict[str, object]) -> bool:
    """Whether there was a checkpoint."""
    restore(moment, folder)
    if "checkpoint.stark" not in moment:
        with pytest.raises(CheckpointError, match="it has no checkpoint; run the scene anew"):
            scenes.resume(folder, **QUIET)
        return False
    assert verify(folder).verdict != "violated", verify(folder).text()
    scenes.resume(folder, **QUIET)
    assert content(folder) == whole
    assert sorted(p.name for p in folder.iterdir()) == sorted(
        ["checkpoint.stark", "frames", "manifest.json", "states", "telemetry.jsonl"]
    )
    return True


@pytest.mark.parametrize("every", [0.0, 1e9])
def test_every_moment_of_a_run(tmp_path: Path, every: float) -> None:
    """With a checkpoint after each step, and with none but the first: chunks are then written long after
    it."""
    tmp_path.joinpath("run").mkdir()
    with every_moment(tmp_path / "run") as moments:
        _run(tmp_path, every)
    whole = content(tmp_path / "run")
    assert len(moments) > (100 if every == 0.0 else 40)
    if every == 0.0:
        moments = moments[:30] + moments[30::6]  # all kinds of moments are there, many times
    resumable = [
        _require_resumable(moment, tmp_path / f"killed_{k}", whole) for k, moment in enumerate(moments)
    ]
    first = resumable.index(True)
    assert all(resumable[first:])
    for k, moment in enumerate(moments[:first]):
        again = restore(moment, tmp_path / f"anew_{k}" / "run")
        _run(again.parent, 1e9)
        assert content(again) == whole


def test_every_moment_of_resuming(tmp_path: Path) -> None:
    """Also of a run that had come to its end, where resuming takes away what is beyond the checkpoint."""
    tmp_path.joinpath("run").mkdir()
    with every_moment(tmp_path / "run") as moments:
        _run(tmp_path, 1e9)
    whole = content(tmp_path / "run")
    resumable = [moment for moment in moments if "checkpoint.stark" in moment]
    count = 0
    for k in (len(resumable) // 2, len(resumable) - 1):
        folder = restore(resumable[k], tmp_path / f"killed_{k}")
        with every_moment(folder) as again:
            scenes.resume(folder, **QUIET)
        assert content(folder) == whole
        for j, moment in enumerate(again):
            count += _require_resumable(moment, tmp_path / f"killed_{k}_{j}", whole)
    assert count > 10


def test_every_moment_of_replacing_a_recording(tmp_path: Path) -> None:
    """A new run into the folder of an old one: what is left is the old one's or the new one's, or is run
    anew."""
    _run(tmp_path, 0.0)
    with every_moment(tmp_path / "run") as moments:
        _run(tmp_path, 0.0)
    whole = content(tmp_path / "run")
    for k, moment in enumerate(moments[:40]):
        folder = restore(moment, tmp_path / f"killed_{k}" / "run")
        if "checkpoint.stark" not in moment:
            _run(folder.parent, 1e9)
        else:
            scenes.resume(folder, **QUIET)
        assert content(folder) == whole


def test_what_is_left_before_the_first_checkpoint_is_readable_or_says_why(tmp_path: Path) -> None:
    tmp_path.joinpath("run").mkdir()
    with every_moment(tmp_path / "run") as moments:
        _run(tmp_path, 1e9)
    for k, moment in enumerate(moments):
        folder = restore(moment, tmp_path / f"killed_{k}")
        try:
            assert verify(folder).verdict != "violated"
        except UnreadableRecording as error:
            assert str(folder) in str(error) and "checkpoint.stark" not in moment


_KILLED = '''
"""A box falls; the process is killed in step 40, once."""

import os
import signal

import stark

until = 0.3  # [s]


def settings():
    return {"time_step": 0.005, "contact.enabled": False}


def build():
    scene = stark.Scene()
    scene.add_box(0.1, mass=0.5, position=(0.0, 0.0, 0.2), name="box")
    return scene


def drive(sim):
    if sim.time > 39.5 * 0.005 and not os.path.exists("once"):
        open("once", "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
'''


def test_a_certified_run_that_is_killed_between_checkpoints(tmp_path: Path) -> None:
    """The process itself, once: beyond the first chunk of 32 states, with the first checkpoint only."""
    (tmp_path / "fall.py").write_text(_KILLED)
    words = [sys.executable, "-m", "stark", "run", "--quiet", "--no-replay", "--no-picture"]
    environment = {**os.environ, "PYTHONPATH": str(Path(stark.__file__).parent.parent)}
    killed = subprocess.run(
        [*words, "fall.py", "--certify"], cwd=tmp_path, env=environment, check=False, timeout=60
    )
    assert killed.returncode == -9
    assert (tmp_path / "out/fall/run.lock").exists()
    subprocess.run([*words, "--resume", "out/fall"], cwd=tmp_path, env=environment, check=True, timeout=60)
    certificate = verify(tmp_path / "out/fall")
    assert certificate.recording["states"] == 61
    assert certificate["chain"].status == "verified"
