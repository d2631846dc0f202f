"""Run folders belong to one writer and lead nowhere else, whatever others put into them."""

from __future__ import annotations

import json
import math
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import scenes
from stark.cli import main
from stark.files import plain_name, printable
from stark.recording import Recorder, Recording, RecordingError, export
from stark.recording.lock import FolderLock
from stark.telemetry import Telemetry
from stark.verify import verify

ROOT = Path(__file__).resolve().parents[2]
QUIET = ("--quiet", "--no-replay", "--no-picture")

_SCENE = '''
"""A box that falls."""

import os

import stark

until = 0.05  # [s]
options = {"folder": "", "endless": False}


def settings():
    return {"time_step": 0.01}


def build():
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box")
    return scene


def drive(sim):
    while options["endless"] and sim.time > 0.025:
        pass
    if options["folder"]:
        os.makedirs(options["folder"], exist_ok=True)
        os.chdir(options["folder"])
'''


@pytest.fixture
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box")
    return stark.Simulation(scene, time_step=0.01)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "fall.py"
    path.write_text(_SCENE)
    return path


@pytest.fixture
def run(tmp_path: Path, scene: Path) -> Path:
    assert main(["run", str(scene), "--out", str(tmp_path / "run"), "--certify", *QUIET]) == 0
    return tmp_path / "run"


# --- one writer ---


def _start(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "stark", "run", *words, *QUIET]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.Popen(command, cwd=folder, env=environment)


