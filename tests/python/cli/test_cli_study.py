"""``stark study``: its actions, what they print and their exit codes."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from _commands import command, environment

SCENE = """
import stark
until = 0.03
options = {"height": 2.0, "bad": False}
def build():
    if options["bad"]:
        raise ValueError("a bad scene\\x1b[31m")
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box", position=(0, 0, options["height"]))
    return scene, {"time_step": 0.01}
def measure(sim):
    return {"height": sim["box"].position[2]}
"""


@pytest.fixture
def plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fall.py").write_text(SCENE)
    path = tmp_path / "fall.toml"
    path.write_text('scene = "fall.py"\n[sampling]\nkind = "grid"\n[sampling.options]\nheight = [1.0, 2.0]\n')
    return path


def test_run_status_resume(plan: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("study", "run", "fall.toml", "--processes", 1) == 0
    assert capsys.readouterr() == (f"fall: 2 complete\n  {plan.parent}/out/fall/table.csv\n", "")
    assert command("study", "resume", "out/fall", "--quiet") == 0
    assert capsys.readouterr() == ("", "")
    assert command("study", "status", "out/fall") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == [f"fall: 2 runs of {plan.parent}/fall.py", "       2 complete"]


def test_failures_end_with_1_and_are_told_without_escapes(
    plan: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan.write_text(plan.read_text() + "bad = [false, true]\n")
    assert command("study", "run", plan, "--processes", 1, "--out", "here") == 1
    out, err = capsys.readouterr()
    assert out.startswith("here: 2 complete, 2 error\n")
    assert err == "".join(
        f"stark: run {k} error: ValueError: a bad scene\\x1b[31m (fall.py, line 7)\n" for k in (1, 3)
    )
    assert command("study", "status", "here") == 0
    assert "  run 1 error: ValueError: a bad scene" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("run", "missing.toml"), "plan 'missing.toml' does not exist"),
        (("run", "fall"), "plan 'fall'; must be a TOML file"),
        (("run", "fall.toml", "--processes", "0"), "processes = 0; must be an integer from 1"),
        (("status", "nowhere"), "is not a study folder"),
        (("resume", "nowhere"), "is not a study folder"),
        (("show", "nowhere"), "is not a study folder"),
    ],
)
def test_bad_input_is_one_line_and_2(
    plan: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], message: str
) -> None:
    assert command("study", *words) == 2
    err = capsys.readouterr().err
    assert err.startswith("stark: ") and err.count("\n") == 1 and message in err
    assert not (plan.parent / "out").exists()


def test_a_bar_of_all_runs_on_a_terminal(plan: Path) -> None:
    main_end, other_end = pty.openpty()
    words = [sys.executable, "-m", "stark", "study", "run", str(plan), "--processes", "1"]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=other_end, env=environment(), timeout=60)
    os.close(other_end)
    shown = b""
    try:
        while part := os.read(main_end, 4096):
            shown += part
    except OSError:  # Linux: the other end is closed
        pass
    os.close(main_end)
    assert done.returncode == 0
    assert "━" in shown.decode() and "2 of 2 runs" in shown.decode() and shown.endswith(b"\r\x1b[K")
