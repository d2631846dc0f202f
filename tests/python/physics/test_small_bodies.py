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


def swing_and_slide(gravity: float, **settings: float) -> tuple[float, float]:
    """Angle of a pendulum that was level and way of a box down a slope, over the size, after 50 steps."""
    scene = stark.Scene()
    scene.default_friction = 0.3
    bar = scene.add_box((0.4, 0.05, 0.05), mass=1.0, position=(0.2, 3, 0))
    hinge = scene.add_hinge(None, bar, (0, 3, 0), (0, 1, 0))
    slope = stark.rotation(axis="y", angle=np.arctan(0.5))
    scene.add_box((8, 2, 0.1), motion="fixed", rotation=slope)
    start = slope @ (0, 0, 0.1019)
    box = scene.add_box(0.1, mass=1.0, position=start, rotation=slope)
    step = 0.01 * np.sqrt(G / gravity)
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, -gravity), settings=settings)
    advance(sim, 50 * step)
    return hinge.angle, float((box.position - start) @ slope[:, 0])


@pytest.mark.filterwarnings("ignore:the settings. time_step")
def test_weak_gravity_moves_what_has_the_tolerances_for_it() -> None:
    weak, speed = 1e-5, np.sqrt(1e-5 * 0.05)
    fine = {"newton.acceleration_tolerance": 1e-3 * weak, "contact.stick_velocity": 1e-3 * speed}
    ordinary = swing_and_slide(G, **{"contact.stick_velocity": 1e-3 * np.sqrt(G * 0.05)})
    assert swing_and_slide(weak, **fine) == pytest.approx(ordinary, rel=1e-3)


@pytest.mark.filterwarnings("ignore:the settings. time_step")
def test_weak_gravity_without_them_is_warned_about() -> None:
    with (
        pytest.warns(stark.StarkWarning, match=r"gravity of 1e-05 m/s\^2 is below newton\.acc.*to 1e-08 m/s"),
        pytest.warns(stark.StarkWarning, match=r"'box_\d' gains 0\.00116 m/s .*stick_velocity is 0\.001 m/s"),
    ):
        swing_and_slide(1e-5)
