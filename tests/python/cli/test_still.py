"""``stark still``: cameras, bodies and clip planes on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from _commands import command
from fake_simulation import FakeSimulation, record

from stark.recording import Recorder, Recording
from stark.render import read_png

SMALL = ("--size", "80x45", "--quality", "draft")


def test_options_are_those_of_pictures(tmp_path: Path) -> None:
    run, file = tmp_path / "run", tmp_path / "a.png"
    record(run, 2)
    words = [
        "--camera=-0.5,-0.6,0.2",
        "--target",
        "cloth",
        "--fov",
        50,
        "--hide",
        "floor",
        "--opacity",
        "c*=0.5",
    ]
    assert command("still", run, *SMALL, *words, "--clip=0,0,0:0,-1,0", "--out", file) == 0
    expected = Recording(run).still(
        1e9, width=80, height=45, quality="draft", camera=(-0.5, -0.6, 0.2), target="cloth",
        field_of_view=np.radians(50), hide="floor", opacity={"cloth": 0.5}, clip=((0, 0, 0), (0, -1, 0)),
    )  # fmt: skip
    assert np.array_equal(read_png(file), expected)
    assert command("still", run, *SMALL, "--only", "cloth", "--target", "0,0,0.1", "--out", file) == 0
    expected = Recording(run).still(
        1e9, width=80, height=45, quality="draft", bodies="cloth", target=(0, 0, 0.1)
    )
    assert np.array_equal(read_png(file), expected)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--camera", "here"), "--camera 'here': must be three numbers like 0.5,-0.7,0.4"),
        (("--target", "1,2"), "target = '1,2': no body has such a name"),
        (("--target", "cup"), "target = 'cup': no body has such a name"),
        (("--opacity", "cloth"), "--opacity 'cloth': must be BODY=NUMBER"),
        (("--opacity", "cloth=2"), "opacity of 'cloth' = 2: must be in [0, 1]"),
        (("--clip", "0,0,0"), "--clip: normal '': must be three numbers"),
        (("--fov", "180"), "field_of_view = 3.14159 rad: must be in (0, 3]"),
    ],
)
def test_bad_options_are_one_line_and_2(tmp_path: Path, capsys, words, message: str) -> None:
    record(tmp_path / "run", 1)
    assert command("still", tmp_path / "run", *SMALL, *words) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and message in err


def test_a_still_shows_a_recorded_field(tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    sim, run, file = FakeSimulation(), tmp_path / "run", tmp_path / "a.png"
    height = {"height [m]": lambda s: {"cloth": s.bodies[0].positions[:, 2]}}
    with Recorder(run, sim, arrays=height) as recorder:
        recorder.record(sim)
    words = ("--field", "height [m]", "--limits=-0.05,0.05", "--colormap", "magma")
    assert command("still", run, *SMALL, *words, "--out", file) == 0
    expected = Recording(run).still(
        0.0, width=80, height=45, quality="draft", field="height [m]", limits=(-0.05, 0.05), colormap="magma"
    )
    assert np.array_equal(read_png(file), expected)
    assert command("still", run, *SMALL, "--limits", "low", "--out", file) == 2
    assert "must be two numbers" in capsys.readouterr().err
    assert command("still", run, *SMALL, "--contacts", "--out", file) == 2
    assert "the recording has none" in capsys.readouterr().err


def test_times_that_the_recording_does_not_have_are_told(tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    run, file = tmp_path / "run", tmp_path / "a.png"
    record(run, 3)
    told = "the recording has frames from 0 s to 0.1 s, the nearest of them is taken"
    for words in (
        ("still", run, *SMALL, "--out", file),
        ("export", run, "--format", "obj", "--out", tmp_path),
    ):
        for time in ("99", "-1"):
            assert command(*words, f"--time={time}") == 0
            assert f"--time {time}: {told} for {time} s" in capsys.readouterr().err
        assert command(*words, "--time=nan") == 2
        assert "time = nan: must be a time" in capsys.readouterr().err


@pytest.mark.parametrize("words", [("--speed", "0"), ("--speed=-1",), ("--fps", "nan"), ("--out", "a.xyz")])
def test_films_that_cannot_be_are_one_line_and_2(tmp_path: Path, capsys, words) -> None:  # type: ignore[no-untyped-def]
    record(tmp_path / "run", 1)
    assert command("video", tmp_path / "run", "--size", "80x45", *words) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and err.startswith("stark: write_video: ")
