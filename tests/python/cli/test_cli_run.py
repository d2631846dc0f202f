"""``stark run``: what it leaves, when it fails, options, and what scene files may do wrong."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from _commands import FALL, command, environment

import stark
from stark.recording import Recording
from stark.render import read_png


def test_run_leaves_recording_page_and_picture(fall: Path, tmp_path: Path, capsys) -> None:
    assert command("run", fall, "--out", tmp_path / "run") == 0
    run = Recording(tmp_path / "run")
    assert run.status == "complete"
    assert len(run.telemetry) == 10
    assert run.times[-1] == pytest.approx(0.1)
    assert run.settings["newton.max_iterations"] == 55
    assert run.manifest["summary"]["observables"]["z"] == pytest.approx(-0.054, rel=0.01)
    assert read_png(tmp_path / "run/picture.png").shape == (720, 1280, 3)
    assert "patch" in (tmp_path / "run/replay.html").read_text()
    out, err = capsys.readouterr()
    assert err == ""
    assert "0.1 s simulated" in out and "10 steps" in out and "check passed" in out and "replay.html" in out


def test_run_can_be_silent_and_bare(fall: Path, tmp_path: Path, capsys) -> None:
    assert command("run", fall, "--out", tmp_path / "run", "--quiet", "--no-replay", "--no-picture") == 0
    assert capsys.readouterr() == ("", "")
    assert sorted(p.name for p in (tmp_path / "run").iterdir()) == [
        "checkpoint.stark",
        "frames",
        "manifest.json",
        "telemetry.jsonl",
    ]
    bare = ("--quiet", "--no-replay", "--no-picture", "--no-checkpoint")
    assert command("run", fall, "--out", tmp_path / "run", *bare) == 0
    assert not (tmp_path / "run/checkpoint.stark").exists()


def test_command_line_wins_over_the_file(fall: Path, tmp_path: Path) -> None:
    words = (
        "--set",
        "newton.max_iterations=77",
        "--set",
        "time_step=0.02",
        "--threads",
        "2",
        "--until",
        "0.04",
    )
    assert command("run", fall, "--out", tmp_path / "run", "--quiet", "--no-picture", *words) == 0
    settings = Recording(tmp_path / "run").settings
    assert settings["newton.max_iterations"] == 77
    assert settings["time.step"] == 0.02
    assert settings["execution.threads"] == 2
    assert len(Recording(tmp_path / "run").telemetry) == 2


def test_fps_thins_the_frames_but_keeps_the_last(fall: Path, tmp_path: Path) -> None:
    assert command("run", fall, "--out", tmp_path / "run", "--quiet", "--no-picture", "--fps", "25") == 0
    run = Recording(tmp_path / "run")
    assert run.times == pytest.approx([0.0, 0.04, 0.08, 0.1])
    assert len(run.telemetry) == 10


_NO_CONVERGENCE = {
    "newton.max_iterations=1": "one iteration never converges here",
    "newton.step_tolerance=1e-300": "unreachable",
    "newton.acceleration_tolerance=1e-300": "unreachable",
    "time.min_step=0.01": "no smaller step is allowed",
}


def test_a_failed_step_ends_the_run_with_1(fall: Path, tmp_path: Path, capsys) -> None:
    words = [word for name in _NO_CONVERGENCE for word in ("--set", name)]
    assert command("run", fall, "--out", tmp_path / "run", "--no-picture", *words) == 1
    run = Recording(tmp_path / "run")
    assert run.status == "failed"
    assert len(run.telemetry) == 1 and run.telemetry.rows[0]["status"] == "failed"
    assert (tmp_path / "run/replay.html").exists()
    assert "failed" in capsys.readouterr().err


def test_a_failed_check_ends_the_run_with_1(fall: Path, tmp_path: Path, capsys) -> None:
    fall.write_text(FALL + "\ndef check(run):\n    assert False, 'the patch is blue'\n")
    assert command("run", fall, "--out", tmp_path / "run", "--no-replay", "--no-picture") == 1
    assert "the scene's check failed: the patch is blue" in capsys.readouterr().err
    assert Recording(tmp_path / "run").status == "complete"


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("import numpyy", "No module named 'numpyy'"),
        ("def drive(sim): sim['pach']", "unknown body 'pach' (did you mean 'patch'?): must be the name of"),
        ("def check(run): assert not run", "the scene's check failed: an assert without a message"),
    ],
)
def test_errors_of_a_scene_file_name_its_line(
    code: str, text: str, fall: Path, tmp_path: Path, capsys
) -> None:
    fall.write_text(FALL + "\n" + code + "\n")
    assert command("run", fall, "--out", tmp_path / "run", "--no-replay", "--no-picture") in (1, 2)
    complaint = capsys.readouterr().err
    assert text in complaint and f"({fall.name}, line {len(fall.read_text().splitlines())})" in complaint


def test_a_run_loads_its_scene_file_once(fall: Path, tmp_path: Path, capfd) -> None:
    fall.write_text(FALL + "\nprint('loaded')\n")
    assert command("run", fall, "--out", tmp_path / "run", "--no-replay", "--no-picture") == 0
    assert capfd.readouterr().out.count("loaded") == 1


def test_a_shortened_run_is_not_checked(fall: Path, tmp_path: Path) -> None:
    fall.write_text(FALL + "\ndef check(run):\n    assert False\n")
    assert command("run", fall, "--out", tmp_path / "run", "--until", "0.05", "--quiet", "--no-picture") == 0


def test_drive_is_called_before_every_step(tmp_path: Path) -> None:
    path = tmp_path / "drive.py"
    path.write_text(
        """
