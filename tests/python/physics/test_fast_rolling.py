"""Energy of a ball that rolls around the inside of a pipe, in steps in which it turns little or much."""

from __future__ import annotations

import numpy as np
import pytest

import stark

G, R, RADIUS, MASS, DISTANCE = 9.81, 0.1, 0.01, 0.05, 2e-5


def pipe(segments: int) -> stark.TriangleMesh:
    """A wall of 10 mm about z, whose inner radius is R."""
    turns = np.arange(segments) * 2.0 * np.pi / segments
    section = ((R, -0.6), (R + 0.01, -0.6), (R + 0.01, 0.6), (R, 0.6))
    points = [(r * np.cos(turn), r * np.sin(turn), z) for turn in turns for r, z in section]
    triangles = []
    for k in range(segments):
        for i in range(4):
            a, b = 4 * k + i, 4 * k + (i + 1) % 4
            c, d = (a + 4) % (4 * segments), (b + 4) % (4 * segments)
            triangles += [(a, d, b), (a, c, d)]
    return stark.mesh.oriented(stark.TriangleMesh(np.array(points), np.array(triangles)))


def largest_energy(step: float, duration: float = 0.5) -> float:
    """Over that at the start, of a ball that starts level at 1.8 m/s and rolls."""
    scene = stark.Scene()
    scene.default_friction = 1.0
    scene.add_rigid(pipe(256), motion="fixed")
    place = R - RADIUS - 1.8 * DISTANCE
    speed = 20.0 * place
    ball = scene.add_sphere(
        RADIUS,
        subdivisions=4,
        mass=MASS,
        position=(place, 0, 0),
        velocity=(0, speed, 0),
        angular_velocity=(0, 0, -speed / RADIUS),
    )
    sim = stark.Simulation(scene, time_step=step, contact_distance=DISTANCE)
    inertia = 0.4 * MASS * RADIUS**2
    start, energies = 0.5 * MASS * speed**2 + 0.5 * inertia * (speed / RADIUS) ** 2, []
    for _ in sim.run(until=duration):
        v, w = ball.velocity, ball.angular_velocity
        energies.append(0.5 * MASS * v @ v + 0.5 * inertia * w @ w + MASS * G * ball.position[2])
    return max(energies) / start


@pytest.mark.parametrize(("step", "largest"), [(0.005, 1.98), (0.002, 1.11)])
def test_a_ball_that_turns_far_in_a_step_gains_what_the_guide_says(step: float, largest: float) -> None:
    assert largest_energy(step) == pytest.approx(largest, rel=0.1)


def test_a_ball_that_turns_little_in_a_step_gains_nothing() -> None:
    assert largest_energy(0.001) < 1.001
