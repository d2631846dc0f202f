"""Equilibria in load steps, without inertia, against closed forms: a truss that snaps through, an arm that a
servo holds, a rope that is pulled over a drum."""

from __future__ import annotations

from typing import Any

import numpy as np
from _validation import validate

import stark

AT_REST: dict[str, Any] = {"time.integrator": "quasistatic", "gravity": (0, 0, 0)}


def test_a_truss_snaps_through_under_its_apex() -> None:
    """Two bars of von Mises; the force falls, turns around and rises again."""
    span, rise, steps = 1.0, 0.1, 24  # [m] of one bar; its apex goes down by twice the rise
    material = stark.RodMaterial(density=1000.0, youngs_modulus=1e7, radius=0.01)
    length, stiffness = np.hypot(span, rise), 1e7 * np.pi * 0.01**2
    scene = stark.Scene()
    lines = [np.array([(side * span, 0, 0), (0, 0, rise)]) for side in (-1.0, 1.0)]
    bars = [scene.add_rod(line, material, pins=[0, 1], contact_distance=1e-4) for line in lines]
    scene.disable_contact(*bars)
    for bar in bars:
        bar.follow(displacement=lambda t: (0.0, 0.0, -2.0 * rise * t), vertices=[1])
    sim = stark.Simulation(scene, time_step=1.0 / steps, **AT_REST)
    errors, forces = [], []
    for _ in sim.run(until=1.0):
        height = rise * (1.0 - 2.0 * sim.time)
        now = np.hypot(span, height)
        forces.append(2.0 * stiffness * (now / length - 1.0) * height / now)
        errors.append(sum(bar.pin_forces[1][2] for bar in bars) - forces[-1])
    assert min(forces) < 0.0 < max(forces)
    validate("load_steps.truss", np.abs(errors).max() / np.abs(forces).max())


def test_a_servo_holds_an_arm_far_below_its_target() -> None:
    """k θ = −m g L/2 cos θ"""
    angles, expected = [], []
    for stiffness in (1e4, 50.0, 5.0, 1.5):
        scene = stark.Scene()
        arm = scene.add_box((0.3, 0.02, 0.02), mass=1.0, position=(0.15, 0, 0))
        hinge = scene.add_hinge(None, arm, anchor=(0, 0, 0), axis=(0, -1, 0))
        hinge.add_servo(target=0.0, stiffness=stiffness, damping=1.0, cap=100.0)
        sim = stark.Simulation(scene, **(AT_REST | {"gravity": (0, 0, -9.81)}))
        assert not sim.step().failed
        angles.append(hinge.coordinates["angle"])
        low, high = -0.5 * np.pi, 0.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            if stiffness * middle + 0.15 * 9.81 * np.cos(middle) > 0.0:
                high = middle
            else:
                low = middle
        expected.append(middle)
    validate("load_steps.servo", np.abs(np.array(angles) - expected).max())


def pulled_over_a_drum(friction: float) -> float:
    """Ratio of the tensions of a rope that slips on half of a drum."""
    radius, segments, tail, steps = 0.102, 120, 6, 40  # [m] of the centre line
    scene = stark.Scene()
    scene.default_friction = friction
    drum = stark.mesh.cylinder(0.1, 0.1, 96)
    scene.add_rigid(drum, motion="fixed", rotation=stark.rotation(axis="x", angle=0.5 * np.pi))
    angle = np.linspace(np.pi, 0.0, segments + 1)
    arc = radius * np.column_stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)])
    down = np.column_stack([np.full(tail, radius), np.zeros(tail), -0.01 * np.arange(1, tail + 1)])
    points = np.concatenate([(down * (-1, 1, 1))[::-1], arc, down])
    material = stark.RodMaterial(density=1000.0, youngs_modulus=1e7, radius=1e-3)
    rope = scene.add_rod(points, material, pins=[0], contact_distance=1e-3, self_contact=False)
    scene.add_force(rope.vertices[[len(points) - 1]], (0, 0, -1.0))
    rope.follow(displacement=lambda t: (0.0, 0.0, -0.02 * t), vertices=[0])
    sim = stark.Simulation(scene, time_step=1.0 / steps, **AT_REST)
    for report in sim.run(until=1.0):
        assert not report.failed, report.message
    return float(-rope.pin_forces[0][2])


def test_a_rope_slips_on_a_drum() -> None:
    """T₁ = T₂ exp(µ π)"""
    coefficients = (0.1, 0.3)
    ratios = [pulled_over_a_drum(c) / np.exp(c * np.pi) for c in coefficients]
    validate("load_steps.rope", ratios)
