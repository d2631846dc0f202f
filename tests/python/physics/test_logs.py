"""Three logs: one on top of two that touch hold by friction alone, from two coefficients on."""

from __future__ import annotations

import numpy as np
from physics._validation import validate

import stark

RADIUS, SIDES, GAP = 0.05, 192, 1e-4  # [m]
BETWEEN = np.tan(15 * stark.deg)  # least coefficient between logs: the force between them is at 15 degrees
FLOOR = (
    BETWEEN / 3.0
)  # three halves of a weight press each lower log down, and the same force pushes it aside


def sinking(between: float, floor: float) -> float:
    """How far the upper log comes down in 0.3 s [m], with these coefficients."""
    scene = stark.Scene()
    scene.add_floor(name="floor")
    apart = RADIUS + GAP / 2
    top = RADIUS + GAP + np.sqrt(3.0) * apart
    log = stark.mesh.cylinder(RADIUS, 0.1, SIDES)
    flat = stark.rotation(axis="x", angle=90 * stark.deg)
    turned = stark.rotation(axis="y", angle=np.pi / SIDES) @ flat
    for name, place, rotation in (
        ("left", (-apart, 0.0, RADIUS + GAP), flat),
        ("right", (apart, 0.0, RADIUS + GAP), flat),
        ("upper", (0.0, 0.0, top), turned),
    ):
        scene.add_rigid(log, mass=1.0, position=place, rotation=rotation, name=name)
    scene.friction["left", "right"] = 0.0
    for name in ("left", "right"):
        scene.friction[name, "upper"], scene.friction[name, "floor"] = between, floor
    sim = stark.Simulation(scene, time_step=0.002, contact_distance=GAP)
    sim.run_until(0.3)
    return float(top - scene["upper"].position[2])


def test_three_logs_hold_from_two_coefficients_on() -> None:
    """Moments about the floor and about the top leave one direction for the force between two logs, and the
    balance of all three what presses on the floor."""
    held = [sinking(1.06 * BETWEEN, 2.0), sinking(2.0, 1.06 * FLOOR)]
    validate("logs.held", max(held))
    fallen = [sinking(0.94 * BETWEEN, 2.0), sinking(2.0, 0.94 * FLOOR)]
    assert min(fallen) > 3e-3, fallen
