"""Energy is never made: implicit Euler without damping may only lose it."""

from __future__ import annotations

import numpy as np
import pytest
from _helpers import G, advance, lumped_masses, mean_velocity

import stark


def total(report: object) -> float:
    return float(sum(report.energy.values()))  # type: ignore[attr-defined]


@pytest.mark.parametrize("step", [1 / 60, 1 / 250])
@pytest.mark.parametrize("angle", [0.0, 25.0])
def test_bouncing_elastic_block_gains_no_energy(step: float, angle: float) -> None:
    drop, size, density = 0.2, 0.1, 1000.0
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.default_friction = 0.0
    block = scene.add_solid(
        stark.mesh.tet_box(size, 3),
        stark.SolidMaterial(density=density, youngs_modulus=1e5, poissons_ratio=0.3),
        rotation=stark.rotation(axis="x", angle=angle * stark.deg),
        position=(0.03, 0.11, drop + 0.06),
    )
    mass = lumped_masses(block, density).sum()
    sim = stark.Simulation(scene, time_step=step, contact_distance=1e-3)
    available = mass * G * drop
    previous = None
    bounced, gained = False, 0.0
    for report in sim.run(0.6):
        assert not report.failed, report.message
        energy = total(report)
        if previous is not None:
            gained += max(0.0, energy - previous)
        previous = energy
        bounced |= sim.time > 0.2 and bool(mean_velocity(block, density)[2] > 0.05)
    assert bounced
    # Implicit Euler only loses. The stiffness of barriers is chosen anew in every step, so what they hold may
    # jump between steps: all gains together stay below 1e-4 of the energy of the fall.
    assert gained < 1e-4 * available


def test_free_vibration_decays_as_implicit_euler_says() -> None:
    """An oscillator of frequency w keeps 1 / (1 + h^2 w^2) of its energy in a step. Here the first
    longitudinal mode of a free bar, w = pi c / L with c^2 = E / rho."""
    length, width, modulus, density, nu = 0.2, 0.02, 1e5, 1000.0, 0.3
    mesh = stark.mesh.tet_box((length, width, width), (20, 2, 2))
    x = mesh.vertices[:, 0]
    amplitude = 1e-3 * length
    strain = amplitude * np.pi / length * np.cos(np.pi * x / length)
    start = mesh.vertices.copy()
    start[:, 0] += amplitude * np.sin(np.pi * x / length)
    start[:, 1:] *= 1.0 - nu * strain[:, None]
    omega = np.pi / length * np.sqrt(modulus / density)
    for step in (2e-4, 1e-4):
        scene = stark.Scene()
        material = stark.SolidMaterial(density=density, youngs_modulus=modulus, poissons_ratio=nu)
        scene.add_solid(mesh, material, initial_positions=start)
        settings = {
            "newton.acceleration_tolerance": 1e-3,
            "newton.step_tolerance": 1e-6,
            "contact.enabled": False,
        }
        sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **settings)
        energies = np.array([total(report) for report in advance(sim, 0.04)])  # one period
        assert np.all(np.diff(energies) < 1e-9 * energies[0])
        rate = -np.log(energies[-1] / energies[0]) / (len(energies) - 1)
        # 5 %: the frequency of this mesh and of the thick bar, twice its relative error.
        assert rate == pytest.approx(np.log(1.0 + (step * omega) ** 2), rel=0.05)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_actuators_work_along_the_way_of_their_coordinates(integrator: str) -> None:
    """A constant torque gives torque times angle, whatever the rates of the integrator are; with bdf2 a wheel
    turns by half of that and keeps all but the first step's error."""
    torque, moment, step, steps = 0.01, 0.004, 0.01, 100
    scene = stark.Scene()
    wheel = scene.add_cylinder(0.1, 0.02, inertia=(1.0, (0, 0, 0), moment * np.eye(3)))
    axle = scene.add_hinge(None, wheel, anchor=(0, 0, 0), axis=(0, 0, 1))
    axle.add_effort(torque)
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), time={"integrator": integrator})
    supplied = lost = 0.0
    for report in sim.run(steps * step):
        supplied += report.energy["actuation"]
        lost += report.energy["numerical"]
    assert supplied == pytest.approx(torque * axle.angle, rel=1e-9)
    assert report.energy["kinetic"] == pytest.approx(0.5 * torque**2 * (steps * step) ** 2 / moment, rel=1e-6)
    # The sum of m/2 |dv|^2 is 1/steps of what it has; with bdf2 only the first step, by implicit Euler,
    # loses.
    expected = 1.0 / steps if integrator == "implicit_euler" else 1.0 / steps**2
    assert lost / supplied == pytest.approx(expected, rel=0.02)
