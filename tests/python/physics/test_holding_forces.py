"""Forces that hold pins, clamps, fixed and scripted bodies: statics, Newton's law, what rods transmit."""

from __future__ import annotations

import numpy as np
import pytest
from _helpers import G

import stark

TIGHT = {"newton.acceleration_tolerance": 1e-8, "newton.step_tolerance": 1e-9}


def test_pins_of_a_hanging_cloth_carry_its_weight() -> None:
    scene = stark.Scene()
    material = stark.materials.cotton.replace(mass_damping=20.0)
    cloth = scene.add_cloth(stark.mesh.grid(0.3, 0.3, cells=8), material, pins=[0, 8])
    sim = stark.Simulation(scene, TIGHT, time_step=0.02)
    sim.run_until(4.0)
    forces = cloth.pin_forces
    assert forces.shape == (2, 3)
    assert forces.sum(axis=0) == pytest.approx((0.0, 0.0, cloth.mass * G), abs=2e-4 * cloth.mass * G)
    assert forces[0, 2] == pytest.approx(forces[1, 2], rel=0.05)  # the diagonals of the mesh lean to one side
    sim.reset()
    assert (cloth.pin_forces == 0.0).all()  # sensors have nothing to tell before the next step


def test_a_clamp_takes_force_and_moment_of_a_load() -> None:
    scene = stark.Scene()
    material = stark.RodMaterial(density=1000.0, youngs_modulus=1e9, radius=0.005)
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.4, 0, 0), segments=16), material, clamps=[0])
    scene.add_force(rod.vertices[[16]], (0.0, 0.3, -0.5))
    sim = stark.Simulation(scene, {**TIGHT, "time.integrator": "quasistatic"})
    sim.step()
    sim.step()
    lengths = np.full(16, 0.025)
    masses = rod.mass / 0.4 * 0.5 * (np.append(lengths, 0) + np.append(0, lengths))
    loads = masses[:, None] * (0.0, 0.0, -G)
    loads[16] += (0.0, 0.3, -0.5)
    assert rod.pin_forces[0] == pytest.approx(-loads.sum(axis=0), abs=1e-6)
    moment = np.cross(rod.positions - rod.positions[0], loads).sum(axis=0)
    assert rod.clamp_torques[0] == pytest.approx(-moment, abs=1e-6)


def test_sections_of_a_rod_carry_what_is_beyond_them() -> None:
    """A curved cantilever under its weight and a load."""
    angles = np.linspace(0.0, 1.5, 21)
    points = 0.3 * np.column_stack((np.sin(angles), 0.0 * angles, 1.0 - np.cos(angles)))
    scene = stark.Scene()
    material = stark.RodMaterial(density=1000.0, youngs_modulus=1e9, radius=0.005, strain_damping=0.1)
    rod = scene.add_rod(points, material, clamps=[0])
    scene.add_force(rod.vertices[[20]], (0.0, 0.3, -0.5))
    sim = stark.Simulation(scene, {**TIGHT, "time.integrator": "quasistatic"})
    assert not rod.section_forces.any()
    sim.step()
    sim.step()
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    masses = rod.mass / lengths.sum() * 0.5 * (np.append(lengths, 0) + np.append(0, lengths))
    loads = masses[:, None] * (0.0, 0.0, -G)
    loads[20] += (0.0, 0.3, -0.5)
    x = rod.positions
    for e in (0, 7, 19):
        beyond = slice(e + 1, None)
        arms = x[beyond] - 0.5 * (x[e] + x[e + 1])
        assert rod.section_forces[e] == pytest.approx(loads[beyond].sum(axis=0), abs=1e-6)
        assert rod.section_moments[e] == pytest.approx(np.cross(arms, loads[beyond]).sum(axis=0), abs=1e-6)
    along = (x[1] - x[0]) / np.linalg.norm(x[1] - x[0])
    assert rod.tensions[0] == pytest.approx(loads[1:].sum(axis=0) @ along, abs=1e-6)


def test_pins_that_move_accelerate_what_hangs_on_them_and_themselves() -> None:
    """Sum of the forces: rate of the momentum of all masses, exact for implicit Euler, less the weight."""
    scene = stark.Scene()
    material = stark.RodMaterial(density=1000.0, youngs_modulus=1e6, radius=0.004, mass_damping=0.0)
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.3, 0, 0), segments=10), material, pins=[0])
    rod.follow(displacement=lambda t: (0.05 * np.sin(9 * t), 0.0, 0.03 * np.sin(5 * t)))
    sim = stark.Simulation(scene, TIGHT, time_step=0.01)
    masses = np.full(11, rod.mass / 10)
    masses[[0, 10]] *= 0.5
    sim.run_until(0.2)
    before = masses @ rod.velocities
    for report in sim.run(until=0.4):
        after = masses @ rod.velocities
        rate = (after - before) / report.time_step + np.array((0.0, 0.0, rod.mass * G))
        assert rod.pin_forces[0] == pytest.approx(rate, abs=1e-6)
        before = after


