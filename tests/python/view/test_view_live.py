"""Controls of live values: what they set, and when."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from _views import free_port

import stark
from stark.view.live import add_live_controls

pytest.importorskip("viser", reason="needs the extra 'view'")
ROBOT = Path(__file__).resolve().parents[3] / "examples" / "robot_arm.urdf"


class Gui:
    """Keeps the controls by name."""

    def __init__(self) -> None:
        self.controls: dict[str, Any] = {}

    def add_folder(self, label: str, **options: Any) -> Any:
        import contextlib

        return contextlib.nullcontext()

    def _add(self, label: str, **options: Any) -> Any:
        class Control:
            value = options["initial_value"]
            bounds = options.get("min"), options.get("max")

            def on_update(self, call: Any) -> None:
                self.call = call

            def set(self, value: Any) -> None:
                self.value = value
                self.call(None)

        self.controls[label] = Control()
        return self.controls[label]

    add_slider = add_number = add_vector3 = add_checkbox = _add


def test_values_of_actuators_and_energies_are_assigned_between_steps() -> None:
    scene = stark.Scene()
    ball = scene.add_sphere(0.05, name="ball", mass=0.6)
    wheel = scene.add_box(0.1, name="wheel", mass=1.0, position=(1.0, 0, 0))
    hinge = scene.add_hinge(None, wheel, anchor=(1.0, 0, 0), axis=(0, 0, 1), name="axle")
    motor = hinge.add_motor(1.0, cap=2.0, delta=0.1, name="motor")
    wind = scene.add_force(ball, (1.0, 0.0, 0.0), name="wind")
    sim = stark.Simulation(scene, time_step=0.01)
    gui, waiting = Gui(), []
    assert add_live_controls(gui, sim, waiting.append, ()) >= 3
    target = next(control for label, control in gui.controls.items() if label.startswith("target"))
    force = next(control for label, control in gui.controls.items() if label.startswith("force"))
    target.set(3.0)
    force.set((0.0, 2.0, 0.0))
    gui.controls["axle"].set(False)
    assert motor.target == 1.0, "nothing is changed by the thread of the page"
    for command in waiting:
        command()
    assert motor.target == 3.0 and tuple(wind.force) == (0.0, 2.0, 0.0) and not hinge.enabled


def test_targets_of_robots_are_sliders_within_the_limits() -> None:
    pytest.importorskip("yourdfpy")
    scene = stark.Scene()
    robot = scene.add_robot(ROBOT)
    drives = robot.add_servos(stiffness=50.0, damping=5.0, cap=100.0)
    sim = stark.Simulation(scene, time_step=0.01)
    gui, waiting = Gui(), []
    add_live_controls(gui, sim, waiting.append, ())
    lower, upper = robot.limits
    for row, joint in zip(drives.rows, drives.joints, strict=True):
        low, high = gui.controls[joint].bounds
        assert low >= lower[row] and high <= upper[row]
    first = drives.joints[0]
    gui.controls[first].set(0.5 * sum(gui.controls[first].bounds) + 0.1)
    waiting.pop()()
    assert sim.robots[0].drives[0].target[0] == pytest.approx(gui.controls[first].value)


def test_a_scene_without_live_values_has_no_controls() -> None:
    scene = stark.Scene()
    scene.add_sphere(0.05, mass=1.0)
    sim = stark.Simulation(scene, time_step=0.01)
    assert add_live_controls(Gui(), sim, lambda command: None, ()) == 0
    assert free_port() > 0
