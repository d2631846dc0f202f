"""Mobile bases that turn by the difference of their wheels, against plane kinematics and statics."""

from __future__ import annotations

import numpy as np
import pytest

import stark

RADIUS = 0.06  # [m] of the wheels


def yaw(body: stark.RigidBody) -> float:
    return float(np.arctan2(body.rotation[1, 0], body.rotation[0, 0]))


def turn_over_odometry(width: float, stacks: int) -> float:
    """Of a base on two driven wheels and a ball without friction: how far it turns in a second over what the
    angles of its wheels say."""
    scene = stark.Scene()
    scene.default_friction = 0.7
    scene.add_floor(6.0, name="floor")
    base = scene.add_box((0.3, 0.2, 0.06), mass=4.0, position=(0, 0, 0.0505))
    ball = scene.add_sphere(0.015, mass=0.01, position=(-0.12, 0, 0.0155), name="ball")
    scene.add_fixed(base, ball)
    scene.friction["ball", "floor"] = 0.0
    track, axles = 0.26, []
    for side, rate in ((1.0, 4.0), (-1.0, 6.0)):
        wheel = scene.add_rigid(
            stark.mesh.cylinder(RADIUS, width, stacks=stacks),
            mass=0.3,
            position=(0.08, side * track / 2, RADIUS + 5e-4),
            rotation=stark.rotation(axis="x", angle=-0.5 * np.pi),
        )
        axles.append(scene.add_hinge(base, wheel, anchor=wheel.position, axis=(0, 1, 0)))
        axles[-1].add_motor(rate, cap=5.0, delta=0.05)
    sim = stark.Simulation(scene, time_step=0.005, contact_distance=5e-4)
    sim.run_until(0.5)
    before, angles = yaw(base), [axle.angle for axle in axles]
    sim.run_until(1.5)
    left, right = (axle.angle - angle for axle, angle in zip(axles, angles, strict=True))
    return (yaw(base) - before) * track / (RADIUS * (right - left))


@pytest.mark.parametrize(
    ("width", "stacks", "least", "most"),
    [(0.004, 1, 0.996, 1.001), (0.02, 2, 0.985, 1.0), (0.02, 1, 0.95, 0.98)],
)
def test_narrow_wheels_turn_a_base_as_odometry_says(
    width: float, stacks: int, least: float, most: float
) -> None:
    """Wide ones turn it less: their two rims carry all of the weight (docs/friction.md)."""
    assert least < turn_over_odometry(width, stacks) < most


@pytest.mark.parametrize(("left", "right"), [(-5.0, 5.0), (3.0, 6.0)])
def test_skid_steering_turns_as_coulomb_friction_balances(left: float, right: float) -> None:
    """Four wheels at (±a, ±b) that all slip: friction is against the slip, its moment about the middle is
    zero where the rate is w = v b/(a² + b²), with half of the difference v of the speeds of the rims."""
    scene = stark.Scene()
    scene.default_friction = 0.6
    scene.add_floor(6.0)
    base = scene.add_box((0.4, 0.25, 0.08), mass=4.0, position=(0, 0, 0.09))
    a, b = 0.13, 0.16
    for x, y in ((a, b), (a, -b), (-a, b), (-a, -b)):
        place = (x, y, RADIUS + 5e-4)
        wheel = scene.add_sphere(RADIUS, mass=0.3, position=place)
        axle = scene.add_hinge(base, wheel, anchor=place, axis=(0, 1, 0))
        axle.add_motor(left if y > 0 else right, cap=5.0, delta=0.05)
    sim = stark.Simulation(scene, time_step=0.005, contact_distance=1e-3)
    sim.run_until(0.5)
    before = yaw(base)
    sim.run_until(1.5)
    expected = 0.5 * RADIUS * (right - left) * b / (a**2 + b**2)
    assert yaw(base) - before == pytest.approx(expected, rel=0.01)
