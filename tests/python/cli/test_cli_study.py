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
    table = f"{plan.parent}/out/fall/table.csv"
    assert capsys.readouterr() == (f"fall: 2 complete\n  made 2, kept 0 of before\n  {table}\n", "")
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


def test_what_was_kept_and_what_the_table_lacks_is_told(
    plan: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A longer plan keeps results; a shorter one keeps them in the folder."""
    whole = plan.read_text()
    told = []
    for text in (whole, whole.replace("[1.0, 2.0]", "[1.0, 2.0, 3.0]"), whole.replace("[1.0, 2.0]", "[3.0]")):
        plan.write_text(text)
        assert command("study", "run", "fall.toml", "--processes", 1) == 0
        told.append(capsys.readouterr().out.splitlines()[:-1])
    others = "  2 results in the folder of other plans, scene files or versions of Stark: not in the table"
    assert told == [
        ["fall: 2 complete", "  made 2, kept 0 of before"],
        ["fall: 3 complete", "  made 1, kept 2 of before"],
        ["fall: 1 complete", "  made 0, kept 1 of before", others],
    ]
    assert command("study", "status", "out/fall") == 0
    assert others in capsys.readouterr().out
    plan.write_text(whole)
    assert command("study", "run", "fall.toml") == 0
    assert "made 0, kept 2 of before" in capsys.readouterr().out


def test_plans_and_files_are_no_study_folders(plan: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("study", "run", "fall.toml", "--processes", 1, "--quiet") == 0
    for action in ("resume", "status", "show"):
        for given, message in (
            ("fall.toml", "if it is a plan, make or go on with its study by stark study run"),
            ("out/fall/study.json", f"give its folder, '{plan.parent}/out/fall'"),
            ("fall.py", "is a file, not the folder of a study"),
        ):
            assert command("study", action, given) == 2
            assert message in capsys.readouterr().err
    (plan.parent / "out/fall/study.json").write_text("{")
    assert command("study", "resume", "out/fall") == 2
    assert "anew, which keeps results: stark study run PLAN.toml --out" in capsys.readouterr().err
    assert command("study", "run", "fall.toml") == 0
    assert "made 0, kept 2 of before" in capsys.readouterr().out


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
