"""Sheets between two bodies that press on them: how much of the friction they get."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark


def share_of_the_grip(force: float, cloth: dict[str, Any], finger: dict[str, Any]) -> float:
    """Force that pulls a cloth out of two fingers, over 2 mu times the force that closes them."""
    scene, mu = stark.Scene(), 0.5
    scene.default_friction = mu
    mesh = stark.mesh.grid(0.1, 0.1, cells=20)
    edge = [k for k, x in enumerate(mesh.vertices) if x[0] > 0.05 - 1e-9]
    sheet = scene.add_cloth(mesh, stark.materials.cotton, pins=edge, **cloth)
    for side in (-1.0, 1.0):
        place = (-0.0187, 0.0013, 9e-3 * side)  # beside the rows of vertices
        part = scene.add_box((0.03, 0.03, 0.01), mass=0.05, position=place, **finger)
        scene.add_slider(None, part, anchor=place, axis="z").add_motor(-0.05 * side, cap=force, delta=0.01)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    sim.run_until(0.4)
    start, pulls = sheet.pin_targets.copy(), []
    while sim.time < 0.7 - 1e-9:
        sheet.pin_targets = start + np.array((0.05 * (sim.time + 0.01 - 0.4), 0.0, 0.0))
        sim.run_until(sim.time + 0.01)
        pulls.append(sheet.pin_forces[:, 0].sum())
    return float(np.mean(pulls[-8:])) / (2.0 * mu * force)


@pytest.mark.parametrize(("force", "share"), [(1.0, 0.97), (5.0, 0.23), (20.0, 0.07)])
def test_fingers_press_on_each_other_through_a_soft_sheet_as_the_guide_says(
    force: float, share: float
) -> None:
    assert share_of_the_grip(force, {}, {}) == pytest.approx(share, abs=0.04)


@pytest.mark.parametrize("force", [1.0, 5.0, 20.0])
def test_a_sheet_stiffer_than_the_pressure_gets_the_grip(force: float) -> None:
    assert share_of_the_grip(force, {"contact_stiffness": 1e4}, {}) == pytest.approx(1.0, abs=0.03)


def test_a_sheet_thicker_than_what_presses_it_gets_most_of_the_grip() -> None:
    assert share_of_the_grip(5.0, {}, {"contact_distance": 1e-4}) == pytest.approx(0.79, abs=0.05)