def test_a_press_and_its_table() -> None:
    scene = stark.Scene()
    scene.default_friction = 0.3
    table = scene.add_box((1.0, 1.0, 0.1), motion="fixed", position=(0, 0, -0.05))
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e5, mass_damping=20.0)
    block = scene.add_solid(stark.mesh.tet_box(0.1, cells=3), rubber, position=(0, 0, 0.052))
    press = scene.add_box((0.2, 0.2, 0.02), motion="scripted", position=(0.02, 0, 0.116))
    press.follow(position=stark.motion.linear([0.0, 0.2], [(0.02, 0, 0.116), (0.02, 0, 0.106)]))
    sim = stark.Simulation(scene, TIGHT, time_step=0.01)
    sim.run_until(1.0)
    weight = block.mass * G
    assert press.holding_force[2] < -5.0  # pushes down
    assert press.holding_force == pytest.approx(-press.contact_force, abs=1e-6)
    assert table.holding_force[2] == pytest.approx(weight - press.holding_force[2], rel=1e-3)
    # The block is under the origin of the table, and beside that of the press.
    assert press.holding_torque == pytest.approx(-press.contact_torque, abs=1e-6)
    assert press.holding_torque[1] == pytest.approx(0.02 * press.holding_force[2], rel=0.02)


def test_a_bracket_takes_what_its_hinge_gives() -> None:
    scene = stark.Scene()
    base = scene.add_box(0.1, motion="fixed", position=(0.0, 0.0, 1.0))
    arm = scene.add_box((0.4, 0.05, 0.05), mass=0.5, position=(0.3, 0.0, 1.0))
    hinge = scene.add_hinge(base, arm, anchor=(0.1, 0.0, 1.0), axis=(0.0, -1.0, 0.0))
    servo = hinge.add_servo(0.2, stiffness=100.0, damping=10.0, cap=50.0)
    sim = stark.Simulation(scene, TIGHT, time_step=0.01)
    sim.run_until(3.0)
    assert base.holding_force == pytest.approx((0.0, 0.0, 0.5 * G), abs=1e-6)
    assert base.holding_force == pytest.approx(hinge.reaction.force, abs=1e-6)
    lever = arm.position[0]  # from the origin of the base
    assert base.holding_torque == pytest.approx((0.0, -lever * 0.5 * G, 0.0), abs=1e-6)
    assert servo.torque == pytest.approx(0.5 * G * (lever - 0.1), rel=1e-6)
    assert list(arm.holding_force) == [0.0, 0.0, 0.0]  # it moves freely


def test_a_gripper_carries_what_is_attached_to_it() -> None:
    scene = stark.Scene()
    gripper = scene.add_box((0.02, 0.3, 0.02), motion="scripted", position=(0.0, 0.0, 0.0))
    material = stark.materials.cotton.replace(mass_damping=20.0)
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=6), material, position=(0.111, 0.0, 0.0))
    edge = np.flatnonzero(cloth.mesh.vertices[:, 0] < -0.0999)
    glue = scene.attach(cloth.vertices[edge], gripper)
    sim = stark.Simulation(scene, TIGHT, time_step=0.02)
    sim.run_until(3.0)
    assert gripper.holding_force[2] == pytest.approx(cloth.mass * G, rel=1e-3)
    assert gripper.holding_force - glue.force == pytest.approx((0, 0, 0), abs=1e-3 * cloth.mass * G)


@pytest.mark.parametrize("kind", ["tetrahedra", "quadratic", "hexahedra"])
def test_pins_of_solids(kind: str) -> None:
    mesh = {
        "tetrahedra": stark.mesh.tet_box((0.2, 0.05, 0.05), (4, 1, 1)),
        "quadratic": stark.mesh.to_quadratic(stark.mesh.tet_box((0.2, 0.05, 0.05), (4, 1, 1))),
        "hexahedra": stark.mesh.box_hexahedra((0.2, 0.05, 0.05), (4, 1, 1)),
    }[kind]
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e6)
    beam = scene.add_solid(mesh, rubber, pins=mesh.vertices[:, 0] < -0.0999)
    sim = stark.Simulation(scene, {**TIGHT, "time.integrator": "quasistatic"})
    sim.step()
    sim.step()
    forces = beam.pin_forces
    assert forces.sum(axis=0) == pytest.approx((0.0, 0.0, beam.mass * G), abs=1e-4)
    arms = beam.positions[beam.pins]
    moment = np.cross(arms, forces).sum(axis=0)  # about the middle, where the weight acts
    assert moment == pytest.approx((0.0, 0.0, 0.0), abs=2e-3 * 0.1 * beam.mass * G)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_pins_pull_their_vertices_against_mass_damping(integrator: str) -> None:
    """Bodies that are pinned as a whole and speed up: M (a + d v) and the weight. The part d v was left out,
    a third of the force on this sheet."""
    scene = stark.Scene()
    sheet = scene.add_cloth(
        stark.mesh.grid(1.0, 1.0, cells=1), stark.ShellMaterial(density=1.0, mass_damping=2.0), pins=range(4)
    )
    sheet.add_fibres(stark.RodMaterial(radius=0.005, mass_damping=3.0), paths=[[0, 1]], bending=False)
    line = stark.mesh.polyline((0, 0, 1), (1, 0, 1), segments=2)
    rod = scene.add_rod(line, stark.RodMaterial(radius=0.01, mass_damping=4.0), pins=range(3))
    sim = stark.Simulation(scene, TIGHT, time_step=1e-3, time={"integrator": integrator})
    rates = ((sheet, [(1.0, 2.0), (sheet.mass - 1.0, 3.0)]), (rod, [(rod.mass, 4.0)]))
    for body, _ in rates:
        body.follow(displacement=lambda t: (t * t, 0.0, 0.0))  # 2 m/s^2
    sim.run_until(0.3)
    for body, parts in rates:
        force = sum(mass * (2.0 + damping * 0.6) for mass, damping in parts)
        assert body.pin_forces.sum(axis=0) == pytest.approx((force, 0.0, body.mass * G), rel=2e-3, abs=1e-6)
