"""Functions of time are asked for targets while a step begins: what they do to the simulation meanwhile is
refused, and leaves it as it was."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark.recording import Recorder

Act = Callable[[stark.Simulation], object]


def place(sim: stark.Simulation) -> None:
    sim["ball"].position = (0, 0, 1)


ACTS: dict[str, tuple[str, Act]] = {
    "step": (r"sim\.step\(\)", lambda sim: sim.step()),
    "run": (r"sim\.run\(\)", lambda sim: list(sim.run(1.0))),
    "run_until": (r"sim\.run\(\)", lambda sim: sim.run_until(1.0)),
    "reset": (r"sim\.reset\(\)", lambda sim: sim.reset()),
    "rewind": (r"sim\.state", lambda sim: setattr(sim, "state", sim.state)),
    "save": (r"sim\.save\(\)", lambda sim: sim.save("never.stark")),
    "load": (r"sim\.load\(\)", lambda sim: sim.load("start.stark")),
    "place": (r"sim\.bodies: position", place),
    "placing": (r"sim\.bodies: placing", lambda sim: sim.placing().__enter__()),
}


class Acting:
    """A motion that does something to its simulation once it is told to."""

    def __init__(self) -> None:
        self.sim: stark.Simulation | None = None
        self.act: Act | None = None

    def __call__(self, time: float) -> Any:
        if self.act is not None and self.sim is not None:
            self.act(self.sim)
        return (0.1 * time, 0, 0)


def scenes(kind: str) -> tuple[stark.Simulation, Acting]:
    """A ball that falls beside something which follows a motion: a box, pins, or the target of a motor."""
    scene, acting = stark.Scene(), Acting()
    scene.add_sphere(0.05, subdivisions=1, mass=1.0, name="ball", position=(0, 0, 0.5))
    if kind == "box":
        scene.add_box(0.1, name="mover", motion="scripted", position=(1, 0, 0)).follow(
            position=lambda t: np.add(acting(t), (1, 0, 0))
        )
    elif kind == "pins":
        cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 2), name="mover", position=(1, 0, 0))
        cloth.pin([0, 1])
        cloth.follow(displacement=acting)
    else:
        door = scene.add_box(0.1, mass=1.0, name="door", position=(1, 0, 0))
        hinge = scene.add_hinge(door, None, anchor=(1, 0, 0), axis=(0, 0, 1))
        hinge.add_motor(lambda t: acting(t)[0], cap=1.0, delta=0.1, name="mover")
    acting.sim = stark.Simulation(scene, time_step=0.01)
    return acting.sim, acting


@pytest.mark.parametrize("kind", ["box", "pins", "motor"])
@pytest.mark.parametrize("act", ACTS)
def test_what_a_function_of_time_does_to_its_simulation_is_refused(
    kind: str, act: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A step that was taken within another one was accepted, and time went on by two of them."""
    monkeypatch.chdir(tmp_path)
    (sim, acting), (alone, _) = scenes(kind), scenes(kind)
    sim.step(), alone.step()
    sim.save("start.stark")
    named, acting.act = ACTS[act]
    with pytest.raises(stark.InvalidArgument, match=rf"'mover'.* uses {named}.*only return the value"):
        sim.step()
    assert sim.time == alone.time and not Path("never.stark").exists()
    acting.act = None
    for _ in range(3):
        sim.step(), alone.step()
    assert sim.state == alone.state


def test_another_simulation_may_be_stepped() -> None:
    """A model that predicts, within the motion of another scene."""
    sim, acting = scenes("box")
    other, _ = scenes("pins")
    acting.act = lambda _: other.step()
    sim.step(), sim.step()
    assert other.time == pytest.approx(0.02)


def test_a_function_may_give_other_values_their_functions() -> None:
    """The list of values over time changed while it was gone through: RuntimeError."""
    scene = stark.Scene()
    motors = []

    def aim(time: float) -> float:
        motors[1].target = lambda t: 0.2 * t
        return 0.1 * time

    for k in range(2):
        door = scene.add_box(0.1, mass=1.0, position=(k, 0, 0))
        hinge = scene.add_hinge(door, None, anchor=(k, 0, 0), axis=(0, 0, 1))
        motors.append(hinge.add_motor(0.0, cap=1.0, delta=0.1))
    motors[0].target = lambda t: 0.1 * t if t == 0.0 else aim(t)
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in range(2):
        sim.step()
    assert sim.actuators[1].target == pytest.approx(0.2 * sim.time)