def test_a_run_that_is_under_way_keeps_its_folder(
    tmp_path: Path, scene: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """A second run and a second --resume are refused and change nothing; when the first is killed, its lock
    is none any more."""
    process = _start(
        tmp_path, "fall.py", "--out", "run", "--option", "endless=true", "--checkpoint-every", "0"
    )

    def files() -> dict[Path, bytes]:
        return {
            p: p.read_bytes() for p in (tmp_path / "run").rglob("*") if p.suffix != ".tmp" and p.is_file()
        }

    try:
        end = time.monotonic() + 30.0
        telemetry = tmp_path / "run/telemetry.jsonl"
        before: dict[Path, bytes] = {}
        while not (telemetry.exists() and telemetry.read_bytes().count(b"\n") == 3 and before == files()):
            assert process.poll() is None and time.monotonic() < end
            before = files()
            time.sleep(0.2)
        for words in (["fall.py", "--out", "run"], ["--resume", "run"]):
            assert _start(tmp_path, *words).wait(30) == 2
            error = capfd.readouterr().err
            assert f"is in use by process {process.pid} on {socket.gethostname()} since 20" in error
            assert "wait for that run or stop it, or choose another folder" in error
        assert files() == before
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert (tmp_path / "run/run.lock").exists()
    finally:
        process.kill()
        process.wait()
    resumed = scenes.resume(tmp_path / "run", scene=scenes.load(scene), replay=False, picture=False)
    assert (resumed.status, resumed.steps) == ("complete", 5)
    assert not (tmp_path / "run/run.lock").exists()


def test_two_recorders_of_one_process(tmp_path: Path, sim: stark.Simulation) -> None:
    first = Recorder(tmp_path / "run", sim)
    first.record(sim)
    with pytest.raises(RecordingError, match=f"in use by process {os.getpid()} on "):
        Recorder(tmp_path / "run", sim)
    first.close()
    assert len(Recording(tmp_path / "run")) == 1
    Recorder(tmp_path / "run", sim).close()
    abandoned = Recorder(tmp_path / "run", sim)
    del abandoned
    Recorder(tmp_path / "run", sim).close()


def test_a_recorder_that_could_not_begin_leaves_no_lock(tmp_path: Path, sim: stark.Simulation) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run/other").write_text("mine")
    with pytest.raises(RecordingError, match="is not empty and holds no recording"):
        Recorder(tmp_path / "run", sim)
    assert [p.name for p in (tmp_path / "run").iterdir()] == ["other"]


def test_a_lock_that_was_taken_over_is_not_removed(tmp_path: Path) -> None:
    first = FolderLock(tmp_path)
    first.path.unlink()  # by a user who thinks that nobody has it
    second = FolderLock(tmp_path)
    first.release()
    assert second.path.exists()
    with pytest.raises(RecordingError, match="in use"):
        FolderLock(tmp_path)
    second.release()
    assert not list(tmp_path.iterdir())


def test_a_child_of_the_owner_does_not_lift_the_lock(tmp_path: Path) -> None:
    code = (
        "import os, sys; from pathlib import Path; from stark.recording.lock import FolderLock\n"
        "lock = FolderLock(Path(sys.argv[1]))\n"
        "child = os.fork()\n"
        "if child: os.waitpid(child, 0); assert lock.path.exists()\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], env=environment, check=True, timeout=60)
    assert not list(tmp_path.iterdir())


# --- nothing leads out of the folder ---


def _outside(tmp_path: Path) -> Path:
    folder = tmp_path / "outside"
    folder.mkdir()
    (folder / "mine").write_text("mine")
    return folder


def _edit(run: Path, change: Callable[[dict[str, Any]], None]) -> None:
    manifest = json.loads((run / "manifest.json").read_text())
    change(manifest)
    (run / "manifest.json").write_text(json.dumps(manifest))


@pytest.mark.parametrize("name", ["../../x", "/tmp/x", "..", "a\0b", "", "x" * 400, "a/../../b", "~"])
def test_names_of_scenes_are_no_paths(tmp_path: Path, run: Path, name: str) -> None:
    _edit(run, lambda manifest: manifest.update(scene=name))
    for path in export(Recording(run), tmp_path / "files", "vtu"):
        assert path.parent == tmp_path / "files"
    assert {p.name for p in tmp_path.iterdir()} == {"fall.py", "files", "run", *_imported(tmp_path)}


def _imported(folder: Path) -> set[str]:
    return {p.name for p in folder.iterdir() if p.name == "__pycache__"}


def test_nothing_is_written_through_links_of_a_run_folder(tmp_path: Path, run: Path, scene: Path) -> None:
    """Links in a folder that somebody sent, in the place of each file and folder that Stark writes there."""
    outside = _outside(tmp_path)
    for name in ("certificate.json", "replay.html", "still.png", "picture.png", "run.lock"):
        (run / name).symlink_to(outside / "mine")
    for name in ("vtu", "failure"):
        (run / name).symlink_to(outside)
    telemetry = (run / "telemetry.jsonl").read_bytes()
    (outside / "telemetry").write_bytes(telemetry + b"mine\n")
    (run / "telemetry.jsonl").unlink()
    (run / "telemetry.jsonl").symlink_to(outside / "telemetry")
    before = {p: p.read_bytes() for p in outside.iterdir()}
    main(["verify", str(run), "--quiet"])
    main(["replay", str(run)])
    main(["still", str(run), "--size", "16x16", "--quality", "draft"])
    assert main(["export", str(run)]) == 2
    assert main(["run", "--resume", str(run), "--until", "0.06", "--quiet"]) == 2  # run.lock is a link
    (run / "run.lock").unlink()
    main(["run", "--resume", str(run), "--until", "0.06", "--quiet"])
    assert {p: p.read_bytes() for p in outside.iterdir()} == before
    for name in ("frames", "states"):
        for path in (run / name).iterdir():
            path.unlink()
        (run / name).rmdir()
        (run / name).symlink_to(outside)
    assert main(["run", str(scene), "--out", str(run), "--certify", *QUIET]) == 0
    assert {p: p.read_bytes() for p in outside.iterdir()} == before
    assert verify(run).verdict == "certified"


def test_a_failed_run_does_not_write_its_reproducer_through_a_link(tmp_path: Path, scene: Path) -> None:
    outside = _outside(tmp_path)
    failing = tmp_path / "failing.py"
    hopeless = {"newton.max_iterations": 1, "newton.acceleration_tolerance": 1e-9, "time.min_step": 0.016}
    text = _SCENE.replace('{"time_step": 0.01}', repr(hopeless))
    text = text.replace("add_box(0.1,", "add_box((0.1, 0.2, 0.3),")  # it tumbles
    failing.write_text(text.replace("name=", "angular_velocity=(30.0, 20.0, 10.0), name="))
    assert main(["run", str(failing), "--out", str(tmp_path / "run"), *QUIET]) == 1
    assert (tmp_path / "run/failure/reproduce.py").exists()
    for path in (tmp_path / "run/failure").iterdir():
        path.unlink()
    (tmp_path / "run/failure").rmdir()
    (tmp_path / "run/failure").symlink_to(outside)
    assert main(["run", str(failing), "--out", str(tmp_path / "run"), *QUIET]) == 1
    assert [p.name for p in outside.iterdir()] == ["mine"]


def test_a_planted_temporary_file_is_not_written_through(tmp_path: Path) -> None:
    outside = _outside(tmp_path)
    path = tmp_path / "telemetry.csv"
    path.with_name(f".{path.name}.{os.getpid()}.tmp").symlink_to(outside / "mine")
    Telemetry([{"step": 0}]).to_csv(path)
    assert path.read_text().startswith("step [1]") and (outside / "mine").read_text() == "mine"


def test_a_scene_file_that_came_with_the_folder_is_not_executed(
    tmp_path: Path, run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A checkpoint names the scene file to go on with, and a scene file is code."""
    from stark.checkpoint import Checkpoint

    evil = run / "evil.py"
    evil.write_text(f"open({str(tmp_path / 'executed')!r}, 'w').close()\n")
    monkeypatch.chdir(tmp_path)
    checkpoint = Checkpoint.read(run / "checkpoint.stark")
    for name in (str(evil), "run/evil.py", "./run/../run/evil.py", str(run / "../run/evil.py")):
        assert checkpoint.run is not None
        checkpoint.run["plan"]["scene"] = name
        checkpoint.write(run / "checkpoint.stark")
        assert main(["run", "--resume", str(run), *QUIET]) == 2
        assert "say which scene it is: stark run SCENE --resume" in capsys.readouterr().err
    assert not (tmp_path / "executed").exists()


# --- pipes, sizes, escapes ---


@pytest.mark.parametrize(
    "name",
    [
        "manifest.json",
        "telemetry.jsonl",
        "frames/topology.npz",
        "frames/chunk_000000.npz",
        "states/scene.json",
        "states/mesh.npz",
        "states/chunk_000000.npz",
        "checkpoint.stark",
        "run.lock",
    ],
)
@pytest.mark.parametrize("make", [os.mkfifo, lambda path: os.symlink("/dev/zero", path), os.mkdir])
def test_pipes_devices_and_folders_are_refused(
    run: Path, name: str, make: Callable[[Path], None], capsys: pytest.CaptureFixture[str]
) -> None:
    """Reading them would never end. One line says what is wrong; where a verb does not need the file, it
    works."""
    path = run / name
    path.unlink(missing_ok=True)
    make(path)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.alarm(30)
    try:
        for words in (
            ["info"],
            ["verify", "--quiet"],
            ["replay"],
            ["export", "--csv"],
            ["still", "--size", "16x16"],
        ):
            code = main([words[0], str(run), *words[1:]])
            error = capsys.readouterr().err
            assert (code == 0 and error == "") or (code == 2 and error.count("\n") == 1)
        code = main(["run", "--resume", str(run), "--until", "0.06", *QUIET])
        assert code == (0 if name == "replay.html" else 2)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize(
    "change",
    [
        lambda m: m.update(chunk_count=10**18, frame_count=10**18),
        lambda m: m.update(frame_count=10**18),
        lambda m: m.update(chunk_frames=10**18),
        lambda m: m["bodies"][0].update(vertex_count=10**15),
        lambda m: m["bodies"][0].update(triangle_count=10**15),
        lambda m: m["states"].update(count=10**18, chunk_count=10**18),
        lambda m: m["chain"].update(lines=10**18),
        lambda m: m.update(bodies=[m["bodies"][0]] * 5),
    ],
)
def test_counts_are_bounded_before_memory_is_asked_for(run: Path, change: Callable[[Any], None]) -> None:
    import tracemalloc

    _edit(run, change)
    tracemalloc.start()
    try:
        for verb in ("info", "verify", "replay", "export", "still"):
            assert main([verb, str(run), *(["--size", "16x16"] if verb == "still" else [])]) in (0, 1, 2, 3)
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()


def test_a_description_of_a_gigabyte_is_not_read(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Going on with a run compared it whole with that of the scene."""
    import tracemalloc

    with (run / "states/scene.json").open("wb") as file:  # a hole
        file.truncate(1 << 30)
    tracemalloc.start()
    try:
        assert main(["run", "--resume", str(run), "--until", "0.06", *QUIET]) != 0
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()
    assert "more than" in capsys.readouterr().err


@pytest.mark.parametrize("number", [math.nan, -math.inf])
def test_a_manifest_with_numbers_that_json_lacks_is_damaged(
    run: Path, number: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """`run --resume` wrote it again, which raised ValueError."""
    _edit(run, lambda m: m["bodies"][0].update(contact_distance=number))
    capsys.readouterr()
    assert main(["run", "--resume", str(run), "--until", "0.06", *QUIET]) == 2
    assert "manifest.json' is damaged: " in capsys.readouterr().err


def test_a_manifest_without_its_date_goes_on(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is of an older version, or lost its chain, too: a KeyError at the end of `run --resume`."""
    _edit(run, lambda m: [m.pop(key, None) for key in ("created", "chain")])
    assert main(["run", "--resume", str(run), "--until", "0.06", *QUIET]) in (0, 2)
    assert "Traceback" not in capsys.readouterr().err


def test_shapes_that_a_file_only_claims(run: Path) -> None:
    """A good archive with a header of 24 TB."""
    import zipfile

    path = run / "states/chunk_000000.npz"
    with zipfile.ZipFile(path) as archive:
        items = {name: archive.read(name) for name in archive.namelist()}
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 8, 3), }".ljust(117) + b"\n"
    data = items["positions_0000.npy"]
    items["positions_0000.npy"] = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + data[128:]
    with zipfile.ZipFile(path, "w") as archive:
        for name, stored in items.items():
            archive.writestr(name, stored)
    with pytest.raises(stark.verify.UnreadableRecording, match="claims the shape"):
        verify(run)


_EVIL = "\x1b]0;owned\x07\x1b[31m\u202eevil\r\n\x9b2J\ud800"


def test_what_a_terminal_obeys_is_never_printed(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def change(manifest: dict[str, Any]) -> None:
        manifest.update(
            scene=_EVIL, status="complete" + _EVIL, message=_EVIL, created=_EVIL, stark_version=_EVIL
        )
        manifest["bodies"][0].update(name=_EVIL, kind=_EVIL)
        manifest["summary"] = {"observables": {_EVIL: 1.0}}
        manifest["settings"][_EVIL] = 1.0

    _edit(run, change)
    scene = json.loads((run / "states/scene.json").read_text())
    scene["bodies"][0]["name"] = _EVIL
    (run / "states/scene.json").write_text(json.dumps(scene))
    for words in (
        ["info"],
        ["verify"],
        ["export"],
        ["still", "--size", "16x16"],
        ["replay"],
        ["verify", "--json"],
    ):
        main([words[0], str(run), *words[1:]])
        captured = capsys.readouterr()
        for text in (captured.out, captured.err):
            assert all(c.isprintable() or c == "\n" for c in text), words
    _edit(run, lambda manifest: manifest.update(bodies=[{"name": _EVIL}]))
    main(["info", str(run)])
    assert capsys.readouterr().err.isascii()


def test_the_checker_alone_prints_no_escapes(run: Path) -> None:
    _edit(run, lambda manifest: manifest.update(scene="\x1b[31m"))
    command = [sys.executable, str(ROOT / "python/stark/verify"), str(run)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert "\x1b" not in done.stdout and "\\x1b[31m: violated" in done.stdout


def test_verbs_print_by_way_of_one_module() -> None:
    """So that no text of a file gets past it."""
    for path in sorted((ROOT / "python/stark/cli").glob("*.py")):
        lines = [line for line in path.read_text().splitlines() if " print(" in line]
        if path.name == "output.py":
            assert lines
        elif path.name == "verify.py":
            assert len(lines) == 1 and "json.dumps" in lines[0]  # in ASCII
        else:
            assert not lines, path


def test_texts_for_terminals_and_names_of_files() -> None:
    assert printable("a\tb\x1b\u202e\ud800é\n") == "a\\tb\\x1b\\u202e\\ud800é\n"
    assert [plain_name(n, "run") for n in ("../a", "..", "", "a b.c", "é/x")] == [
        "_a",
        "run",
        "run",
        "a b.c",
        "é_x",
    ]


# --- paths ---


def test_a_scene_that_changes_the_current_folder(
    tmp_path: Path, scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    other = tmp_path / "elsewhere"
    words = ["run", "fall.py", "--out", "out/run", "--option", f"folder={other}", "--checkpoint-every", "0"]
    assert main([*words, "--certify"]) == 0
    assert Path.cwd() == other and not list(other.iterdir())
    run = tmp_path / "out/run"
    assert {"replay.html", "picture.png", "checkpoint.stark"} <= {p.name for p in run.iterdir()}
    assert verify(run).verdict == "certified"
    monkeypatch.chdir(tmp_path)
    assert main(["run", "--resume", "out/run", "--until", "0.08", "--quiet", "--no-picture"]) == 0
    assert not list(other.iterdir()) and len(Recording(run).telemetry) == 8


def test_a_recording_is_found_from_other_folders(
    tmp_path: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    recording = Recording("run")
    recording._cache.clear()
    monkeypatch.chdir("/")
    assert np.isfinite(recording.positions("box", -1)).all() and len(recording.telemetry) == 5


@pytest.mark.parametrize("path", [3, b"a", "", "a\0b", "a\ud800b", ["a"]])
@pytest.mark.parametrize(
    ("call", "what"),
    [
        (lambda sim, scene, path: Recorder(path, sim), "recording: folder"),
        (lambda sim, scene, path: Recording(path), "recording: folder"),
        (lambda sim, scene, path: scenes.run(scene, out=path), "run: out"),
        (lambda sim, scene, path: scenes.resume(path), "resume: folder"),
        (lambda sim, scene, path: stark.mesh.load(path), "mesh.load: path"),
        (lambda sim, scene, path: stark.mesh.grid(1.0, 1.0, 1).save(path), "save: path"),
        (lambda sim, scene, path: Telemetry([]).to_csv(path), "to_csv: path"),
        (
            lambda sim, scene, path: stark.render.write_png(path, np.zeros((2, 2, 3), np.uint8)),
            "write_png: path",
        ),
        (lambda sim, scene, path: verify(path), "verify: folder"),
    ],
)
def test_what_is_no_path_is_refused(
    call: Callable[[Any, Any, Any], Any],
    what: str,
    path: Any,
    sim: stark.Simulation,
    scene: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError) as raised:
        call(sim, scene, path)
    assert str(raised.value).startswith(f"{what} = {path!r}: must be ")
    assert {p.name for p in tmp_path.iterdir()} - _imported(tmp_path) == {"fall.py"}


def test_empty_words_are_no_paths(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (
        ["run", "hello_cloth", "--out", ""],
        ["verify", ""],
        ["export", ""],
        ["run", "--resume", ""],
    ):
        assert main(words) == 2
        assert "must be a path" in capsys.readouterr().err
