"""``stark run --view``: what it says, Ctrl-C, what it refuses; and that nobody pays who does not ask."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest

ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_it_in_one_line(number: signal.Signals, tmp_path: Path) -> None:
    pytest.importorskip("viser", reason="needs the extra 'view'")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "stark", "run", "stack", "--view", "--port", str(port)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, cwd=tmp_path
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert f"http://127.0.0.1:{port}" in line
        urllib.request.urlopen(f"http://127.0.0.1:{port}", timeout=10.0).close()
        time.sleep(0.3)
        before = time.monotonic()
        process.send_signal(number)
        out, err = process.communicate(timeout=20.0)
        # A second is the aim on a free machine; the rest is for a busy one.
        assert time.monotonic() - before < 5.0
    finally:
        process.kill()
    assert (out, err) == ("", "stark: interrupted\n")
    assert process.returncode == 130
    assert list(tmp_path.iterdir()) == [], "nothing is written that nobody asked for"


def test_what_belongs_to_recorded_runs_is_refused() -> None:
    for words, told in (
        (["--view", "--certify"], "--certify is of a run that is recorded"),
        (["--port", "80"], "--host and --port are of the page: give --view, too"),
    ):
        command = [sys.executable, "-m", "stark", "run", "stack", *words]
        done = subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, check=False)
        assert done.returncode == 2 and told in done.stderr


def test_nobody_pays_who_does_not_ask() -> None:
    program = (
        "import sys, threading, stark\n"
        "scene = stark.Scene(); scene.add_sphere(0.1, mass=1.0)\n"
        "sim = stark.Simulation(scene); sim.step()\n"
        "print([m for m in sys.modules if m.split('.')[0] == 'viser' or m.startswith('stark.view')],"
        " threading.active_count())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env=ENVIRONMENT, check=True
    )
    assert done.stdout.strip() == "[] 1"