import stark
until = 0.05
def build():
    scene = stark.Scene()
    scene.add_box(0.1, name="box", motion="scripted")
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=1), stark.materials.cotton, position=(0, 0, 5.0))
    return scene, {"time_step": 0.01}
def drive(sim):
    sim["box"].position = (sim.time + sim.time_step, 0, 0)
"""
    )
    assert command("run", path, "--out", tmp_path / "run", "--quiet", "--no-picture", "--fps", "100") == 0
    run = Recording(tmp_path / "run")
    assert run.positions("box")[:, :, 0].mean(axis=1) == pytest.approx(run.times, abs=1e-6)


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


def test_options_change_a_scene_and_measured_series_are_telemetry(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "fall.py").write_text(_MEASURED)
    monkeypatch.chdir(tmp_path)
    few = ("--quiet", "--no-picture", "--no-replay")
    assert command("run", "fall.py", *few) == 0
    assert command("run", "fall.py", "--option", "height=3", "--option", "label=plain", *few) == 0
    low, high = (Recording(f"out/{name}").telemetry for name in ("fall", "fall_3.0"))
    # Implicit Euler falls by g h^2 n (n + 1) / 2.
    drop = [9.81e-4 * n * (n + 1) / 2 for n in (1, 2, 3)]
    assert 2.0 - low["measured.height"] == pytest.approx(drop, rel=1e-9)
    assert 3.0 - high["measured.height"] == pytest.approx(drop, rel=1e-9)


def test_options_of_packaged_scenes_do_not_stay(monkeypatch) -> None:
    from stark import scenes
    from stark.scenes import stack

    defaults = {"count": 3, "fast": False, "mesh": ""}
    monkeypatch.delattr(stack, "_default_options", raising=False)  # of an earlier load
    monkeypatch.setattr(stack, "options", dict(defaults), raising=False)
    changed = scenes.load("stack", {"count": "5", "fast": "true", "mesh": "cups/a.obj"})
    assert changed.name == "stack_5_True_cups-a.obj"
    assert stack.options == {"count": 5, "fast": True, "mesh": "cups/a.obj"}
    assert scenes.load("stack").name == "stack" and stack.options == defaults
    monkeypatch.delattr(stack, "_default_options")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--option", "width=2"), "scene 'fall' has no option 'width'; its options: height, label"),
        (("--option", "height=tall"), "scene 'fall': option height = 'tall'; must be a float"),
        (("--option", "height"), "--option height: must be NAME=VALUE"),
    ],
)
def test_wrong_options_are_refused(tmp_path: Path, capsys, words, message: str) -> None:
    path = tmp_path / "fall.py"
    path.write_text(_MEASURED)
    assert command("run", path, "--out", tmp_path / "run", *words) == 2
    assert message in capsys.readouterr().err and not (tmp_path / "run").exists()


def test_functions_that_are_misspelt_are_warned_of(tmp_path: Path, capsys) -> None:
    """They were not called, in silence."""
    path = tmp_path / "fall.py"
    path.write_text(_MEASURED.replace("def measure(", "def mesure(") + "\n\ndef helper(sim):\n    pass\n")
    with pytest.warns(stark.StarkWarning, match=r"does not call mesure\(\); if measure\(\) is meant") as told:
        assert command("run", path, "--out", tmp_path / "run", "--quiet") == 0
    assert not any("helper" in str(warning.message) for warning in told)


def test_what_is_measured_has_to_be_numbers(tmp_path: Path, capsys) -> None:
    path = tmp_path / "fall.py"
    path.write_text(_MEASURED.replace("position[2]", "position"))
    assert command("run", path, "--out", tmp_path / "run", "--quiet") == 2
    assert "scene 'fall': measure() returned 'height' = array(" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("def build(): pass\noptions = 3", "options must be a dictionary"),
        ("x = 1", "defines no build(); add a function that returns a stark.Scene"),
        ("build = 3", "build must be a function"),
        ("def build(): pass", "build() returned nothing; end it with 'return scene'"),
        (
            "def build(): return 1, 2, 3",
            "build() returned 3 values; must return a stark.Scene or (scene, settings)",
        ),
        ("def build(): return 7", "must be a stark.Scene"),
        ("def build(scene): pass", "build() must accept no arguments"),
        ("def build(): pass\ndef drive(): pass", "drive() must accept one argument"),
        ("def build(): pass\nuntil = 'soon'", "until = 'soon' s; must be a positive number"),
        ("def build(): pass\nuntil = -1", "until = -1 s; must be a positive number"),
        (
            "def build(): pass\ndef settings(): return 3",
            "settings of settings() are a int; must be a dictionary",
        ),
        ("def build(:", "line 1"),
        ("import stark\ndef build(): return stark.Scene()", "has 0 bodies"),
        ("import stark\ndef build(): return stark.Scene(), {'newton.max_iteration': 3}", "max_iterations"),
    ],
)
def test_bad_scene_files(tmp_path: Path, capsys, source: str, message: str) -> None:
    path = tmp_path / "scene.py"
    path.write_text(
        source if "until" in source else f"until = 1.0\n{source}" if "(:" not in source else source
    )
    assert command("run", path, "--out", tmp_path / "run") == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("stark: ") and err.count("\n") == 1
    assert message in err
    assert not (tmp_path / "run").exists()


_LONG = FALL.replace("until = 0.1", "until = 1e6").replace("cells=2", "cells=20")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_stopping_leaves_a_complete_recording(tmp_path: Path, number: int) -> None:
    path = tmp_path / "long.py"
    path.write_text(_LONG)
    command = [sys.executable, "-m", "stark", "run", str(path), "--out", str(tmp_path / "run")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment())
    telemetry = tmp_path / "run/telemetry.jsonl"
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and not (telemetry.exists() and telemetry.read_text().count("\n") >= 2):
        time.sleep(0.02)
    sent = time.monotonic()
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    # A second is the aim on a free machine; the rest is for a busy one and for writing the page.
    assert time.monotonic() - sent < 5.0
    assert process.returncode == 130, err.decode()
    run = Recording(tmp_path / "run")
    assert run.status == "interrupted"
    assert len(run.telemetry) >= 2 and len(run) >= 2
    # The last state is there; the step it came from may have been stopped before it was reported.
    assert 0.0 <= run.times[-1] - run.telemetry["time"][-1] + 1e-9 < 0.011
    assert "interrupted" in err.decode() and "Traceback" not in err.decode()


def test_a_bar_on_a_terminal_and_silence_in_a_pipe(fall: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "stark", "run", str(fall), "--no-replay", "--no-picture", "--out"]
    main_end, other_end = pty.openpty()
    with subprocess.Popen(
        [*command, str(tmp_path / "a")], stdout=subprocess.PIPE, stderr=other_end, env=environment()
    ) as process:
        process.communicate(timeout=60)
    os.close(other_end)
    shown = b""
    try:
        while part := os.read(main_end, 4096):
            shown += part
    except OSError:  # Linux: the other end is closed
        pass
    os.close(main_end)
    assert "━" in shown.decode() and " % " in shown.decode() and shown.endswith(b"\r\x1b[K")
    done = subprocess.run([*command, str(tmp_path / "b")], capture_output=True, env=environment(), timeout=60)
    assert done.returncode == 0 and done.stderr == b""


def test_a_run_records_fields_for_its_page(fall: Path, tmp_path: Path, capsys) -> None:
    run, other = tmp_path / "run", tmp_path / "other"
    words = ("--until", "0.03", "--quiet", "--no-picture")
    assert command("run", fall, "--out", run, *words) == 0
    recording = Recording(run)
    assert [entry.name for entry in recording.fields] == ["stress", "pressure"] and recording.has_contacts
    assert recording.field("stress", -1)["patch"].shape == (9,)
    assert "von Mises stress" in (run / "replay.html").read_text()
    assert command("run", fall, "--out", other, *words, "--no-replay", "--fields", "speed", "strain") == 0
    recording = Recording(other)
    assert [entry.name for entry in recording.fields] == ["speed", "strain"]
    # Free fall by implicit Euler: 3 steps of 0.01 s.
    assert recording.field("speed", -1)["patch"] == pytest.approx(0.03 * 9.81, rel=0.01)
    assert command("replay", run, "--overlay", other, "--out", tmp_path / "two.html") == 0
    assert '"overlay":{"name":"other"' in (tmp_path / "two.html").read_text()
    assert command("run", fall, "--out", other, *words, "--no-fields") == 0
    assert Recording(other).fields == [] and not (other / "fields").exists()
    capsys.readouterr()
    assert command("run", fall, "--out", other, "--no-fields", "--fields", "speed") == 2
    assert command("run", fall, "--out", other, "--fields", "sped") == 2
    assert command("run", "--resume", run, "--fields", "speed") == 2
    errors = capsys.readouterr().err
    assert "give one of them" in errors and "field 'sped' is unknown" in errors and "leave it out" in errors


def test_a_run_needs_no_standard_error_output(tmp_path: Path) -> None:
    """Services close it; the run ended with an error of Python then."""
    words = 'exec "$0" -m stark run hello_cloth --until 0.02 --no-picture --no-replay --out "$1" 2>&-'
    arguments = ["sh", "-c", words, sys.executable, str(tmp_path / "run")]
    ended = subprocess.run(arguments, stdout=subprocess.PIPE, env=environment())
    assert ended.returncode == 0 and b"0.02 s simulated" in ended.stdout
