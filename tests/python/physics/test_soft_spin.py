"""Soft bodies that spin: a bar that turns as it does in any shorter step, stretched by its inertia (V28), and
what a sheet loses that swings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _validation import validate

import stark

LENGTH, RATE, E, RHO = 0.4, 8.0, 1e6, 1000.0


def spun(h: float) -> tuple[float, float, float, float]:
    """Momentum over that at the start, angular velocity, angle, and stretch over the expected one."""
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=RHO, youngs_modulus=E, poissons_ratio=0.0)
    mesh = stark.mesh.box_hexahedra((LENGTH, 0.04, 0.04), (20, 2, 2))
    bar = scene.add_solid(mesh, rubber, angular_velocity=(0.0, 0.0, RATE))
    settings = {"newton.acceleration_tolerance": 1e-6}
    sim = stark.Simulation(scene, time_step=h, gravity=(0, 0, 0), settings=settings)
    momenta = [report.angular_momentum[2] for report in sim.run(until=3.0)]
    right, left = (abs(mesh.vertices[:, 0] - x) < 1e-9 for x in (LENGTH / 2, -LENGTH / 2))
    along = bar.positions[right].mean(axis=0) - bar.positions[left].mean(axis=0)
    apart = bar.velocities[right].mean(axis=0) - bar.velocities[left].mean(axis=0)
    length = float(np.linalg.norm(along))
    rate = float(np.linalg.norm(apart)) / length
    expected = RHO * rate**2 * LENGTH**2 / (12.0 * E)
    angle = float(np.arctan2(along[1], along[0]))
    return momenta[-1] / momenta[0], rate, angle, (length / LENGTH - 1.0) / expected


def test_a_soft_bar_spins_alike_at_every_step() -> None:
    momentum, rate, angle, stretch = np.transpose([spun(h) for h in (1 / 60, 0.01, 0.002)])
    validate("V28.momentum", momentum)
    validate("V28.rate", rate)
    validate("V28.angle", angle)
    validate("V28.stretch", stretch)


def folded_sheet(angle: float, **how: Any) -> stark.Scene:
    """A sheet of 0.2 x 0.1 m, folded along its middle by twice the angle, that spins about all axes."""
    flat = stark.mesh.grid(0.2, 0.1, (16, 8))
    x, y, _ = flat.vertices.T
    folded = np.column_stack((x * np.cos(angle), y, abs(x) * np.sin(angle)))
    scene = stark.Scene()
    scene.add_cloth(
        flat,
        initial_positions=folded - folded.mean(axis=0),
        angular_velocity=(1.0, 5.0, 3.0),
        self_contact=False,
        **how,
    )
    return scene


def momentum_left(scene: stark.Scene, step: float, integrator: str) -> float:
    sim = stark.Simulation(scene, time_step=step, time={"integrator": integrator}, gravity=(0, 0, 0))
    momenta = [np.linalg.norm(report.angular_momentum) for report in sim.run(until=1.0)]
    return float(momenta[-1] / momenta[0])


@pytest.mark.parametrize(
    ("integrator", "step", "lost"),
    [
        ("implicit_euler", 5e-3, 0.11),
        ("implicit_euler", 1e-3, 0.05),
        ("bdf2", 5e-3, 0.024),
        ("bdf2", 1e-3, 0.002),
    ],
)
def test_a_sheet_that_springs_open_loses_what_the_guide_says(
    integrator: str, step: float, lost: float
) -> None:
    """docs/integrators.md."""
    springy = stark.ShellMaterial(density=0.2, thickness=1e-4, youngs_modulus=1e7, bending_stiffness=1e-4)
    left = momentum_left(folded_sheet(0.7, material=springy), step, integrator)
    assert 1.0 - left == pytest.approx(lost, rel=0.25)


@pytest.mark.parametrize("how", ["undamped", "flat", "rest of the mesh", "plate"])
def test_bending_damping_leaves_the_turning_of_folds_alone(how: str) -> None:
    """That of flat sheets was of the vector of curvature, and took three quarters of the spin."""
    cotton = stark.materials.cotton.replace(mass_damping=0.0, bending_damping=1e-6)
    material, angles = cotton, "flat"
    if how == "undamped":
        material = cotton.replace(bending_damping=0.0)
    elif how == "plate":
        material = cotton.replace(bending_stiffness=0.0, flexural_rigidity=3e-6)
    elif how == "rest of the mesh":
        angles = "mesh"
    left = momentum_left(folded_sheet(0.7, material=material, rest_angles=angles), 5e-3, "implicit_euler")
    assert left == pytest.approx(1.0, abs=2e-3)
