"""``stark info``: scenes, options, settings, recordings."""

from __future__ import annotations

import shlex
from pathlib import Path

from _commands import command

_MEASURED = """
import stark
until = 0.03
options = {"height": 2.0, "label": "plain"}
def settings():
    return {"time_step": 0.01}
def build():
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box", position=(0, 0, options["height"]))
    return scene
def measure(sim):
    return {"height": sim["box"].position[2]}
"""


def test_info_lists_the_options(tmp_path: Path, capsys) -> None:
    (tmp_path / "fall.py").write_text(_MEASURED)
    assert command("info", tmp_path / "fall.py") == 0
    assert "  option height = 2.0\n  option label = plain\n" in capsys.readouterr().out


def test_info_about_scenes_and_settings(fall: Path, capsys) -> None:
    assert command("info") == 0
    assert "spinning_box_cloth_32" in capsys.readouterr().out
    assert command("info", fall) == 0
    out = capsys.readouterr().out
    assert "A patch falls freely." in out and "runs for 0.1 s" in out and "patch" in out
    assert command("info", "--settings") == 0
    out = capsys.readouterr().out
    assert "newton.max_iterations = " in out and "contact.distance = 0.0 m" in out


def test_commands_that_it_names_can_be_copied(tmp_path: Path, capsys) -> None:
    """Folders with spaces go into quotes."""
    (tmp_path / "fall.py").write_text(_MEASURED)
    out = tmp_path / "a run"
    assert command("run", tmp_path / "fall.py", "--out", out, "--no-replay", "--no-picture") == 0
    capsys.readouterr()
    assert command("info", out) == 0
    told = capsys.readouterr().out
    line = next(line for line in told.splitlines() if "--resume" in line)
    assert shlex.split(line)[-4:] == ["stark", "run", "--resume", str(out)]
