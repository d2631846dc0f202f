"""Every built-in joint under a force and a torque in all directions: it carries what it holds, and lets go
what it does not (V19)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from _mechanisms import simulate
from _validation import validate

import stark

X, Y, Z = np.eye(3)
NONE, ALL = np.zeros((3, 3)), np.eye(3)
AXIS = np.outer(Z, Z)
ACROSS = ALL - AXIS
ORIGIN = (0.0, 0.0, 0.0)
Add = Callable[[stark.Scene, stark.RigidBody, stark.RigidBody], stark.Joint]

# How to add it, then the forces and the torques that it holds, as projections.
KINDS: dict[str, tuple[Add, np.ndarray, np.ndarray]] = {
    "fixed": (lambda s, a, b: s.add_fixed(a, b), ALL, ALL),
    "ball": (lambda s, a, b: s.add_ball(a, b, anchor=ORIGIN), ALL, NONE),
    "hinge": (lambda s, a, b: s.add_hinge(a, b, anchor=ORIGIN, axis=Z), ALL, ACROSS),
    "slider": (lambda s, a, b: s.add_slider(a, b, anchor=ORIGIN, axis=Z), ACROSS, ALL),
    "cylindrical": (lambda s, a, b: s.add_cylindrical(a, b, anchor=ORIGIN, axis=Z), ACROSS, ACROSS),
    "universal": (lambda s, a, b: s.add_universal(a, b, anchor=ORIGIN, axis_a=X, axis_b=Y), ALL, AXIS),
    "planar": (lambda s, a, b: s.add_planar(a, b, anchor=ORIGIN, normal=Z), AXIS, ACROSS),
    "point_on_axis": (lambda s, a, b: s.add_point_on_axis(a, b, anchor=ORIGIN, axis=Z), ACROSS, NONE),
    "distance": (lambda s, a, b: s.add_distance(a, b, anchor_a=(0, 0, -1), anchor_b=ORIGIN), AXIS, NONE),
    "direction": (lambda s, a, b: s.add_joint("direction", a, b, anchor=ORIGIN, axis=Z), NONE, ACROSS),
    "orientation": (lambda s, a, b: s.add_joint("orientation", a, b, anchor=ORIGIN, axis=Z), NONE, ALL),
}
FORCE = np.array([300.0, -200.0, 500.0])  # [N]
TORQUE = np.array([20.0, 30.0, -40.0])  # [N m]
MASS, INERTIA = 100.0, 100.0  # [kg], [kg m^2]
STEP, STEPS = 1e-3, 10  # [s]: bodies turn by less than 1e-5 rad, so directions stay


@stark.energy
def wrench(f: stark.Frame, h: stark.TimeStep, force: stark.Vec3, torque: stark.Vec3):
    """A constant force on the origin and a constant torque."""
    return -(force @ f.origin) - h * (torque @ f.angular_velocity)


def relative(error: np.ndarray, load: np.ndarray) -> float:
    return float(np.linalg.norm(error) / np.linalg.norm(load))


@pytest.mark.parametrize("kind", KINDS)
def test_joint_carries_what_it_holds(kind: str) -> None:
    add, held_force, held_torque = KINDS[kind]
    scene = stark.Scene()
    inertia = (MASS, ORIGIN, INERTIA * np.eye(3))
    a, b = scene.add_box(0.2, inertia=inertia), scene.add_box(0.2, inertia=inertia)
    weld = scene.add_fixed(None, a)
    joint = add(scene, a, b)
    assert joint.kind == kind
    scene.add(wrench(b, force=FORCE, torque=TORQUE))
    sim = simulate(scene, STEP, gravity=ORIGIN)
    for report in sim.run(STEPS * STEP):
        assert report.status == "accepted", report.message
        assert np.all(np.abs(joint.residuals) < 1e-6)  # the tolerance of lengths, which is the smaller one

    force, torque = held_force @ FORCE, held_torque @ TORQUE
    lever = np.cross(b.position, force)
    errors = [
        relative(joint.reaction.force + force, FORCE),
        relative(joint.reaction.torque + torque, TORQUE),
        # The weld behind it feels the same, about an origin that stays.
        relative(weld.reaction.force + force, FORCE),
        relative(weld.reaction.torque + torque + lever, TORQUE),
    ]
    validate(f"V19.{kind}", max(errors))
    free_velocity = (FORCE - force) * sim.time / MASS
    free_spin = (TORQUE - torque) * sim.time / INERTIA
    assert relative(b.velocity - free_velocity, FORCE * sim.time / MASS) < 1e-3
    assert relative(b.angular_velocity - free_spin, TORQUE * sim.time / INERTIA) < 1e-3


def test_every_built_in_joint_is_loaded() -> None:
    assert set(KINDS) == set(stark._core.joint_names()) - {"span", "tilt"}  # these hold nothing
