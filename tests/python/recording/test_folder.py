"""What a recording replaces in its folder, and what it leaves and names."""

from __future__ import annotations

from pathlib import Path

import pytest

import stark
from stark import scenes

#: Fails from 0.02 s on where `broken` is there.
SCENE = """
import os
import stark
until = 0.04
def build():
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    pull = scene.add_force(box, (0.0, 0.0, 1.0))
    return scene
def drive(sim):
    broken = os.path.exists(os.path.join(os.path.dirname(__file__), "broken"))
    sim.energies["force"].force = (0.0, 0.0, 1e300 if broken and sim.time > 0.015 else 1.0)
def settings():
    return {"time_step": 0.01}
"""


def falling_box() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    return stark.Simulation(scene, time_step=0.01)


def record(sim: stark.Simulation, folder: Path) -> None:
    with stark.recording.Recorder(folder, sim) as recorder:
        recorder.record(sim)


def test_a_new_run_leaves_nothing_of_an_earlier_one(tmp_path: Path) -> None:
    """Its picture and its failed step stayed beside the new recording."""
    file = tmp_path / "pull.py"
    file.write_text(SCENE)
    (tmp_path / "broken").touch()
    run = tmp_path / "run"
    assert scenes.run(file, out=run).status == "failed"
    assert (run / "failure").is_dir() and (run / "picture.png").is_file()
    (tmp_path / "broken").unlink()
    assert scenes.run(file, out=run, picture=False).status == "complete"
    assert not (run / "failure").exists() and not (run / "picture.png").exists()


def test_a_resumed_run_has_no_failed_step_any_more(tmp_path: Path) -> None:
    file = tmp_path / "pull.py"
    file.write_text(SCENE)
    (tmp_path / "broken").touch()
    run = tmp_path / "run"
    assert scenes.run(file, out=run, checkpoint_every=0.0).status == "failed"
    assert (run / "failure").is_dir()
    (tmp_path / "broken").unlink()
    assert scenes.resume(run).status == "complete"
    assert not (run / "failure").exists()


def test_what_was_made_of_an_earlier_recording_is_named(tmp_path: Path) -> None:
    sim = falling_box()
    run = tmp_path / "run"
    record(sim, run)
    (run / "vtu").mkdir()
    for name in ("video.mp4", "notes.txt"):
        (run / name).touch()
    with pytest.warns(stark.StarkWarning, match=r"keeps what was made of .*: video\.mp4, vtu; remove it"):
        record(sim, run)
    assert (run / "vtu").is_dir() and (run / "notes.txt").is_file()


def test_links_are_removed_and_not_followed(tmp_path: Path) -> None:
    sim = falling_box()
    run, outside = tmp_path / "run", tmp_path / "outside"
    record(sim, run)
    outside.mkdir()
    (outside / "mine").touch()
    (run / "failure").symlink_to(outside)
    (run / "picture.png").symlink_to(outside / "mine")
    record(sim, run)
    assert (outside / "mine").is_file()
    assert not (run / "failure").is_symlink() and not (run / "picture.png").is_symlink()
