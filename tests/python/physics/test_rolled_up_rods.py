"""Rods rolled up by a torque at their end, in quasistatic steps: arcs of a circle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

LENGTH = 0.5  # [m]
WIRE = stark.RodMaterial(density=1200.0, youngs_modulus=1e9, radius=0.002)
STEPS = 20


def rolled_up(turns: float, is_planar: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A rod along x, clamped, whose end is turned about -y: nodes, torques at the clamp and at the end."""
    scene = stark.Scene()
    line = stark.mesh.polyline((0, 0, 0), (LENGTH, 0, 0), segments=40)
    rod = scene.add_rod(line, WIRE, clamps=[0], self_contact=False)
    if is_planar:
        plane = stark.rotation(axis="x", angle=-90 * stark.deg)  # its normal is y
        end: Any = rod.frame(-1, rotation=rod.frames[-1].T @ plane)
        scene.add_joint("planar", stark.world_frame((LENGTH, 0, 0), plane), end)
    load = scene.add_torque(rod.frame(-1), (0, 0, 0))
    still = {"time.integrator": "quasistatic"}
    sim = stark.Simulation(scene, still, time_step=0.1, gravity=(0, 0, 0))
    torque = 2.0 * np.pi * turns * WIRE.section["bending_stiffness_1"] / LENGTH
    for step in range(1, STEPS + 1):
        load.torque = (0.0, -torque * step / STEPS, 0.0)
        sim.step()
    return rod.positions, rod.clamp_torques[0], np.array((0.0, -torque, 0.0))


@pytest.mark.parametrize(("turns", "is_planar"), [(0.35, False), (0.35, True), (1.0, True)])
def test_a_rod_becomes_an_arc_of_a_circle(turns: float, is_planar: bool) -> None:
    """Its curvature is torque / (E I). Chords of 40 segments shorten an arc of one turn by 0.1 %, and its
    ends are half a segment off, which together move the end by less than 0.3 % of the length."""
    places, held, torque = rolled_up(turns, is_planar)
    radius, angle = LENGTH / (2.0 * np.pi * turns), 2.0 * np.pi * turns
    end = radius * np.array((np.sin(angle), 0.0, 1.0 - np.cos(angle)))
    assert np.linalg.norm(places[-1] - end) < 3e-3 * LENGTH
    assert abs(places[:, 1]).max() < 1e-6
    assert held == pytest.approx(-torque, abs=1e-4 * np.linalg.norm(torque))
