"""Ctrl-C at any moment of ``stark run``: one line, exit code 130, a second at most, and it can be resumed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from stark import _interrupts
from stark.recording.format import CHECKPOINT

pytestmark = [
    pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="needs /proc"),
    pytest.mark.alone,
]

_SCENE = """
import time
import stark
until = 1e6
def build():
    {building}
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 12), position=(0, 0, 0.1))
    return scene, {{"time_step": 0.005}}
def drive(sim):
    {driving}
"""

#: A second is the aim on a free machine; the rest is for a busy one.
_LATEST = 5.0


class Run:
    """``stark run`` of a scene in a process of its own."""

    def __init__(self, folder: Path, *, building: str = "pass", driving: str = "pass") -> None:
        scene = folder / "fall.py"
        scene.write_text(_SCENE.format(building=building, driving=driving))
        self.out = folder / "run"
        command = [sys.executable, "-m", "stark", "run", str(scene), "--out", str(self.out)]
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=env, text=True
        )

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *error: object) -> None:
        self.process.kill()
        self.process.wait()

    def wait_until(self, condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 60.0
        while not condition():
            assert self.process.poll() is None, self.process.communicate()
            assert time.monotonic() < deadline
            time.sleep(0.002)

    def has_loaded(self, name: str) -> bool:
        return name in Path(f"/proc/{self.process.pid}/maps").read_text()

    def interrupt(self, times: int = 1, pause: float = 0.0) -> str:
        """Its last words."""
        sent = time.monotonic()
        for _ in range(times):
            self.process.send_signal(signal.SIGINT)
            time.sleep(pause)
        _, err = self.process.communicate(timeout=60)
        assert time.monotonic() - sent < _LATEST
        assert self.process.returncode == 130, err
        return err

    def can_be_resumed(self) -> bool:
        resume = [
            sys.executable,
            "-m",
            "stark",
            "run",
            "--resume",
            str(self.out),
            "--until",
            "1e-9",
            "--quiet",
        ]
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        done = subprocess.run(resume, capture_output=True, env=env, text=True, timeout=60, check=False)
        return done.returncode == 0 or "give a later end" in done.stderr


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.6])
def test_at_any_time_from_the_import_on(delay: float, tmp_path: Path) -> None:
    with Run(tmp_path) as run:
        run.wait_until(lambda: run.has_loaded("_multiarray_umath"))
        time.sleep(delay)
        err = run.interrupt()
        assert err.startswith("stark: ") and "interrupted" in err and err.count("\n") == 1, err
        assert not run.out.exists() or run.can_be_resumed()


def test_while_a_scene_is_built(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    with Run(tmp_path, building=f"open({str(begun)!r}, 'w').close(); time.sleep(60)") as run:
        run.wait_until(begun.exists)
        assert run.interrupt() == "stark: interrupted\n"
        assert not run.out.exists()


def test_while_python_executes_a_string(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    code = f"open({str(begun)!r}, 'w').close(); import time; time.sleep(60)"
    with Run(tmp_path, building=f"exec({code!r})") as run:
        run.wait_until(begun.exists)
        assert run.interrupt() == "stark: interrupted\n"


def test_as_soon_as_there_is_a_folder(tmp_path: Path) -> None:
    with Run(tmp_path) as run:
        run.wait_until(run.out.exists)
        assert run.interrupt().count("\n") == 1
        assert (run.out / CHECKPOINT).exists() and run.can_be_resumed()


def test_in_code_of_the_user(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    driving = (
        "from pathlib import Path\n"
        f"    begun = Path({str(begun)!r})\n"
        "    if not begun.exists(): begun.touch(); time.sleep(60)"
    )
    with Run(tmp_path, driving=driving) as run:
        run.wait_until(begun.exists)
        err = run.interrupt()
        assert "interrupted" in err and err.count("\n") == 1
        assert run.can_be_resumed()


def test_twice_at_once_is_once(tmp_path: Path) -> None:
    with Run(tmp_path) as run:
        run.wait_until(lambda: (run.out / CHECKPOINT).exists())
        err = run.interrupt(times=3, pause=0.01)
        assert err.count("\n") == 1 and "Traceback" not in err
        assert run.can_be_resumed()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_again_while_the_process_ends(number: signal.Signals, tmp_path: Path) -> None:
    with Run(tmp_path) as run:
        run.wait_until(lambda: (run.out / CHECKPOINT).exists())
        run.process.send_signal(number)
        until = time.monotonic() + 0.9  # later than a second after the first, one leaves at once
        while run.process.poll() is None and time.monotonic() < until:
            run.process.send_signal(number)
            time.sleep(0.0005)
        _, err = run.process.communicate(timeout=60)
        assert run.process.returncode == 130 and err.count("\n") == 1, err


def test_raised_where_nothing_can_be_it_is_not_lost(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    building = (
        "class Slow:\n"
        f"        def __del__(self): open({str(begun)!r}, 'w').close(); time.sleep(60)\n"
        "    slow = Slow(); del slow"
    )
    with Run(tmp_path, building=building) as run:
        run.wait_until(begun.exists)
        assert run.interrupt() == "stark: interrupted\n"


def test_what_waits_is_raised_afterwards() -> None:
    done = []
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            with _interrupts.Deferred():
                signal.raise_signal(signal.SIGINT)
                done.append("whole")
            done.append("beyond")
    finally:
        signal.signal(signal.SIGINT, before)
    assert done == ["whole"]


def test_a_program_that_imports_stark_keeps_its_handlers() -> None:
    code = (
        "import signal; mine = lambda *_: None; signal.signal(signal.SIGINT, mine)\n"
        "import stark, stark.cli; stark.cli.main(['--version'])\n"
        "print(signal.getsignal(signal.SIGINT) is mine)"
    )
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env, check=True)
    assert done.stdout.split()[-1] == "True"


def test_an_ignored_ctrl_c_stays_ignored(tmp_path: Path) -> None:
    """As under nohup, and in the background of a script."""
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from stark._interrupts import RaisedOnce\n"
        "with RaisedOnce(signal.SIGINT): signal.raise_signal(signal.SIGINT)\n"
        "print('went on')"
    )
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env, check=True)
    assert done.stdout == "went on\n"
