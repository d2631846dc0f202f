"""No accepted step leads through anything: small fast bodies against free thin ones, at default settings.
Every step is taken in pieces until its way is clear, or it fails and says so."""

from __future__ import annotations

import numpy as np
import pytest
from _helpers import Judge

import stark

pytest.importorskip("ipctk")

TILTED = stark.rotation(axis=(1, 2, 3), angle=1.0)


def shot(
    plate: float, thickness: float, speed: float, *, size: float = 0.002, spin: float = 0.0, off: float = 0.0
) -> tuple[stark.Simulation, float]:
    """A cube thrown at a free plate, ``off`` its middle [m]. Returns the simulation and the depth [m] of the
    cube's centre below the plate's middle in the frame of the plate, where it must never be."""
    scene = stark.Scene()
    density = 1000.0
    scene.add_box((plate, plate, thickness), density=density, name="plate")
    scene.add_box(
        size,
        density=density,
        name="cube",
        position=(off, 0, 0.5 * thickness + 1.5 * size),
        velocity=(0, 0, -speed),
        rotation=TILTED,
        angular_velocity=(0, spin, 0),
    )
    return stark.Simulation(scene, gravity=(0, 0, 0)), thickness


def side(sim: stark.Simulation) -> float:
    """Height of the cube over the middle of the plate, along its normal [m]."""
    plate, cube = sim["plate"], sim["cube"]
    return float((cube.position - plate.position) @ plate.rotation[:, 2])


@pytest.mark.parametrize("plate", [0.002, 0.005, 0.01, 0.05])
@pytest.mark.parametrize("speed", [2.0, 7.7, 40.0, 300.0])
def test_a_small_cube_does_not_pass_a_free_plate(plate: float, speed: float) -> None:
    """The first steps: later, a cube may go around a plate that it has set spinning."""
    sim, _ = shot(plate, 0.1 * plate, speed)
    momentum = sim["cube"].mass * speed
    hit = False
    for _ in range(40):
        report = sim.step()
        assert not report.failed, report.message
        assert np.allclose(report.momentum, (0, 0, -momentum), atol=1e-6 * momentum)
        hit = hit or report.contact_count > 0
        if not hit:
            assert side(sim) > 0.0
    assert hit
    assert sim["plate"].velocity[2] < -0.1 * momentum / (sim["plate"].mass + sim["cube"].mass)


@pytest.mark.parametrize("speed", [1e4, 1e6])
def test_what_is_too_fast_for_the_shortest_step_fails(speed: float) -> None:
    sim, _ = shot(0.01, 0.001, speed)
    for _ in range(5):
        report = sim.step()
        if report.failed:
            assert report.diagnosis.cause in ("detour", "blocked_motion", "iteration_budget", "crushing_load")
            return
        assert side(sim) > 0.0 or report.contact_count > 0


@pytest.mark.parametrize("spin", [300.0, 2000.0])
def test_a_spinning_rod_hits_what_is_in_its_circle(spin: float) -> None:
    """A free stick that turns by a quarter turn a step and more, and a free ball at rest in its way: chords
    of its ends would miss the ball."""
    scene = stark.Scene()
    scene.add_box((0.2, 0.004, 0.004), density=1000.0, name="stick", angular_velocity=(0, 0, spin))
    at = 0.097 * np.array([np.cos(0.8), np.sin(0.8), 0.0])
    scene.add_sphere(0.002, subdivisions=1, density=1000.0, name="ball", position=at)
    sim = stark.Simulation(scene, gravity=(0, 0, 0))
    judge = Judge(sim)
    turned = 0.0
    while turned < 3.0:
        report = sim.step()
        assert not report.failed, report.message
        assert not judge.intersects()
        turned += spin * report.time_step
    assert np.linalg.norm(sim["ball"].velocity) > 0.1 * spin * 0.1
