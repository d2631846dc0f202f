"""A gas law in the loop of a user, one step behind: stable below the stiffness in docs/energies.md."""

from __future__ import annotations

import pytest

import stark

OUTSIDE = 101325.0  # [Pa]
RADIUS, THICKNESS, DENSITY, MODULUS, POISSON = 0.1, 5e-3, 5.5, 1e6, 0.3


def bound(step: float) -> float:
    """Stiffness of the skin against a change of volume, with four times its inertia [Pa]."""
    stiffness = 2 * MODULUS * THICKNESS / (3 * RADIUS * (1 - POISSON))
    return stiffness + 4 * RADIUS * DENSITY / (3 * step**2)


def ball(step: float) -> list[float]:
    """Pressures over that outside after up to 60 steps, fewer if one failed [Pa]."""
    scene = stark.Scene()
    skin = stark.ShellMaterial(
        density=DENSITY,
        thickness=THICKNESS,
        youngs_modulus=MODULUS,
        poissons_ratio=POISSON,
        bending_stiffness=0,
        mass_damping=5.0,
    )
    body = scene.add_cloth(stark.mesh.sphere(RADIUS, 2), skin)
    air = scene.add_pressure(body, 5000.0)
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0))
    amount, pressures = None, []
    for _ in range(60):
        if sim.step().failed:
            break
        volume = -air.energy / air.pressure
        amount = amount or (OUTSIDE + air.pressure) * volume
        air.pressure = amount / volume - OUTSIDE
        pressures.append(air.pressure)
    return pressures


def test_a_gas_that_is_softer_than_skin_and_inertia_comes_to_rest() -> None:
    step = 1 / 320
    assert bound(step) == pytest.approx(1.15 * (OUTSIDE + 5000.0), rel=0.01)
    pressures = ball(step)
    assert len(pressures) == 60
    assert max(abs(p - pressures[-1]) for p in pressures[-5:]) < 1.0


def test_a_stiffer_one_swings_up() -> None:
    step = 1 / 250
    assert bound(step) == pytest.approx(0.88 * (OUTSIDE + 5000.0), rel=0.01)
    pressures = ball(step)
    assert len(pressures) < 60 or max(map(abs, pressures)) > 20_000.0
