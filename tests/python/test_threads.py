"""One thread at a time: what other threads ask of a simulation inside step() is refused, whatever it is."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

import stark
from stark import _core, simulation

#: Functions of the core that take a simulation, besides its methods.
_OF_SIMULATIONS = [
    name
    for name, function in vars(_core).items()
    if callable(function) and not inspect.isclass(function) and "Simulation" in (function.__doc__ or "")
]

#: Members of the core's class that are its methods and properties.
_MEMBERS = [name for name in vars(_core.Simulation) if not name.startswith("__")]


def a_scene() -> stark.Scene:
    scene = stark.Scene("shop")
    scene.add_floor(1.0)
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 10), position=(0, 0, 0.15), name="sheet", pins=[0])
    scene.add_box(0.05, motion="scripted", position=(0, 0, 0.06), name="block")
    return scene


@contextmanager
def held_in_a_step(sim: stark.Simulation, monkeypatch: pytest.MonkeyPatch) -> Iterator[threading.Thread]:
    """While another thread is inside step(): its progress callback waits for the end of the block."""
    monkeypatch.setattr(simulation, "PROGRESS_PERIOD", 0.0)
    inside, leave, raised = threading.Event(), threading.Event(), []

    def wait(progress: object) -> None:
        inside.set()
        leave.wait(60)

    def work() -> None:
        try:
            sim.step(progress=wait)
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=work, name="worker")
    thread.start()
    try:
        assert inside.wait(60)
        yield thread
    finally:
        leave.set()
        thread.join(60)
    assert not thread.is_alive() and not raised


def test_two_threads_that_step_one_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    sim, alone = stark.Simulation(a_scene()), stark.Simulation(a_scene())
    with (
        held_in_a_step(sim, monkeypatch),
        pytest.raises(stark.Error, match=r"inside step\(\).*'worker'.*lock"),
    ):
        sim.step()
    alone.step()
    assert sim.state == alone.state
    assert not sim.step().failed


@pytest.mark.parametrize("name", _MEMBERS)
def test_no_member_is_open_during_a_step(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    sim = stark.Simulation(a_scene())
    with held_in_a_step(sim, monkeypatch):
        member = vars(_core.Simulation)[name]
        if not callable(member):
            with pytest.raises(stark.Error, match="'worker'"):
                getattr(sim._core, name)
        else:
            _call_until_refused(lambda *given: member(sim._core, *given))


@pytest.mark.parametrize("name", _OF_SIMULATIONS)
def test_no_function_is_open_during_a_step(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    sim = stark.Simulation(a_scene())
    with held_in_a_step(sim, monkeypatch):
        _call_until_refused(lambda *given: getattr(_core, name)(sim._core, *given))


def _call_until_refused(call: Callable[..., Any]) -> None:
    """With arguments of all kinds that the functions of the core take, until they fit."""
    kinds: list[Any] = [0, "x", np.zeros((1, 3)), True, a_state(), [0]]
    tried: list[tuple[Any, ...]] = [()]
    for _ in range(5):
        for given in tried:
            try:
                call(*given)
            except TypeError:
                continue  # nanobind found no overload for them
            except stark.Error as error:
                assert "inside step()" in str(error)
                return
            raise AssertionError(f"ran with {given}")
        tried = [(*given, kind) for given in tried for kind in kinds]
    raise AssertionError("no arguments fit")


def a_state() -> _core.State:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    return stark.Simulation(scene).state


def test_handles_are_refused_and_arrays_keep_their_values(monkeypatch: pytest.MonkeyPatch) -> None:
    sim = stark.Simulation(a_scene())
    sheet, block = sim["sheet"], sim["block"]
    before = sheet.positions
    kept = before.copy()
    with held_in_a_step(sim, monkeypatch):
        uses: list[Callable[[], object]] = [
            lambda: sim.time,
            lambda: sim.state,
            lambda: sim.state.hash,
            lambda: sim.contacts,
            lambda: sheet.positions,
            lambda: sheet.velocities,
            lambda: block.position,
            lambda: setattr(block, "position", (0, 0, 0.1)),
            lambda: sim.save(os.devnull),
            lambda: next(sim.run(until=1.0)),
        ]
        for use in uses:
            with pytest.raises(stark.Error, match="'worker'"):
                use()
    assert np.array_equal(before, kept)
    assert not np.array_equal(sheet.positions, kept)


def test_the_callback_of_a_step_leaves_the_simulation_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation, "PROGRESS_PERIOD", 0.0)
    sim = stark.Simulation(a_scene())
    before = sim.state
    with pytest.raises(stark.Error, match=r"which has called this function"):
        sim.step(progress=lambda progress: sim.step())
    assert sim.state == before and not sim.step().failed


def test_the_last_reference_may_go_during_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation, "PROGRESS_PERIOD", 0.0)
    sims = [stark.Simulation(a_scene())]
    report = sims[0].step(progress=lambda progress: sims.clear())
    assert not sims and not report.failed


def test_simulations_of_their_own_run_side_by_side() -> None:
    def hashes(out: list[str]) -> None:
        sim = stark.Simulation(a_scene())
        for _ in range(6):
            sim.step()
            out.append(sim.state.hash)

    found: list[list[str]] = [[] for _ in range(3)]
    threads = [threading.Thread(target=hashes, args=(out,)) for out in found]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    assert found[0] == found[1] == found[2] and len(found[0]) == 6


_RACE = """
import threading, stark
scene = stark.Scene(); scene.add_floor(1.0)
scene.add_cloth(stark.mesh.grid(0.3, 0.3, 10), position=(0, 0, 0.15))
scene.add_sphere(0.05, motion="fixed", position=(0, 0, 0.06))
sim = stark.Simulation(scene)
refused, other = 0, []
def work():
    global refused
    for _ in range(40):
        try:
            sim.step()
        except stark.Error as error:
            refused += 1
            other.extend([] if "inside step()" in str(error) else [error])
threads = [threading.Thread(target=work) for _ in range(4)]
for t in threads: t.start()
for t in threads: t.join()
print(refused > 0, other, sim.step().status)
"""


def test_a_race_ends_in_exceptions() -> None:
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", _RACE], capture_output=True, text=True, timeout=120, env=env, check=False
    )
    assert (done.returncode, done.stdout.split(maxsplit=1)[:1]) == (0, ["True"]), done.stderr
    assert done.stdout.split()[1:] == ["[]", "accepted"]
