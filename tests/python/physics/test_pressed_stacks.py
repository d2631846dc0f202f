"""Stacks of thin sheets that a press squeezes together."""

from __future__ import annotations

import numpy as np
import pytest

import stark

SHEETS, PITCH, FORCE = 20, 0.000125, 5000.0  # [], [m], [N]


@pytest.mark.slow
def test_sheets_that_meet_in_a_step_hold_each_other_by_friction() -> None:
    """Sheets that touch next to no other at the start of the step have friction before it has converged:
    without it they slid off sideways, and the step took 248 iterations in two attempts."""
    scene = stark.Scene()
    scene.default_friction = 0.3
    base = scene.add_box((0.4, 0.4, 0.1), motion="fixed", position=(0, 0, -0.05), name="base")
    mesh = stark.mesh.grid(0.297, 0.21, (12, 8))
    for k in range(SHEETS):
        place = (0.0005 * (7 * k % 5 - 2), 0.0005 * (3 * k % 5 - 2), PITCH * (k + 1))
        scene.add_cloth(
            mesh, stark.materials.paper, name=f"sheet {k}", surface=stark.surfaces.paper, position=place
        )
    press = scene.add_box(
        (0.35, 0.25, 0.03), mass=5.0, position=(0, 0, PITCH * (SHEETS + 1) + 0.0152), name="press"
    )
    ram = scene.add_slider(base, press, anchor=(0, 0, 0.04), axis=(0, 0, -1))
    ram.add_motor(0.5, cap=FORCE, delta=0.01)
    sim = stark.Simulation(scene)
    first = sim.step()
    assert first.time_step == sim.settings.time_step  # in one piece
    assert first.newton_iterations < 120
    for _ in range(4):
        sim.step()
    carried = sim.contacts.of("base").forces.sum(axis=0)
    weight = 9.81 * (5.0 + sum(sim[f"sheet {k}"].mass for k in range(SHEETS)))
    assert abs(carried[2]) == pytest.approx(FORCE + weight, rel=1e-4)
    shifts = [sim[f"sheet {k}"].positions.mean(axis=0)[:2] for k in range(SHEETS)]
    starts = [(0.0005 * (7 * k % 5 - 2), 0.0005 * (3 * k % 5 - 2)) for k in range(SHEETS)]
    assert np.abs(np.array(shifts) - starts).max() < 1e-4  # none slides off
