"""Controls of what may change between steps: targets of robots, values of actuators and energies, what
holds."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from typing import Any

import numpy as np

#: Range of sliders of coordinates without limits [rad, m], and of rates without any [rad/s, m/s].
_ANGLE, _RATE = math.pi, 10.0

Command = Callable[[], object]
Later = Callable[[Command], None]
"""Hands a command to the thread that takes the steps."""


def add_live_controls(gui: Any, sim: Any, later: Later, hidden: Collection[int]) -> int:
    """Adds a folder for each robot, actuator, energy and joint of a simulation; returns how many controls
    there are. ``hidden`` are numbers of energies to leave out."""
    count, driven = 0, set()
    for robot in sim.robots:
        driven |= {a._index for drives in robot.drives for a in drives.actuators}
        count += _add_robot(gui, robot, later)
    for actuator in sim.actuators:
        if actuator._index not in driven:
            count += _add_actuator(gui, actuator, later)
    for energy in sim.energies:
        if energy._index not in hidden:
            count += _add_energy(gui, energy, later)
    return count + _add_switches(gui, sim, later)


def _add_robot(gui: Any, robot: Any, later: Later) -> int:
    count = 0
    lower, upper = robot.limits
    for drives in robot.drives:
        with gui.add_folder(f"{robot.name}: {drives.kind}", expand_by_default=count == 0):
            for k, (row, joint) in enumerate(zip(drives.rows, drives.joints, strict=True)):
                low, high = _range(drives, k, float(lower[row]), float(upper[row]))
                value = min(max(float(drives.target[k]), low), high)
                slider = gui.add_slider(
                    joint, min=low, max=high, step=(high - low) / 1000.0, initial_value=value
                )
                slider.on_update(_sets_target(slider, drives, k, later))
                count += 1
    return count


def _range(drives: Any, k: int, lower: float, upper: float) -> tuple[float, float]:
    """Of the target of a drive."""
    if drives.kind == "servos":
        return (lower if lower > -np.inf else -_ANGLE), (upper if upper < np.inf else _ANGLE)
    if drives.kind == "motors":
        return -_RATE, _RATE
    cap = float(drives._caps()[k])
    return (-cap, cap) if cap < np.inf else (-100.0, 100.0)


def _sets_target(slider: Any, drives: Any, k: int, later: Later) -> Callable[[Any], None]:
    def put() -> None:
        targets = drives.target.copy()
        targets[k] = slider.value
        drives.target = targets

    return lambda event: later(put)


def _add_actuator(gui: Any, actuator: Any, later: Later) -> int:
    with gui.add_folder(f"{actuator.name} ({actuator.kind})", expand_by_default=False):
        for name, value in actuator.parameters.items():
            _add_number(gui, actuator, name, actuator.units.get(name, ""), value, later)
    return len(actuator.parameters)


def _add_energy(gui: Any, energy: Any, later: Later) -> int:
    """Values that hold for all elements; those with a value for each are for programs."""
    shown = {n: v for n, v in energy.parameters.items() if np.shape(v) in ((), (3,))}
    if not shown:
        return 0
    with gui.add_folder(energy.name, expand_by_default=False):
        for name, value in shown.items():
            unit = energy._parameter(name).unit
            if np.shape(value) == ():
                _add_number(gui, energy, name, unit, value, later)
                continue
            field = gui.add_vector3(_label(name, unit), initial_value=tuple(map(float, value)), step=1e-4)
            field.on_update(_assigns(field, energy, name, later))
    return len(shown)


def _add_number(gui: Any, owner: Any, name: str, unit: str, value: float, later: Later) -> None:
    if not math.isfinite(value):
        return  # such as a cap that there is not
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2) if value != 0.0 else 0.01
    field = gui.add_number(_label(name, unit), initial_value=float(value), step=step)
    field.on_update(_assigns(field, owner, name, later))


def _assigns(field: Any, owner: Any, name: str, later: Later) -> Callable[[Any], None]:
    return lambda event: later(lambda: setattr(owner, name, field.value))


def _add_switches(gui: Any, sim: Any, later: Later) -> int:
    held = [*sim.joints, *sim.attachments]
    if held:
        with gui.add_folder("Joints and attachments", expand_by_default=False):
            for part in held:
                box = gui.add_checkbox(part.name, initial_value=bool(part.enabled))
                box.on_update(_assigns(box, part, "enabled", later))
    return len(held)


def _label(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit and unit != "1" else name
