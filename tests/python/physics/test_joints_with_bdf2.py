"""Joints with bdf2: rates where the step changes, and no pull of what has let go."""

from __future__ import annotations

import numpy as np
import pytest

import stark


def test_rates_are_those_of_the_body_in_steps_of_any_length() -> None:
    """They came out 40 % off in a step that was cut, and in those after it."""
    scene = stark.Scene()
    arm = scene.add_box((0.4, 0.05, 0.05), mass=1.0, position=(0.2, 0, 0))
    hinge = scene.add_hinge(None, arm, anchor=(0, 0, 0), axis=(0, 0, 1))
    hinge.add_effort(1.0)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), time={"integrator": "bdf2"})
    for end in (0.1, 0.104, 0.11, 0.1125, 0.12):
        sim.run_until(end)
        assert hinge.rates["angle"] == pytest.approx(arm.angular_velocity[2], rel=1e-6), end


@pytest.mark.parametrize("how", ["joint", "attachment", "break"])
@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_what_is_let_go_from_a_circle_flies_off_along_the_tangent(integrator: str, how: str) -> None:
    """With bdf2 it turned by half a step of the circle, 0.05 rad here, and got faster."""
    scene = stark.Scene()
    arm = scene.add_box((0.5, 0.04, 0.04), mass=1.0, position=(0.25, 0, 0))
    ball = scene.add_sphere(0.03, mass=0.1, position=(0.5, 0, 0))
    scene.disable_contact(arm, ball)
    hinge = scene.add_hinge(None, arm, anchor=(0, 0, 0), axis=(0, 0, 1))
    motor = hinge.add_motor(10.0, cap=50.0, delta=0.05)
    points = ball.points([(0, 0, 0), (0.01, 0, 0), (0, 0.01, 0)])
    holds: stark.Joint | stark.Attachment
    if how == "attachment":
        holds = scene.attach(points, arm, contact=False)
    else:
        # 5 N of the circle; the motor goes on to 20 rad/s and 20 N.
        holds = scene.add_fixed(arm, ball, anchor=(0.5, 0, 0), break_force=12.0 if how == "break" else 1e6)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), time={"integrator": integrator})
    sim.run_until(0.3)
    if isinstance(holds, stark.Joint) and how == "break":
        motor.target = 20.0
        motor.delta = 20.0
        while not holds.broken:
            sim.step()
    else:
        holds.enabled = False
    velocity, rate = ball.velocity, ball.angular_velocity[2]
    sim.run_until(sim.time + 0.1)
    np.testing.assert_allclose(ball.velocity, velocity, rtol=0, atol=1e-6 * float(np.linalg.norm(velocity)))
    assert ball.angular_velocity[2] == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize("step", [0.01, 0.001])
@pytest.mark.parametrize(
    ("integrator", "power", "shares"),
    [
        ("implicit_euler", 2, [0.5, 1.0, 1.0, 1.0, 1.0]),
        ("bdf2", 2, [1.125, 1.5, 0.875, 1.0, 1.0]),
        ("implicit_euler", 1, [1.0, 0.0, 0.0, 0.0, 0.0]),
        ("bdf2", 1, [2.25, -1.5, 0.25, 0.0, 0.0]),
    ],
)
def test_loads_on_paths_with_kinks_show_what_the_guide_says(
    integrator: str, power: int, shares: list[float], step: float
) -> None:
    """docs/sensors.md: shares of m a where the acceleration jumps, of m v/h where the speed does."""
    jump, mass, start = 2.4, 2.0, 0.05
    scene = stark.Scene()
    tool = scene.add_box(0.05, motion="scripted", position=(0, 0, 0.2))
    tool.follow(position=lambda t: (0, 0, 0.2 + jump * max(0.0, t - start) ** power / power))
    load = scene.add_box(0.1, mass=mass, position=(0, 0, 0.05))
    grip = scene.add_fixed(tool, load, anchor=(0, 0, 0.1))
    sim = stark.Simulation(scene, time_step=step, time={"integrator": integrator})
    sim.run_until(start)
    whole = mass * jump if power == 2 else mass * jump / step
    for share in shares:
        assert not sim.step().failed
        assert (grip.reaction.force[2] - 9.81 * mass) / whole == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize("kind", ["ball", "hinge", "attachment"])
def test_impacts_on_jointed_bodies_keep_the_momentum(kind: str) -> None:
    """Joints carried other shares of an impact on at their two sides: 7e-5 of 0.15 N s appeared within two
    steps."""
    scene = stark.Scene()
    left = scene.add_box((0.1, 0.05, 0.02), mass=0.2)
    right = scene.add_box((0.1, 0.05, 0.02), mass=0.1, position=(0.12, 0, 0))
    scene.add_sphere(0.02, mass=0.15, position=(0.13, 0.01, 0.1), velocity=(0.1, 0, -1.0))
    if kind == "ball":
        scene.add_ball(left, right, anchor=(0.06, 0, 0))
    elif kind == "hinge":
        scene.add_hinge(left, right, anchor=(0.06, 0, 0), axis="y")
    else:
        scene.attach(left.points([(0.06, 0, 0), (0.06, 0.02, 0)]), right)
    sim = stark.Simulation(scene, time_step=0.0005, gravity=(0, 0, 0), time={"integrator": "bdf2"})
    momentum = np.array([report.momentum for report in sim.run(until=0.15)])
    assert right.velocity[2] < -0.1  # the ball has hit it
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-11)
