"""Cloth on a plane: dragged at constant speed, and on an incline (V26)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import G, advance, inclined_floor
from _validation import validate

import stark

SIDE, DENSITY, GAP = 0.3, 0.3, 5e-4  # [m], [kg/m^2], [m]
STEP, SPEED = 0.01, 0.1  # [s], [m/s]
# Cells of the cloth, cells of the floor and by how much they are turned [deg].
MESHES = {"coarse": (10, 1, 0.0), "fine": (20, 1, 0.0), "floor": (10, 40, 31.0)}


@stark.energy
def drag(p: stark.Point, target: float, stiffness: float):
    """A spring along x."""
    return 0.5 * stiffness * (p.x[0] - target) ** 2


def patch(mesh: str, angle: float, mu: float) -> tuple[stark.Scene, Any, np.ndarray]:
    """A patch just above a floor inclined by an angle [deg]; the columns downhill, across, normal."""
    cells, floor_cells, turn = MESHES[mesh]
    scene = stark.Scene()
    axes = inclined_floor(scene, angle, cells=floor_cells, turn=turn)
    material = stark.ShellMaterial(density=DENSITY, youngs_modulus=1e5, bending_stiffness=1e-5)
    grid = stark.mesh.grid(SIDE, SIDE, cells)
    position = axes @ (0.0, 0.4, 1.9 * GAP)
    cloth = scene.add_cloth(
        grid, material, name="cloth", rotation=axes, position=position, self_contact=False
    )
    scene.friction["cloth", "floor"] = mu
    return scene, cloth, axes


@pytest.mark.parametrize("mesh", MESHES)
def test_dragged_cloth_pulls_with_the_friction_of_its_weight(mesh: str) -> None:
    mu = 0.4
    scene, cloth, _ = patch(mesh, 0.0, mu)
    front = np.flatnonzero(cloth.mesh.vertices[:, 0] > 0.4999 * SIDE)
    hand = scene.add(drag(cloth.vertices[front], target=SIDE / 2, stiffness=2e3 / len(front)))
    sim = stark.Simulation(scene, time_step=STEP, contact_distance=GAP)
    forces = []
    for k in range(1, 101):
        hand.target = SIDE / 2 + SPEED * k * STEP
        report = sim.step(max_time_step=STEP)
        assert report.status == "accepted", report.message
        forces.append(hand.forces.reshape(-1, 3)[:, 0].sum())
    steady = np.array(forces[50:]) / (mu * DENSITY * SIDE**2 * G)  # the first half second sets it in motion
    validate(f"V26.pull_{mesh}", steady.mean())
    assert np.ptp(steady) < 0.02


@pytest.mark.parametrize("mesh", MESHES)
def test_cloth_slides_down_an_incline(mesh: str) -> None:
    validate(f"V26.slides_{mesh}", acceleration(mesh, 25.0, 0.3)[0])


def test_slip_angle_of_cloth() -> None:
    validate("V26.slips", acceleration("coarse", 17.2, 0.3)[0])
    validate("V26.holds", acceleration("coarse", 16.2, 0.3)[1])


def acceleration(mesh: str, angle: float, mu: float) -> tuple[float, float]:
    """Downhill, of the mean of the vertices, and their velocity at the end."""
    scene, cloth, axes = patch(mesh, angle, mu)
    sim = stark.Simulation(scene, time_step=STEP, contact_distance=GAP)
    advance(sim, 0.3)
    start = (cloth.velocities @ axes[:, 0]).mean()
    advance(sim, 0.8)
    end = (cloth.velocities @ axes[:, 0]).mean()
    return float(end - start) / 0.5, float(end)
