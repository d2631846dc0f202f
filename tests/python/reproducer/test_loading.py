"""A step taken again from its folder: the same failure, the same bits, damaged files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import reproducer

UNTURNED = np.eye(3)


def pressed(**options: Any) -> stark.Simulation:
    """A press that is about to go deeper than a block is high."""
    scene = stark.Scene("pressed")
    scene.add_box((1.0, 1.0, 0.1), motion="fixed", name="table")
    scene.add_box(0.1, mass=0.1, position=(0, 0, 0.105), name="block")
    press = scene.add_box((0.2, 0.2, 0.1), motion="scripted", position=(0, 0, 0.21), name="press")
    sim = stark.Simulation(scene, time_step=0.01, **{"time.min_step": 0.006, **options})
    for _ in range(2):
        assert not sim.step().failed
    press.pose = (0, 0, 0.1), UNTURNED
    return sim


def test_a_failed_step_fails_again_in_another_process(tmp_path: Path) -> None:
    sim = pressed()
    report = sim.step()
    assert report.failed
    script = sim.write_reproducer(tmp_path / "failure")
    assert script.name == "reproduce.py"
    text = script.read_text()
    assert "Step 3 of the scene 'pressed' at t = 0.02 s, which failed." in text
    assert "rigid 'press'" in text or "rigid body 'press'" in text
    done = subprocess.run(
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert report.brief() in done.stdout
    assert "blocked_motion" in done.stdout
    assert report.diagnosis.finding in done.stdout


def test_a_failed_step_of_a_copy_has_the_same_bits(tmp_path: Path) -> None:
    sim = pressed()
    report = sim.step()
    sim.write_reproducer(tmp_path)
    again = reproducer.load(tmp_path)
    assert again.state == sim.state
    copy = again.step()
    assert copy.message == report.message
    assert copy.residual == report.residual
    assert copy.newton_iterations == report.newton_iterations
    assert copy.diagnosis.to_dict() == report.diagnosis.to_dict()


def test_short_steps_and_settings_come_along(tmp_path: Path) -> None:
    sim = pressed(**{"newton.max_iterations": 37, "gravity": (0, 0, -1.62)})
    sim.step(max_time_step=0.0071)
    script = sim.write_reproducer(tmp_path)
    assert "sim.step(max_time_step=0.0071)" in script.read_text()
    again = reproducer.load(tmp_path)
    assert again.settings == sim.settings


def test_damaged_files(tmp_path: Path) -> None:
    sim = pressed()
    sim.step()
    sim.write_reproducer(tmp_path)
    with pytest.raises(stark.ReproducerError, match="no such file"):
        reproducer.load(tmp_path / "elsewhere")
    data = tmp_path / "step.npz"
    whole = data.read_bytes()
    data.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(stark.ReproducerError, match="damaged"):
        reproducer.load(tmp_path)
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(stark.ReproducerError, match="cannot be written"):
        sim.write_reproducer(blocked)


def test_friction_with_a_direction_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_rigid(stark.mesh.grid(1.0, 1.0, 2), motion="fixed", name="floor")
    box = scene.add_box(0.1, mass=1.0, name="box", position=(0, 0, 0.0515), velocity=(1.0, 0.5, 0.0))
    box.surface_direction = (1.0, 0.0, 0.0)
    scene.friction[box, "floor"] = stark.Anisotropic(along=0.1, across=0.4)
    sim = stark.Simulation(scene, time_step=0.01)
    sim.step()
    sim.write_reproducer(tmp_path)
    again = stark.reproducer.load(tmp_path)
    again.step()
    assert again.state.hash == sim.state.hash
