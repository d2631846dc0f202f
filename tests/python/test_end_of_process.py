"""How a process ends that has used Stark: at once, and without a word about references or threads."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

_SESSION = """
import stark, stark.symbolic, stark.telemetry
@stark.energy
def magnet(p: stark.Point, center: stark.Vec3, strength: float = stark.parameter(1e-3, unit="J m", min=0.0)):
    return -strength / stark.norm(p.x - center)
@stark.material
def rubber(F: stark.DeformationGradient, mu: float = 1e4):
    J = stark.determinant(F)
    return 0.5 * mu * (stark.squared_norm(F) - 3) - mu * stark.log(J) + 5 * mu * stark.log(J) ** 2
@stark.symbolic.function
def square(x: float):
    return x * x
scene = stark.Scene()
scene.add_floor(1.0)
cloth = scene.add_cloth(stark.mesh.grid(0.4, 0.4, cells=4), stark.materials.cotton, position=(0, 0, 0.3))
scene.add_solid(stark.mesh.tet_box(0.1, 2), rubber(density=1000.0), position=(0, 0, 0.06))
box = scene.add_box(0.05, mass=0.1, position=(0.5, 0, 0.06))
hinge = scene.add_hinge(box, None, anchor=(0.5, 0, 0.06), axis=(0, 0, 1))
pull = scene.add(magnet(cloth.vertices, center=(0, 0, 0.6)))
sim = stark.Simulation(scene, time_step=1 / 60)
for step in sim.run(until=0.05):
    pull.center = (0.1, 0, 0.6)
state, report, contacts, energies = sim.state, step, sim.contacts, pull.energies
value = square(2.0)
running = sim.run(until=1.0)
next(running)
"""

_ENDS = {
    "plain": "",
    "an exception that is kept": "try: sim.settings['x']\nexcept Exception as error: kept = error",
    "a cycle": "class Owner: pass\nowner = Owner(); owner.sim, owner.of = sim, lambda: owner.sim",
    "sys.exit in a function": "import sys\ndef leave(sim): sys.exit(0)\nleave(sim)",
    "a function kept by atexit": "import atexit; atexit.register(lambda: sim.time)",
    "a registered class attribute": "stark.kept = [sim, scene, running]",
}


Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    def in_a_process(code: str, leaks: str = "1") -> subprocess.CompletedProcess[str]:
        script = tmp_path / "session.py"
        script.write_text(code)
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "STARK_LEAK_WARNINGS": leaks}
        env = {name: value for name, value in env.items() if value}
        return subprocess.run(
            [sys.executable, str(script)], capture_output=True, text=True, env=env, timeout=120, check=False
        )

    return in_a_process


@pytest.mark.parametrize("end", list(_ENDS))
def test_a_session_ends_without_a_word(end: str, run: Run) -> None:
    done = run(_SESSION + _ENDS[end])
    assert (done.returncode, done.stderr) == (0, "")


def test_leaks_are_reported_to_those_who_look_for_them(run: Run) -> None:
    forever = "import ctypes; ctypes.pythonapi.Py_IncRef(ctypes.py_object(sim))"
    assert "leaked" in run(_SESSION + forever).stderr
    assert run(_SESSION + forever, leaks="").stderr == ""


def test_an_uncaught_exception_is_all_that_is_said(run: Run) -> None:
    done = run(_SESSION + "def fail(sim): raise RuntimeError('the end')\nfail(sim)")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "RuntimeError: the end" and "nanobind" not in done.stderr


_BUSY = """
import threading, time, stark, stark.render, numpy as np
scene = stark.Scene(); scene.add_floor(1.0)
scene.add_cloth(stark.mesh.grid(0.3, 0.3, 30), position=(0, 0, 0.15))
scene.add_sphere(0.05, motion="fixed", position=(0, 0, 0.06))
stepping = threading.Semaphore(0)
def work():
    sim = stark.Simulation(scene, threads=2)
    sim.step()
    stepping.release()
    while True: sim.step()
"""


@pytest.mark.parametrize("seconds", [0.0, 0.05, 0.3])
def test_daemon_threads_in_the_middle_of_a_step(seconds: float, run: Run) -> None:
    # All of them step: a thread that the end freezes in Python code, as in its imports, keeps what it holds.
    code = (
        "for _ in range(3): threading.Thread(target=work, daemon=True).start()\n"
        f"for _ in range(3): stepping.acquire()\ntime.sleep({seconds})\n"
    )
    done = run(_BUSY + code)
    assert (done.returncode, done.stderr) == (0, "")


def test_threads_that_are_waited_for_step_to_their_end(run: Run) -> None:
    done = run(
        _BUSY + "def some():\n"
        "    sim = stark.Simulation(scene)\n"
        "    for _ in range(3): sim.step()\n"
        "    print(sim.state.step_count)\n"
        "threading.Thread(target=some).start()\n"
    )
    assert (done.returncode, done.stdout.split(), done.stderr) == (0, ["3"], "")