def test_a_recording_that_a_callback_closes_is_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What comes after it is refused, in the words of the recorder; what was recorded stays."""
    monkeypatch.setattr(stark.simulation, "PROGRESS_PERIOD", 0.0)
    sim, _ = scenes("box")
    recorder = Recorder(tmp_path / "run", sim, certify=True)
    recorder.record(sim)
    recorder.record_state(sim)
    sim.step(progress=lambda p: recorder.close())
    with pytest.raises(stark.Error, match="closed"):
        recorder.record_state(sim)
    assert stark.verify.verify(tmp_path / "run").verdict in ("certified", "inconclusive")


@pytest.mark.parametrize("act", [a for a in ACTS if a not in ("load", "placing")])
def test_a_progress_callback_is_refused_the_same(act: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stark.simulation, "PROGRESS_PERIOD", 0.0)
    (sim, _), (alone, _) = scenes("box"), scenes("box")
    with pytest.raises(stark.Error, match=r"inside step\(\)"):
        sim.step(progress=lambda p: ACTS[act][1](sim))
    sim.step(), alone.step()
    assert sim.state == alone.state


def live_arrays() -> tuple[stark.Simulation, dict[str, Any]]:
    """An energy and a body with an array each that follows a function of time."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 2), pins=[0], name="sheet")
    cloth.growth = lambda t: 1.0 + 0.01 * t
    push = scene.add_force(cloth.vertices[8], (0.0, 0.0, 0.0))
    push.force = lambda t: (t, 0.0, 0.0)
    return stark.Simulation(scene, time_step=0.01), {"force": push, "growth": cloth}


@pytest.mark.parametrize("name", ["force", "growth"])
def test_a_change_in_place_of_what_follows_a_function_is_refused(name: str) -> None:
    """The next value of the function would replace it without a word; before the first step, too."""
    sim, handles = live_arrays()
    handle = handles[name]
    for _ in range(2):
        array = getattr(handle, name)
        array[1] = 1.5
        with pytest.raises(stark.InvalidArgument, match=rf"{name}\[1\] = 1.5 was changed in place") as told:
            sim.step()
        assert f"handle.{name} = array" in str(told.value)
        kept = array.copy()
        setattr(handle, name, array)  # the remedy: it ends the function
        assert not sim.step().failed and np.array_equal(array, kept)
        setattr(handle, name, lambda t, start=kept: start * (1.0 - t))
        assert not sim.step().failed and np.allclose(array, kept * (1.0 - sim.time), rtol=1e-12)


def test_a_function_given_in_a_run_acts_from_the_next_step_on() -> None:
    """Until then the value reads as it is, not as the function was at time 0."""

    @stark.energy
    def push(p: stark.Point, force: stark.Vec3):
        return -(force @ p.x)

    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2))
    load = scene.add(push(cloth.vertices[4], force=(1e-3, 0.0, 0.0)))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.05)
    load.force[0] = 2e-3
    load.force = lambda t: (0.1 * t, 0.0, 0.0)
    np.testing.assert_array_equal(load.force, (2e-3, 0.0, 0.0))
    sim.step()
    np.testing.assert_allclose(load.force, (6e-3, 0.0, 0.0), rtol=1e-12)


def test_what_is_loaded_is_no_change_in_place(tmp_path: Path) -> None:
    sim, handles = live_arrays()
    for name, handle in handles.items():
        getattr(handle, name)  # handed out
    sim.run_until(0.02)
    sim.save(tmp_path / "early.stark")
    sim.run_until(0.05)
    sim.load(tmp_path / "early.stark")
    sim.run_until(0.03)
    assert handles["force"].force[0] == pytest.approx(0.03, rel=1e-12)
    assert handles["growth"].growth[0] == pytest.approx(1.0003, rel=1e-12)
