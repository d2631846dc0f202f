"""The command stark: its verbs, wrong usage, exit codes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from _commands import command, environment

from stark.cli import VERBS
from stark.recording import Recording
from stark.render import read_png


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("run", "hello_clot"), "no scene is called 'hello_clot'; did you mean 'hello_cloth'?"),
        (("run", "missing.py"), "scene file 'missing.py' does not exist"),
        (("run", "hello_cloth", "--set", "newton.max_iteration=3"), "newton.max_iterations"),
        (("run", "hello_cloth", "--set", "newton.max_iterations=0"), "newton.max_iterations"),
        (("run", "hello_cloth", "--set", "mu=0.2"), "options of the scene file are given by --option"),
        (("run", "hello_cloth", "--set", "nonsense"), "must have the form name=value"),
        (("run", "hello_cloth", "--until", "-3"), "until = -3.0 s; must be positive"),
        (("run", "hello_cloth", "--until", "nan"), "must be positive"),
        (("run", "hello_cloth", "--fps", "0"), "fps = 0.0; must be positive"),
        (("run", "hello_cloth", "--threads", "-2"), "threads"),
        (("still", "nowhere"), "'nowhere' is not a run folder"),
        (("replay", "nowhere"), "'nowhere' is not a run folder"),
        (("export", "nowhere"), "'nowhere' is not a run folder"),
        (("still", "nowhere", "--size", "big"), "size 'big': must be WIDTHxHEIGHT in pixels"),
    ],
)
def test_bad_input_is_one_line_and_2(tmp_path: Path, monkeypatch, capsys, words, message: str) -> None:
    monkeypatch.chdir(tmp_path)
    assert command(*words) == 2
    err = capsys.readouterr().err
    assert err.startswith("stark: ") and err.count("\n") == 1
    assert message in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [(), ("fly",), ("run", "hello_cloth", "--until", "x")])
def test_wrong_usage(words, capsys) -> None:
    assert command(*words) == 2
    assert "usage: stark" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("verfy", "out"), "did you mean 'verify'?"),
        (("resume", "out"), "did you mean 'stark run --resume DIR'?"),
        (("view", "drop"), "did you mean 'stark run SCENE --view'?"),
        (
            ("run", "hello_cloth", "--untill", "1"),
            "unrecognized arguments: --untill 1; did you mean '--until'?",
        ),
        (("still", "out", "--camra=1,2,3"), "did you mean '--camera'?"),
        (("still", "out", "--contacts", ""), "an argument is empty"),
        (("run", "drop", "mass=2"), "unrecognized arguments: mass=2; did you mean '--option mass=2'?"),
    ],
)
def test_misspelt_verbs_and_options(words, hint: str, capsys) -> None:
    assert command(*words) == 2
    assert hint in capsys.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_an_output_on_a_full_disk_is_named() -> None:
    """[Errno 28] stood alone, as if it were that of a recording."""
    with open("/dev/full", "w") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "stark", "info"],
            stdout=full,
            stderr=subprocess.PIPE,
            env=environment() | {"PYTHONUNBUFFERED": "1"},
            text=True,
        )
    assert ended.returncode == 1
    assert ended.stderr.startswith("stark: '<stdout>' cannot be written: No space left on device; make room")


def test_help_lists_all_verbs(capsys) -> None:
    assert command("--help") == 0
    out = capsys.readouterr().out
    assert all(verb in out for verb in VERBS)
    for verb in VERBS:
        assert command(verb, "--help") == 0


def test_verbs_that_look_at_a_run(fall: Path, tmp_path: Path, capsys) -> None:
    run = tmp_path / "run"
    assert command("run", fall, "--out", run, "--quiet", "--no-replay", "--no-picture") == 0
    assert command("replay", run, "--stride", 3) == 0
    assert (run / "replay.html").exists()
    assert (
        command("still", run, "--time", 0.05, "--size", "64x48", "--quality", "draft", "--view", "side") == 0
    )
    assert read_png(run / "still.png").shape == (48, 64, 3)
    assert "has frames from" not in capsys.readouterr().err
    assert command("still", run, "--time", 9, "--size", "64x48", "--quality", "draft") == 0
    assert (
        "--time 9: the recording has frames from 0 s to 0.1 s, the nearest of them "
        in capsys.readouterr().err
    )
    assert command("export", run, "--csv") == 0
    assert len(list((run / "vtu").glob("*.vtu"))) == len(Recording(run))
    assert len(list((run / "vtu").glob("*.pvd"))) == 1
    assert "residual [N]" in (run / "vtu/telemetry.csv").read_text()
    assert command("export", run, "--format", "obj", "--time", 0.0, "--out", tmp_path / "obj") == 0
    assert len(list((tmp_path / "obj").iterdir())) == 1
    assert command("info", run) == 0
    out = capsys.readouterr().out
    assert "patch: 9 vertices, 8 triangles" in out and "z = -0.05" in out
