"""A bicycle that steers itself, against the linear equations of motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import stark

Floats = np.ndarray[Any, np.dtype[np.float64]]
G, SPEED, PUSH = 9.81, 5.0, 0.05  # [m/s^2], [m/s], first rate of lean [rad/s]
BASE, TRAIL, TILT = 1.02, 0.08, np.pi / 10  # wheel base [m], trail [m], of the steering axis [rad]


def linear(times: Floats) -> Floats:
    """Lean and steer (n, 2) of the benchmark bicycle of J. P. Meijaard, J. M. Papadopoulos, A. Ruina and
    A. L. Schwab, Linearized dynamics equations for the balance and steer of a bicycle (2007), table 1 and
    equation 5.3: M q'' + v C1 q' + (g K0 + v^2 K2) q = 0."""
    mass = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
    stiffness = G * np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
    stiffness += SPEED**2 * np.array([[0, 76.59734589573222], [0, 2.65431523794604]])
    damping = SPEED * np.array([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
    system = np.zeros((4, 4))
    system[:2, 2:] = np.eye(2)
    system[2:] = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    return np.array([(expm(system * t) @ [0.0, 0.0, PUSH, 0.0])[:2] for t in times])


def sharp_wheel(radius: float, count: int) -> stark.TriangleMesh:
    """Two flat cones, base to base, about the y axis."""
    angle = np.arange(count) * 2 * np.pi / count
    rim = np.column_stack([radius * np.cos(angle), 0 * angle, radius * np.sin(angle)])
    i = np.arange(count)
    j, left, right = (i + 1) % count, np.full(count, count), np.full(count, count + 1)
    cones = [np.column_stack([j, i, left]), np.column_stack([i, j, right])]
    return stark.TriangleMesh(np.vstack([rim, [[0, 0.01, 0], [0, -0.01, 0]]]), np.vstack(cones))


def bicycle(distance: float, yaw: float, side: float) -> tuple[stark.Scene, stark.RigidBody, stark.Joint]:
    """Rolls along x, turned by the yaw, and begins to fall to a side: its frame and its steering."""
    scene = stark.Scene()
    scene.default_friction = 1.0
    scene.add_floor(20.0)
    turn = stark.rotation(axis="z", angle=yaw)
    lift = np.array([0, 0, 0.9 * distance])
    rate, forward = np.array([side * PUSH, 0, 0]), np.array([SPEED, 0, 0])

    def add(mesh: Any, mass: float, place: tuple[float, ...], inertia: Any, spin: float) -> stark.RigidBody:
        xx, yy, zz, xz = inertia
        tensor = np.array([[xx, 0, -xz], [0, yy, 0], [-xz, 0, zz]])  # theirs has its z axis down
        return scene.add_rigid(
            mesh,
            inertia=(mass, (0, 0, 0), tensor),
            position=turn @ (place + lift),
            rotation=turn,
            velocity=turn @ (np.cross(rate, place) + forward),
            angular_velocity=turn @ (rate + np.array([0, spin, 0])),
        )

    cube = stark.mesh.box(0.02)
    frame = add(cube, 85, (0.3, 0, 0.9), (9.2, 11, 2.8, 2.4), 0)
    fork = add(cube, 4, (0.9, 0, 0.7), (0.05892, 0.06, 0.00708, -0.00756), 0)
    rear = add(sharp_wheel(0.3, 720), 2, (0, 0, 0.3), (0.0603, 0.12, 0.0603, 0), SPEED / 0.3)
    front = add(sharp_wheel(0.35, 720), 3, (BASE, 0, 0.35), (0.1405, 0.28, 0.1405, 0), SPEED / 0.35)
    for wheel in (rear, front):
        scene.disable_contact(wheel, frame)
        scene.disable_contact(wheel, fork)
    scene.add_hinge(frame, rear, anchor=rear.position, axis=turn @ (0, 1, 0))
    scene.add_hinge(fork, front, anchor=front.position, axis=turn @ (0, 1, 0))
    place = (BASE + TRAIL - 0.8 * np.sin(TILT), 0, 0.8 * np.cos(TILT))
    steering = scene.add_hinge(
        frame, fork, anchor=turn @ (place + lift), axis=turn @ (-np.sin(TILT), 0, np.cos(TILT))
    )
    return scene, frame, steering


def errors(integrator: str, stick_velocity: float, yaw: float = 0.0, side: float = 1.0) -> Floats:
    """Largest ones of lean and steer in the first second, over the largest lean and steer."""
    distance = 1e-4
    scene, frame, steering = bicycle(distance, yaw, side)
    settings = {"time.integrator": integrator, "contact.stick_velocity": stick_velocity}
    sim = stark.Simulation(scene, settings, time_step=0.002, contact_distance=distance / 2)
    times, found = [], []
    for report in sim.run(1.0):
        assert not report.failed
        times.append(report.time)
        found.append([side * np.arcsin(frame.rotation[2, 1]), -side * steering.angle])
    expected = linear(np.array(times))
    return np.asarray(abs(np.array(found) - expected).max(axis=0) / abs(expected).max(axis=0))


@pytest.mark.parametrize(
    ("integrator", "yaw", "side"), [("implicit_euler", 0.0, 1.0), ("bdf2", 0.0, 1.0), ("bdf2", 0.7, -1.0)]
)
def test_a_bicycle_balances_itself_as_the_linear_theory_says(
    integrator: str, yaw: float, side: float
) -> None:
    """With soft bristles, as docs/friction.md says."""
    assert errors(integrator, 0.1, yaw, side) == pytest.approx([0.0, 0.0], abs=0.03)


def test_stiff_bristles_hold_its_wheels_against_turning() -> None:
    """The limit that docs/friction.md names: those of the default make it lean twice as far."""
    assert errors("bdf2", 1e-3)[0] > 0.5
