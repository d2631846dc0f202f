"""What functions of scene files may not do, and how a run ends when they fail."""

from __future__ import annotations

from pathlib import Path

import pytest

from stark.cli import main
from stark.recording import Recording

_SCENE = """
import stark
until = 0.03
def settings():
    return {"time_step": 0.01, "contact.enabled": False}
def build():
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box")
    return scene
"""


def _run(tmp_path: Path, functions: str, *words: str) -> int:
    path = tmp_path / "box.py"
    path.write_text(_SCENE + functions)
    out = str(tmp_path / "run")
    return main(["run", str(path), "--out", out, "--no-replay", "--no-picture", "--quiet", *words])


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("run.positions('bx', -1)", "bx"),
        ("raise stark.InvalidArgument('not blue')", "InvalidArgument: not blue (box.py, line 11)"),
        ("{}['height']", "KeyError: 'height' (box.py, line 11)"),
        ("open('/nowhere/reference.txt')", "FileNotFoundError: "),
    ],
)
def test_whatever_a_check_raises_ends_the_run_with_1(line: str, told: str, tmp_path: Path, capsys) -> None:
    assert _run(tmp_path, f"def check(run):\n    {line}\n") == 1
    error = capsys.readouterr().err
    assert "box: wrong: the scene's check raised" in error and told in error
    assert Recording(tmp_path / "run").status == "complete"


@pytest.mark.parametrize("caller", ["drive", "measure", "observables"])
@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("sim.step()", "step()"),
        ("sim.run_until(1.0)", "run()"),
        ("sim.state = sim.state", "state = ..."),
        ("sim.load(FILE)", "load()"),
    ],
)
def test_functions_take_no_steps(caller: str, line: str, what: str, tmp_path: Path, capsys) -> None:
    saved = f"FILE = {str(tmp_path / 'a.stark')!r}\n"
    function = f"def {caller}(sim):\n    sim.save(FILE)\n    {line}\n    return {{}}\n"
    assert _run(tmp_path, saved + function) == 2
    error = capsys.readouterr().err
    assert f"{caller}(sim) of the scene uses sim.{what} at 0" in error and "the run " in error
    assert Recording(tmp_path / "run").status == "failed"


def test_drive_may_simulate_something_else(tmp_path: Path) -> None:
    assert _run(tmp_path, "def drive(sim):\n    stark.Simulation(build()).step()\n") == 0
    assert len(Recording(tmp_path / "run").telemetry) == 3


def test_bench_takes_its_steps_itself(tmp_path: Path, capsys) -> None:
    path = tmp_path / "box.py"
    path.write_text(_SCENE + "def drive(sim):\n    sim.step()\n")
    assert main(["bench", str(path)]) == 2
    assert "drive(sim) of the scene uses sim.step()" in capsys.readouterr().err


def test_a_memory_that_cannot_be_kept_ends_the_recording(tmp_path: Path, capsys) -> None:
    deep = "memory = {}\ndef drive(sim):\n    memory['x'] = x = []\n    for _ in range(3000):\n"
    deep += "        x.append([])\n        x = x[0]\n"
    assert _run(tmp_path, deep) == 2
    assert "nested deeper than 50 levels" in capsys.readouterr().err
    assert Recording(tmp_path / "run").status == "failed"
