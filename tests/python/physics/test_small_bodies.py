"""Small and light bodies in short steps move: no tolerance freezes them."""

from __future__ import annotations

import numpy as np
import pytest
from _helpers import G, advance

import stark

STEP, COUNT = 1e-3, 200
# Position and velocity after COUNT steps of implicit Euler from rest. A step that stops short of its minimum
# leaves at most the acceleration tolerance: 0.01 m/s^2 of 9.81, 0.1 %.
DROP = G * STEP * STEP * COUNT * (COUNT + 1) / 2
SPEED = G * STEP * COUNT


def test_cotton_patch_of_three_centimetres_falls() -> None:
    scene = stark.Scene()
    material = stark.materials.cotton.replace(mass_damping=0.0)
    patch = scene.add_cloth(stark.mesh.grid(0.03, 0.03, 6), material)
    sim = stark.Simulation(scene, time_step=STEP)
    advance(sim, STEP * COUNT)
    assert patch.positions[:, 2] == pytest.approx(-DROP, rel=1e-6)
    assert patch.velocities[:, 2] == pytest.approx(-SPEED, rel=1e-6)


def test_damped_cotton_patch_falls_as_its_damping_says() -> None:
    scene = stark.Scene()
    patch = scene.add_cloth(stark.mesh.grid(0.03, 0.03, 6), stark.materials.cotton)
    sim = stark.Simulation(scene, time_step=STEP)
    advance(sim, STEP * COUNT)
    speed = 0.0
    for _ in range(COUNT):
        speed = (speed + STEP * G) / (1.0 + STEP * stark.materials.cotton.mass_damping)
    assert patch.velocities[:, 2] == pytest.approx(-speed, rel=1e-6)


@pytest.mark.parametrize("mass", [1e-4, 1e-7])
def test_box_of_a_tenth_of_a_gram_and_less_falls(mass: float) -> None:
    scene = stark.Scene()
    box = scene.add_box(0.005, mass=mass)
    sim = stark.Simulation(scene, time_step=STEP)
    advance(sim, STEP * COUNT)
    assert box.position[2] == pytest.approx(-DROP, rel=1e-6)
    assert box.velocity[2] == pytest.approx(-SPEED, rel=1e-6)


def test_small_soft_cube_falls() -> None:
    scene = stark.Scene()
    material = stark.materials.soft_rubber.replace(mass_damping=0.0)
    cube = scene.add_solid(stark.mesh.tet_box(0.004, 2), material)
    sim = stark.Simulation(scene, time_step=STEP, contact_distance=1e-4)
    advance(sim, STEP * COUNT)
    assert cube.positions[:, 2] - cube.mesh.vertices[:, 2] == pytest.approx(-DROP, rel=1e-6)


def test_light_box_lands_and_rests_beside_a_heavy_one() -> None:
    """Tolerances are accelerations, so a heavy neighbour does not loosen them for a light body."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.add_box(0.1, mass=1000.0, position=(0.2, 0.1, 0.052), name="heavy")
    light = scene.add_box(0.005, mass=1e-4, position=(-0.1, 0.03, 0.0225), name="light")
    sim = stark.Simulation(scene, time_step=STEP, contact_distance=5e-4)
    advance(sim, 0.04)
    n = 40
    assert light.position[2] == pytest.approx(0.0225 - G * STEP * STEP * n * (n + 1) / 2, rel=1e-5)
    advance(sim, 0.3)
    assert 0.0025 < light.position[2] < 0.0025 + 1.001e-3
    assert np.abs(light.velocity).max() < 2e-3
