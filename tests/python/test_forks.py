"""Forked processes: a child goes on with the simulations of its parent, bit for bit, or says why not."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")

_START = """
import multiprocessing, os, signal, sys, threading, time, warnings
import stark
warnings.simplefilter("ignore", DeprecationWarning)  # of forks with threads
def a_scene():
    scene = stark.Scene(); scene.add_floor(1.0)
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 10), position=(0, 0, 0.15))
    scene.add_sphere(0.05, motion="fixed", position=(0, 0, 0.06))
    return scene
def simulate():
    return stark.Simulation(a_scene(), threads=4, **{"execution.oversubscribe": True})
def hashes(sim, count):
    found = []
    for _ in range(count):
        assert not sim.step().failed
        found.append(sim.state.hash)
    return found
def in_a_child(act):
    child = os.fork()
    if child == 0:
        signal.alarm(60)  # rather than to hang
        try:
            os._exit(0 if act() else 1)
        except BaseException as error:
            print(type(error).__name__, error, file=sys.stderr)
            os._exit(2)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
"""


def run(code: str) -> subprocess.CompletedProcess[str]:
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.run(
        [sys.executable, "-c", _START + code],
        capture_output=True,
        text=True,
        env=env,
        timeout=120,
        check=False,
    )


def test_a_child_and_its_parent_take_the_same_steps() -> None:
    done = run(
        "sim = simulate(); sim.step(); before = sim.state; expected = hashes(sim, 4); sim.state = before\n"
        "print(in_a_child(lambda: hashes(sim, 4) == expected), hashes(sim, 4) == expected)\n"
        "print(in_a_child(lambda: in_a_child(lambda: sim.step().status == 'accepted') == 0))\n"
    )
    assert done.stdout.split() == ["0", "True", "0"], done.stderr


def test_children_of_multiprocessing() -> None:
    done = run(
        "sim = simulate(); expected = hashes(simulate(), 3); sim.step()\n"
        "def work(_):\n"
        "    signal.alarm(60)\n"
        "    sim.step()\n"
        "    return hashes(simulate(), 3)\n"
        "with multiprocessing.get_context('fork').Pool(2) as pool:\n"
        "    print(pool.map_async(work, range(4)).get(90) == 4 * [expected])\n"
    )
    assert done.stdout.split() == ["True"], done.stderr


def test_a_child_may_drop_what_it_was_given() -> None:
    done = run(
        "sim = simulate(); sim.step()\n"
        "def drop():\n"
        "    global sim\n"
        "    sim = None\n"
        "    return len(hashes(simulate(), 2)) == 2\n"
        "print(in_a_child(drop))\n"
    )
    assert done.stdout.split() == ["0"], done.stderr


def test_a_fork_in_the_middle_of_a_step() -> None:
    """The thread that steps is not in the child, so that the step will never end there."""
    done = run(
        "import stark.simulation; stark.simulation.PROGRESS_PERIOD = 0.0\n"
        "sim, inside, leave = simulate(), threading.Event(), threading.Event()\n"
        "def wait(progress):\n"
        "    inside.set(); leave.wait(60)\n"
        "thread = threading.Thread(target=lambda: sim.step(progress=wait)); thread.start(); inside.wait(60)\n"
        "def refused():\n"
        "    try: sim.step()\n"
        "    except stark.Error as error: return 'forked' in str(error) and not simulate().step().failed\n"
        "print(in_a_child(refused)); leave.set(); thread.join(60); print(sim.step().status)\n"
    )
    assert done.stdout.split() == ["0", "accepted"], done.stderr


def test_a_child_that_ends_as_programs_do() -> None:
    done = run(
        "sim = simulate(); sim.step()\n"
        "if os.fork() == 0:\n"
        "    signal.alarm(60); sim.step(); sys.exit(7)\n"
        "print(os.waitstatus_to_exitcode(os.wait()[1]))\n"
    )
    assert (done.stdout.split(), done.stderr) == (["7"], "")
