"""Sheets between two bodies that press on them: how much of the friction they get."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark


def share_of_the_grip(
    force: float, cloth: dict[str, Any], finger: dict[str, Any], beside: float = 1.3e-3
) -> float:
    """Force that pulls a cloth out of two fingers, over 2 mu times the force that closes them. beside: of the
    edges of the fingers to rows of vertices [m]."""
    scene, mu = stark.Scene(), 0.5
    scene.default_friction = mu
    mesh = stark.mesh.grid(0.1, 0.1, cells=20)
    edge = [k for k, x in enumerate(mesh.vertices) if x[0] > 0.05 - 1e-9]
    sheet = scene.add_cloth(mesh, stark.materials.cotton, pins=edge, **cloth)
    for side in (-1.0, 1.0):
        place = (-0.02 + beside, beside, 9e-3 * side)
        part = scene.add_box((0.03, 0.03, 0.01), mass=0.05, position=place, **finger)
        scene.add_slider(None, part, anchor=place, axis="z").add_motor(-0.05 * side, cap=force, delta=0.01)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    reports = [*sim.run(until=0.4)]
    start, pulls = sheet.pin_targets.copy(), []
    while sim.time < 0.7 - 1e-9:
        sheet.pin_targets = start + np.array((0.05 * (sim.time + 0.01 - 0.4), 0.0, 0.0))
        reports += sim.run(until=sim.time + 0.01)
        pulls.append(sheet.pin_forces[:, 0].sum())
    assert sum(report.rejected_steps for report in reports) == 0
    assert np.mean([report.newton_iterations for report in reports]) < 15
    return float(np.mean(pulls[-8:])) / (2.0 * mu * force)


@pytest.mark.parametrize("force", [1.0, 5.0, 20.0])
def test_a_soft_sheet_gets_the_grip_soon(force: float) -> None:
    assert share_of_the_grip(force, {}, {}) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("force", [1.0, 5.0, 20.0])
def test_a_sheet_stiffer_than_the_pressure_gets_the_grip(force: float) -> None:
    assert share_of_the_grip(force, {"contact_stiffness": 1e4}, {}) == pytest.approx(1.0, abs=0.03)


def test_fingers_with_edges_exactly_above_rows_of_vertices_hold_a_cloth() -> None:
    # Edges that are parallel up to rounding once let every step fail down to microseconds.
    assert share_of_the_grip(5.0, {}, {}, beside=0.0) == pytest.approx(1.0, abs=0.03)


def test_a_sheet_thicker_than_what_presses_it_gets_the_grip() -> None:
    assert share_of_the_grip(5.0, {}, {"contact_distance": 1e-4}) == pytest.approx(1.0, abs=0.05)


def test_a_tablecloth_carries_a_mug_alone_soon() -> None:
    scene = stark.Scene()
    table = scene.add_box((0.5, 0.6, 0.04), motion="fixed", position=(0.0, 0.0, -0.02))
    mesh = stark.mesh.grid(0.3, 0.3, cells=20)
    cloth = scene.add_cloth(mesh, stark.materials.cotton, position=(0.0, 0.0, 2.1e-3))
    mug = scene.add_cylinder(0.03, 0.08, mass=0.3, position=(-0.03, 0.0, 0.0442))
    sim = stark.Simulation(scene, time_step=0.005)

    def force_from(body: stark.BodyHandle) -> float:
        return float(sim.contacts.of(mug, body).forces.sum(axis=0)[2]) / (0.3 * 9.81)

    sim.run_until(0.1)
    assert force_from(table) > 0.1  # the cloth has not got its stiffness yet
    sim.run_until(0.8)
    assert force_from(table) < 1e-3
    assert force_from(cloth) == pytest.approx(1.0, abs=1e-3)
