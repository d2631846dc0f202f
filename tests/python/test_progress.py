"""A step says how far it has come; what its callback raises ends it and leaves everything as it was."""

from __future__ import annotations

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

import stark
from stark import simulation
from stark.cli.progress import Progress
from stark.cli.run import LONG_STEP, Shown


class StopError(Exception):
    pass


def falling() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 10), position=(0, 0, 0.115))
    scene.add_sphere(0.05, motion="fixed", position=(0, 0, 0.06))
    return stark.Simulation(scene, time_step=1 / 60)


@pytest.fixture
def all_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation, "PROGRESS_PERIOD", 0.0)


def test_it_is_told_of_every_iteration(all_calls: None) -> None:
    sim, seen = falling(), []
    for _ in range(5):
        seen.clear()
        report = sim.step(progress=seen.append)
    assert {p.step for p in seen} == {report.step} and {p.attempt for p in seen} == {1}
    assert {p.time for p in seen} == {sim.time - report.time_step}
    iterations, seconds = [p.iterations for p in seen], [p.seconds for p in seen]
    assert (
        iterations[0] == 0 and iterations == sorted(iterations) and iterations[-1] <= report.newton_iterations
    )
    assert len(set(iterations)) > 2
    assert seconds[0] > 0 and seconds == sorted(seconds)
    assert seen[-1].acceleration > 0 and seen[-1].residual > 0 and seen[-1].last_motion > 0


def test_it_changes_no_bit(all_calls: None) -> None:
    told, alone = falling(), falling()
    told.run_until(0.1, progress=lambda p: None)
    for _ in alone.run(0.1):
        pass
    assert told.state == alone.state


@pytest.mark.parametrize("after", [1, 3])
def test_an_exception_ends_the_step(after: int, all_calls: None) -> None:
    sim, alone = falling(), falling()
    for _ in range(4):
        sim.step(), alone.step()
    before, calls = sim.state, []

    def stop(progress: object) -> None:
        calls.append(progress)
        if len(calls) == after:
            raise StopError("enough")

    with pytest.raises(StopError, match="enough"):
        sim.step(progress=stop)
    assert len(calls) == after and sim.state == before
    sim.step(), alone.step()
    assert sim.state == alone.state


def test_it_is_called_some_times_a_second() -> None:
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box(0.2, 14), position=(0, 0, 0.1005))
    scene.add_floor()
    seen = []
    begin = time.monotonic()
    sim = stark.Simulation(scene, time_step=1 / 60)
    sim.step(progress=seen.append)
    assert len(seen) <= 1 + (time.monotonic() - begin) / simulation.PROGRESS_PERIOD
    assert all(p.seconds >= simulation.PROGRESS_PERIOD for p in seen)


def test_what_is_no_function_is_refused() -> None:
    sim = falling()
    for call in (sim.step, lambda **o: sim.run(0.1, **o), lambda **o: sim.run_until(0.1, **o)):
        with pytest.raises(stark.InvalidArgument, match=r"progress = 3: must be a function"):
            call(progress=3)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def told(seconds: float, attempt: int = 1) -> SimpleNamespace:
    return SimpleNamespace(step=7, time=0.5, seconds=seconds, iterations=35, attempt=attempt)


def test_the_bar_shows_the_iterations_of_a_long_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Progress, "PERIOD", 0.0)
    terminal, pipe = Terminal(), io.StringIO()
    shown = Shown(Progress(1.0, stream=terminal))
    shown.progress(told(0.9 * LONG_STEP))
    assert terminal.getvalue() == ""
    shown.progress(told(12.4))
    assert (
        "t = 0.500 s  step 7: 35 iterations in 12 s" in terminal.getvalue() and "50 %" in terminal.getvalue()
    )
    shown.progress(told(12.4, attempt=2))
    assert terminal.getvalue().endswith("attempt 2")
    Shown(Progress(1.0, stream=pipe)).progress(told(12.4))
    assert pipe.getvalue() == ""


@pytest.mark.parametrize(("columns", "least_bar"), [(200, 28), (80, 10), (40, 0), (0, 10)])
def test_the_bar_fits_into_one_row(monkeypatch: pytest.MonkeyPatch, columns: int, least_bar: int) -> None:
    """A longer line would leave a row on the screen with every drawing. 0 columns: the terminal does not
    say, and 80 are taken."""
    monkeypatch.setattr(Progress, "PERIOD", 0.0)
    main_end, other_end = pty.openpty()
    fcntl.ioctl(other_end, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    with open(other_end, "w", encoding="utf-8") as stream:
        progress = Progress(20.0, stream=stream)
        for time_reached in (0.5, 10.0, 20.0):
            progress.update(time_reached, f"t = {time_reached:.3f} s  124 iterations  12345 contacts")
            line = os.read(main_end, 4096).decode().removeprefix("\r\033[K")
            assert len(line) < (columns or 80) and "%" in line
            assert sum(line.count(c) for c in "━─") >= least_bar
            assert columns == 40 or line.endswith("contacts")
    os.close(main_end)


_SLOW = """
import stark
until = 0.02
def build():
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box(0.2, 14), position=(0, 0, 0.1005))
    scene.add_floor()
    return scene, {"time_step": 0.02}
"""


def test_stark_run_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a terminal, with every iteration of the first step as a long one."""
    (tmp_path / "slow.py").write_text(_SLOW)
    code = (
        "import sys, stark.simulation, stark.cli.run, stark.cli.progress\n"
        "stark.simulation.PROGRESS_PERIOD = stark.cli.run.LONG_STEP = 0.0\n"
        "stark.cli.progress.Progress.PERIOD = 0.0\n"
        "sys.exit(stark.cli.main(['run', 'slow.py', '--no-replay', '--no-picture']))"
    )
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    main_end, other_end = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.DEVNULL, stderr=other_end, env=env, cwd=tmp_path
    )
    os.close(other_end)
    shown = b""
    try:
        while part := os.read(main_end, 4096):
            shown += part
    except OSError:  # Linux: the other end is closed
        pass
    os.close(main_end)
    assert process.wait(timeout=60) == 0
    assert re.search(r"step 1: [1-9]\d* iterations in \d+ s", shown.decode())
