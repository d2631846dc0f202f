"""V28: a soft bar that spins turns as it does in any shorter step, stretched by its inertia."""

from __future__ import annotations

import numpy as np
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
