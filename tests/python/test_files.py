"""What cannot be written is named, with a remedy, and nothing that is no file is replaced."""

from __future__ import annotations

import errno
import os
import socket
import stat
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import stark
from stark import array_file, scenes
from stark.array_file import WriteError, write_atomically
from stark.checkpoint import CheckpointError
from stark.cli import main
from stark.recording import Recorder, Recording, RecordingError
from stark.render import write_png

_SCENE = '''
"""A box that falls."""

import stark

until = 0.2  # [s]


def settings():
    return {"time_step": 0.01}


def build():
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box")
    return scene
'''

_QUIET = ("--quiet", "--no-replay", "--no-picture")


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


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))


def _linked_pipe(path: Path) -> None:
    os.mkfifo(path.with_name("far"))
    path.symlink_to(path.with_name("far"))


# --- what is no file ---


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (_pipe, "a device, pipe or socket"),
        (_linked_pipe, "a device, pipe or socket"),
        (_socket, "a device, pipe or socket"),
        (Path.mkdir, "a folder"),
    ],
)
def test_what_is_no_file_stays_where_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sim, make: Callable[[Path], None], what: str
) -> None:
    monkeypatch.chdir(tmp_path)  # names of sockets are short
    path = Path("here")
    make(path)
    before = os.lstat(path)
    with pytest.raises(
        CheckpointError, match=f"checkpoint 'here' cannot be written: it is {what}, not a file"
    ):
        sim.save(path)
    with pytest.raises(stark.Error, match=f"it is {what}, not a file; choose another name"):
        write_png(path, np.zeros((2, 2, 3), dtype=np.uint8))
    after = os.lstat(path)
    assert (after.st_ino, stat.S_IFMT(after.st_mode)) == (before.st_ino, stat.S_IFMT(before.st_mode))
    assert not list(tmp_path.glob(".*"))


def test_files_and_links_to_files_are_replaced(tmp_path: Path, sim) -> None:
    (tmp_path / "file").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    for name in ("file", "link", "dangling", "new"):
        sim.save(tmp_path / name)
        sim.load(tmp_path / name)


def test_a_reproducer_does_not_replace_a_pipe(tmp_path: Path, sim) -> None:
    sim.step()
    os.mkfifo(tmp_path / "reproduce.py")
    with pytest.raises(
        stark.ReproducerError, match=r"reproducer '.*reproduce.py' cannot be written: it is a"
    ):
        sim.write_reproducer(tmp_path)


def test_a_certificate_does_not_go_into_a_pipe(tmp_path: Path, scene: Path, capsys) -> None:
    assert main(["run", str(scene), "--out", str(tmp_path / "run"), *_QUIET]) == 0
    os.mkfifo(tmp_path / "pipe")
    for name in ("pipe", "nowhere/certificate.json"):
        words = ["verify", str(tmp_path / "run"), "--out", str(tmp_path / name), "--quiet"]
        assert main(words) == 2
        error = capsys.readouterr().err
        assert error.startswith(f"stark: certificate '{tmp_path / name}' cannot be written: ")


# --- what the system refuses ---


@pytest.mark.parametrize(
    ("number", "remedy"),
    [
        (errno.ENOSPC, "No space left on device; make room, or choose another disk"),
        (errno.EDQUOT, "; make room, or choose another disk"),
        (errno.EACCES, "Permission denied; choose another place"),
    ],
)
def test_errors_of_the_system_name_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sim, number: int, remedy: str
) -> None:
    def fsync(file: int) -> None:
        raise OSError(number, os.strerror(number))

    path = tmp_path / "file"
    path.write_text("old")
    monkeypatch.setattr(array_file.os, "fsync", fsync)
    with pytest.raises(WriteError, match=f"file' cannot be written: .*{remedy}") as caught:
        write_atomically(path, lambda file: None)
    assert caught.value.errno == number and isinstance(caught.value, stark.Error)
    with pytest.raises(CheckpointError, match=f"checkpoint '.*file' cannot be written: .*{remedy}"):
        sim.save(path)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_folders_that_do_not_exist(tmp_path: Path, sim) -> None:
    with pytest.raises(CheckpointError, match="No such file or directory; choose a folder that exists"):
        sim.save(tmp_path / "nowhere/state.stark")


@pytest.mark.parametrize("number", [errno.ENOENT, errno.EROFS, errno.ENOSPC])
def test_folders_of_runs_that_cannot_be_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scene: Path, sim, capsys, number: int
) -> None:
    def mkdir(path: Path, *args: object, **kwargs: object) -> None:
        raise OSError(number, os.strerror(number), str(path))

    monkeypatch.setattr(Path, "mkdir", mkdir)
    folder = tmp_path / "run"
    with pytest.raises(RecordingError, match=r"recording '.*run' cannot be written: .*; "):
        Recorder(folder, sim)
    assert main(["run", str(scene), "--out", str(folder), *_QUIET]) == (1 if number == errno.ENOSPC else 2)
    error = capsys.readouterr().err
    assert error.startswith(f"stark: recording '{folder}' cannot be written: {os.strerror(number)}; ")
    assert error.count("\n") == 1


@pytest.mark.parametrize("left", [2, 9, 30])
def test_a_disk_that_is_full(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scene: Path, capsys, left: int
) -> None:
    """One line with the file and a remedy, exit code 1; with room, the run goes on from its checkpoint."""
    folder, calls, fsync = tmp_path / "run", [0], os.fsync

    def full(file: int) -> None:
        calls[0] += 1
        if calls[0] > left:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(file)

    with monkeypatch.context() as patched:
        patched.setattr(array_file.os, "fsync", full)
        words = ["run", str(scene), "--out", str(folder), "--checkpoint-every", "0", *_QUIET]
        assert main(words) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"'{folder}/" in error
    assert "cannot be written: No space left on device; make room, or choose another disk" in error
    if (folder / "checkpoint.stark").exists():
        assert scenes.resume(folder, replay=False, picture=False).status == "complete"
        assert len(Recording(folder).telemetry) == 20


def test_telemetry_that_does_not_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scene: Path, capsys
) -> None:
    class Full:
        def write(self, text: str) -> int:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        flush = close = lambda self: None

        def fileno(self) -> int:
            return 1

    begin = Recorder.record_state

    def record_state(self: Recorder, sim: stark.Simulation) -> None:
        begin(self, sim)
        self._telemetry.close()
        self._telemetry._file = Full()

    monkeypatch.setattr(Recorder, "record_state", record_state)
    monkeypatch.setattr("stark.telemetry.os.fsync", lambda file: None)
    assert main(["run", str(scene), "--out", str(tmp_path / "run"), *_QUIET]) == 1
    assert "telemetry.jsonl' cannot be written: No space left on device; make room" in capsys.readouterr().err
