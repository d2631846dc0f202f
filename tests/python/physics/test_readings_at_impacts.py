"""What sensors show of the steps in which bodies meet, with bdf2: forces and accelerations that make the
change of the motion."""

from __future__ import annotations

import numpy as np
import pytest
from _helpers import G

import stark


@pytest.mark.parametrize("step", [0.01, 0.003, 0.001])
def test_forces_of_a_ball_that_bounces_make_its_change_of_momentum(step: float) -> None:
    """Contact that has just begun as a step brings the impact is no contact that lasts."""
    scene = stark.Scene()
    scene.add_box((4, 4, 0.1), motion="fixed", position=(0, 0, -0.05), name="floor")
    ball = scene.add_sphere(0.05, mass=1.0, position=(0, 0, 0.3))
    scene.restitution[ball, "floor"] = 0.9
    sim = stark.Simulation(scene, time_step=step, time={"integrator": "bdf2"})
    given = time = largest = 0.0
    for report in sim.run(until=1.5):
        assert not report.failed, report.message
        given += ball.contact_force[2] * (report.time - time)
        time = report.time
        largest = max(largest, abs(given - ball.velocity[2] - G * time))
    assert largest < 1e-4 * np.sqrt(2 * G * 0.25)


def test_acceleration_beside_the_centre_is_the_mean_where_a_body_hits() -> None:
    scene = stark.Scene()
    scene.add_box((4, 4, 0.1), motion="fixed", position=(0, 0, -0.05))
    box = scene.add_box((0.2, 0.1, 0.1), mass=1.0, position=(0, 0, 0.3), angular_velocity=(0, 0.5, 0))
    sim = stark.Simulation(scene, time_step=0.003, time={"integrator": "bdf2"})
    place = np.array([0.1, 0.0, 0.0])

    def velocity() -> np.ndarray:
        return box.velocity + np.cross(box.angular_velocity, box.rotation @ place)

    hits, before = 0, velocity()
    for report in sim.run(until=0.24):
        now = velocity()
        if report.contact_count and report.lasting_contact == 0.0:
            hits += 1
            mean = (now - before) / report.time_step
            assert box.acceleration(place) == pytest.approx(mean, abs=0.01 * np.linalg.norm(mean) + 0.1)
        before = now
    assert hits >= 4
