"""A soft ball bounces from a floor: its rebound against explicit central differences of the same mesh, and
the balance of its energy."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest

import stark

RADIUS, MODULUS, RATIO, DENSITY, SPEED = 0.05, 2e5, 0.4, 1000.0, 2.4  # [m], [Pa], [kg/m^3], [m/s]
MESH = stark.mesh.tet_ball(RADIUS, 2)


def masses_of(volumes: Any) -> Any:
    return np.bincount(np.asarray(MESH.tets).ravel(), np.repeat(DENSITY * volumes / 4.0, 4))


@functools.cache
def exact() -> float:
    """Speed after the impact over that before, without damping: stable Neo-Hookean elements and lumped masses
    above a stiff penalty, in steps of 25 microseconds."""
    rest, tets = np.asarray(MESH.vertices), np.asarray(MESH.tets)
    shear = MODULUS / 2.0 / (1.0 + RATIO)
    bulk = MODULUS * RATIO / (1.0 + RATIO) / (1.0 - 2.0 * RATIO) + shear
    edges = np.stack([rest[tets[:, i]] - rest[tets[:, 0]] for i in (1, 2, 3)], axis=2)
    volumes, inverse = np.linalg.det(edges) / 6.0, np.linalg.inv(edges)
    masses = masses_of(volumes)

    def forces(x: Any) -> Any:
        f = np.stack([x[tets[:, i]] - x[tets[:, 0]] for i in (1, 2, 3)], axis=2) @ inverse
        columns = [np.cross(f[:, :, (i + 1) % 3], f[:, :, (i + 2) % 3]) for i in range(3)]
        cofactor = np.stack(columns, axis=2)
        stress = shear * f + (bulk * (np.linalg.det(f) - 1.0) - shear)[:, None, None] * cofactor
        nodal = -volumes[:, None, None] * stress @ inverse.transpose(0, 2, 1)
        out = np.zeros_like(x)
        for i in range(3):
            np.add.at(out, tets[:, i + 1], nodal[:, :, i])
        np.add.at(out, tets[:, 0], -nodal.sum(axis=2))
        out[:, 2] -= 9.81 * masses + 1e4 * np.minimum(x[:, 2], 0.0)
        return out

    x = rest - [0.0, 0.0, rest[:, 2].min()]
    v = np.zeros_like(x) - [0.0, 0.0, SPEED]
    step = 2.5e-5
    for k in range(2000):
        v += step * forces(x) / masses[:, None]
        x += step * v
        if k * step > 0.005 and x[:, 2].min() > 0.0:
            return float(masses @ v[:, 2] / masses.sum() / SPEED)
    raise AssertionError("the ball has not left the floor")


def rebound(step: float, damping: float = 0.0) -> float:
    """Of the simulation; checks that the energy lost is accounted for."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    material = stark.SolidMaterial(
        density=DENSITY, youngs_modulus=MODULUS, poissons_ratio=RATIO, strain_damping=damping
    )
    ball = scene.add_solid(
        MESH, material, name="ball", position=(0, 0, RADIUS + 5e-4), velocity=(0, 0, -SPEED)
    )
    sim = stark.Simulation(scene, {"time.integrator": "bdf2"}, time_step=step, contact_distance=2e-4)
    energy = [0.5 * ball.mass * SPEED**2 + ball.mass * 9.81 * (RADIUS + 5e-4)]
    lost, touched = 0.0, False
    for report in sim.run(until=0.04):
        lost += sum(report.energy[name] for name in ("damping", "friction", "numerical"))
        energy.append(sum(report.energy[name] for name in ("kinetic", "elastic", "gravity", "contact")))
        if touched and report.contact_count == 0:
            break
        touched |= report.contact_count > 0
    assert energy[0] - energy[-1] == pytest.approx(lost, abs=2e-3 * energy[0])
    corners = np.asarray(MESH.vertices)[np.asarray(MESH.tets)]
    masses = masses_of(np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0)
    return float(masses @ ball.velocities[:, 2] / masses.sum() / SPEED)


def test_the_rebound_of_a_soft_ball_converges_to_that_of_explicit_steps() -> None:
    long, middle, short = (rebound(step) for step in (2e-3, 1e-3, 2.5e-4))
    assert short == pytest.approx(exact(), rel=0.02)
    # What the guide to integrators says of steps of a tenth and a twentieth of the impact.
    assert long / exact() == pytest.approx(0.84, abs=0.03)
    assert middle / exact() == pytest.approx(0.94, abs=0.02)


def test_damping_of_the_material_lowers_it() -> None:
    assert rebound(1e-3, damping=100.0) < rebound(1e-3, damping=20.0) - 0.05
