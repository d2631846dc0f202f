"""How the library behaves as a guest in its host process: it gives way to other threads, runs on one core,
reads no handle of a dead object, starts no program, keeps no history, and reports instead of ending the
process. Physical behaviours stand in physics/test_physical_behaviours.py."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
import time
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import _core
from stark.telemetry import Telemetry

_ROOT = Path(__file__).resolve().parents[2]


def box_scene() -> tuple[stark.Scene, Any]:
    scene = stark.Scene()
    return scene, scene.add_box(0.1, mass=1.0, name="box")


def run_python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A program in a process of its own, with this package."""
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **environment}
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=env, timeout=120, check=False
    )


@pytest.mark.alone
def test_other_threads_run_during_a_step() -> None:
    """The interpreter is free while a step is computed: a clock of 2 ms goes on ticking through one step of
    a few tenths of a second."""
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box(0.2, 16), position=(0, 0, 0.1005))
    scene.add_floor()
    sim = stark.Simulation(scene, time_step=1 / 60)
    ticks, done = [0], threading.Event()

    def tick() -> None:
        while not done.wait(0.002):
            ticks[0] += 1

    clock = threading.Thread(target=tick)
    clock.start()
    start, before = time.perf_counter(), ticks[0]
    sim.step()
    seconds, during = time.perf_counter() - start, ticks[0] - before
    done.set()
    clock.join()
    # On a loaded machine a tick may take ten times as long as it should, but not as long as the step.
    assert during > 0.1 * seconds / 0.002, (during, seconds)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="needs processor affinity")
@pytest.mark.parametrize("threads", [0, 1, 4])
def test_one_core_is_enough(threads: int) -> None:
    done = run_python(
        "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n"
        "import stark\n"
        "scene = stark.Scene(); scene.add_cloth(stark.mesh.grid(0.1, 0.1, 4))\n"
        f"sim = stark.Simulation(scene, threads={threads})\n"
        "assert not sim.step().failed",
        OMP_NUM_THREADS="1",
    )
    assert done.returncode == 0, done.stderr


def test_four_processes_start_at_once_in_an_empty_home(tmp_path: Path) -> None:
    """There is no kernel cache to be raced for or to be damaged."""
    code = (
        "import stark\n"
        "scene = stark.Scene(); scene.add_cloth(stark.mesh.grid(0.1, 0.1, 4))\n"
        "scene.add_box(0.02, mass=0.1, position=(0, 0, 0.02))\n"
        "sim = stark.Simulation(scene)\n"
        "for _ in range(3): assert not sim.step().failed\n"
        "print(sim.state.hash)"
    )
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "HOME": str(tmp_path)}
    env |= {"TMPDIR": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", code], env=env, cwd=tmp_path, text=True, stdout=subprocess.PIPE
        )
        for _ in range(4)
    ]
    results = [process.communicate(timeout=120)[0] for process in processes]
    assert [process.returncode for process in processes] == [0] * 4
    assert len(set(results)) == 1
    assert list(tmp_path.iterdir()) == []


def test_no_program_is_started() -> None:
    """Not even where a name looks like a command of a shell."""
    done = run_python(
        "import sys\n"
        "def refuse(event, arguments):\n"
        "    assert event not in ('subprocess.Popen', 'os.system', 'os.exec', 'os.posix_spawn'), arguments\n"
        "sys.addaudithook(refuse)\n"
        "import stark\n"
        "scene = stark.Scene('$(false)')\n"
        "scene.add_cloth(stark.mesh.grid(0.1, 0.1, 4), name='; exit 1')\n"
        "assert not stark.Simulation(scene).step().failed",
        PATH="",
    )
    assert done.returncode == 0, done.stderr


def test_a_scene_without_unknowns_steps_or_is_refused_but_does_not_end_the_process() -> None:
    scene = stark.Scene()
    scene.add_floor()
    sim = stark.Simulation(scene, time_step=0.01)
    report = sim.step()
    assert not report.failed
    assert sim.time == pytest.approx(0.01)


def test_an_unknown_series_is_named() -> None:
    with pytest.raises(KeyError, match="no series 'iteration'; there are"):
        Telemetry([{"step": 1, "time": 0.1}])["iteration"]


def test_a_released_joint_is_left_alone() -> None:
    """The step of a released joint costs what that of no joint costs, however far apart its sides are."""
    scene, box = box_scene()
    joint = scene.add_ball(None, box, anchor=(0, 0, 0))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.step()
    joint.enabled = False
    reports = [report for report in sim.run(0.5)]
    free, _ = box_scene()
    expected = stark.Simulation(free, time_step=0.01).step()
    assert np.linalg.norm(box.position) > 1.0  # six orders above the tolerance of joints
    for report in reports:
        assert report.newton_iterations <= expected.newton_iterations
        assert report.rejected_steps == 0 and not report.failed


@pytest.mark.parametrize("kind", _core.joint_names())
def test_every_property_of_a_joint_can_be_read(kind: str) -> None:
    scene, box = box_scene()
    other = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.3))
    if kind in ("distance", "span"):
        joint = getattr(scene, f"add_{kind}")(other, box, (0, 0, 0.25), (0, 0, 0.05))
    else:
        joint = scene.add_joint(kind, other, box, anchor=(0, 0, 0.15))
    _read_everything(joint, stark.Simulation(scene))


def _read_everything(handle: Any, sim: stark.Simulation) -> None:
    assert not sim.step().failed
    for name in dir(handle):
        if not name.startswith("_"):
            getattr(handle, name)


def test_every_property_of_every_body_can_be_read() -> None:
    scene, _ = box_scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), position=(1, 0, 0))
    scene.add_solid(stark.mesh.tet_box(0.1, 1), position=(2, 0, 0))
    scene.add_rod(stark.mesh.polyline((3, 0, 0), (3, 0, 1), 3))
    sim = stark.Simulation(scene)
    for body in sim.bodies:
        _read_everything(body, sim)


def resident_memory() -> int:
    """Of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
def test_steps_leave_nothing_behind() -> None:
    """Reports are values of the caller; the simulation keeps none of them, nor grows with the steps: 3000
    of them, kept, would be twice the limit."""
    scene, _ = box_scene()
    sim = stark.Simulation(scene, time_step=1e-4)
    for _ in range(500):
        sim.step()
    gc.collect()
    before = resident_memory()
    for _ in range(3000):
        sim.step()
    gc.collect()
    assert resident_memory() - before < 512 * 1024


def test_simulations_are_freed() -> None:
    scene, _ = box_scene()
    sim = stark.Simulation(scene)
    sim.step()
    gone = weakref.ref(sim)
    del sim
    gc.collect()
    assert gone() is None
