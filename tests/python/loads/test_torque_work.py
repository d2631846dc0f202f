"""Energy balance of torques: what acts on axes of a body works along its turn, not along chords."""

from __future__ import annotations

import pytest

import stark


@pytest.mark.parametrize("turn", [0.1, 0.5, 0.8])
def test_a_torque_works_by_the_angle(turn: float) -> None:
    """Against a spring, in one step without inertia: nothing is damped."""
    scene = stark.Scene()
    box = scene.add_box((0.3, 0.1, 0.1), mass=1.0)
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 0, 1))
    hinge.add_spring(stiffness=10.0)
    scene.add_torque(box, (0, 0, 10.0 * turn))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), settings={"time.integrator": "quasistatic"})
    energy = sim.step().energy
    assert hinge.coordinates["angle"] == pytest.approx(turn, rel=1e-6)
    assert energy["external"] == pytest.approx(10.0 * turn**2, rel=1e-6)
    assert energy["damping"] == pytest.approx(0.0, abs=1e-7)


def test_a_free_box_that_a_torque_turns_loses_nothing_to_damping() -> None:
    scene = stark.Scene()
    box = scene.add_box((0.3, 0.2, 0.1), mass=1.0)
    scene.add_torque(box, (0.1, 0.0, 0.2))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), time_step=0.02)
    damped = work = 0.0
    for report in sim.run(1.0):
        damped += report.energy["damping"]
        work += report.energy["external"]
    assert work > 1.0
    assert abs(damped) < 1e-6 * work
