"""Equilibria in load steps, without inertia, against closed forms: a truss that snaps through, an arm that a
servo holds, a rope that is pulled over a drum, a plug that is pressed into a ring."""

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


def ring_of(inner: float, outer: float, height: float, around: int, across: int, up: int) -> stark.SolidMesh:
    angle = 2.0 * np.pi * np.arange(around) / around
    radius, z = np.linspace(inner, outer, across + 1), np.linspace(0.0, height, up + 1)
    number = np.arange((up + 1) * (across + 1) * around).reshape(up + 1, across + 1, around)
    Z, R, A = np.meshgrid(z, radius, angle, indexing="ij")
    vertices = np.stack([R * np.cos(A), R * np.sin(A), Z], axis=-1).reshape(-1, 3)
    here, ahead = number, np.roll(number, -1, axis=2)
    lower = [here[:-1, :-1], here[:-1, 1:], ahead[:-1, 1:], ahead[:-1, :-1]]
    upper = [here[1:, :-1], here[1:, 1:], ahead[1:, 1:], ahead[1:, :-1]]
    return stark.SolidMesh(vertices, np.stack(lower + upper, axis=-1).reshape(-1, 8))


def turned(profile: list[tuple[float, float]], around: int) -> stark.TriangleMesh:
    """The closed surface of a profile of radii and heights, from the axis to the axis."""
    angle = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    vertices = [(0.0, 0.0, profile[0][1])]
    for radius, z in profile[1:-1]:
        wide = radius / np.cos(np.pi / around)  # its flat sides have the radius
        vertices += [(wide * np.cos(a), wide * np.sin(a), z) for a in angle]
    vertices.append((0.0, 0.0, profile[-1][1]))
    triangles = []
    for i in range(around):
        j = (i + 1) % around
        triangles += [
            (0, 1 + j, 1 + i),
            (len(vertices) - 1, len(vertices) - 1 - around + i, len(vertices) - 1 - around + j),
        ]
        for k in range(len(profile) - 3):
            a, b, c, d = (
                1 + k * around + i,
                1 + k * around + j,
                1 + (k + 1) * around + j,
                1 + (k + 1) * around + i,
            )
            triangles += [(a, b, c), (a, c, d)]
    return stark.TriangleMesh(np.array(vertices), np.array(triangles))


def test_a_plug_is_pressed_into_a_ring() -> None:
    """Lamé's ring under the pressure p on its inner side, whose radius grows by u:
    p = E u/r / ((R² + r²)/(R² − r²) + ν), and the force that pushes the plug on is µ p 2 π r h."""
    inner, outer, height, youngs_modulus, friction = 0.05, 0.08, 0.02, 1e7, 0.2
    scene = stark.Scene()
    scene.default_friction = friction
    mesh = ring_of(inner, outer, height, 48, 3, 4)
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=youngs_modulus, poissons_ratio=0.3)
    ring = scene.add_solid(mesh, rubber, self_contact=False, contact_distance=2e-4)
    scene.add_rollers(ring.vertices[mesh.vertices[:, 2] < 1e-9], (0, 0, 1))  # free in the plane
    cone = [(0.0, -0.05), (inner - 2e-3, -0.05), (inner + 5e-4, -0.01), (inner + 5e-4, 0.04), (0.0, 0.04)]
    plug = scene.add_rigid(turned(cone, 96), motion="scripted", position=(0, 0, 0.071), contact_distance=2e-4)
    plug.follow(position=lambda t: (0.0, 0.0, 0.071 - 0.065 * t))
    sim = stark.Simulation(scene, time_step=0.1, **AT_REST)
    for report in sim.run(until=1.0):
        assert not report.failed, report.message
    touch = np.linalg.norm(sim.contacts.of("rigid", "solid").normal_forces[:, :2], axis=1).sum()
    at_middle = (np.hypot(*mesh.vertices[:, :2].T) < inner + 1e-9) & (abs(mesh.vertices[:, 2] - 0.01) < 1e-9)
    growth = np.hypot(*ring.positions[at_middle, :2].T).mean() - inner
    compliance = (outer**2 + inner**2) / (outer**2 - inner**2) + 0.3
    pressure = youngs_modulus * growth / inner / compliance
    push = -plug.holding_force[2]
    shares = [touch / (pressure * 2.0 * np.pi * inner * height), push / (friction * touch)]
    validate("load_steps.press_fit", shares)
