"""Pressure, forces and torques against closed forms, and what is refused."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from _load_scenes import ORIGIN, advance, block_with_a_hole, simulate

import stark
from stark.telemetry import report_to_dict
from stark.verify.telemetry import _imbalance


def volume(body: Any) -> float:
    a, b, c = (body.positions[body.triangles[:, i]] for i in range(3))
    return float(np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0)


def balloon(scene: stark.Scene, position: Any = ORIGIN, flipped: bool = False) -> stark.Cloth:
    mesh = stark.mesh.sphere(0.1, 2)
    rubber = stark.ShellMaterial(
        density=0.5,
        thickness=5e-4,
        youngs_modulus=1e6,
        poissons_ratio=0.4,
        bending_stiffness=0,
        mass_damping=20,
    )
    return scene.add_cloth(mesh.flipped() if flipped else mesh, rubber, position=position)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_balloon_has_the_radius_of_its_membrane_law(flipped: bool) -> None:
    """Work of the pressure p dV = area dW: p = W'(s) A / (3 V s^2) at the stretch s, with the Neo-Hookean
    membrane in plane stress. The polyhedron does not stretch quite evenly: 0.5 % of the stretch."""
    scene = stark.Scene()
    ball = balloon(scene, flipped=flipped)
    inside = scene.add_pressure(ball, 1500.0)
    sim = simulate(scene, 0.05)
    advance(sim, 3.0)
    e, nu, t = 1e6, 0.4, 5e-4
    mu, la = e / (2 * (1 + nu)), e * nu / (1 - nu**2)
    area, rest = ball.mesh.area, abs(ball.mesh.volume)
    s = (abs(volume(ball)) / rest) ** (1 / 3)
    slope = t * (2 * mu * s - 2 * mu / s + 4 * la * np.log(s) / s)
    assert s > 1.1
    assert slope * area / (3 * rest * s**2) == pytest.approx(1500.0, rel=0.02)
    assert inside.energy == pytest.approx(-1500.0 * abs(volume(ball)), rel=1e-9)
    assert np.abs(ball.velocities).max() < 1e-4


def test_pressure_moves_nothing_as_a_whole_and_may_change() -> None:
    """A free balloon far from the origin of the world: its forces sum to zero, so it stays."""
    scene = stark.Scene()
    ball = balloon(scene, position=(30.0, -20.0, 10.0))
    inside = scene.add_pressure(ball, 500.0, name="air")
    sim = simulate(scene)
    advance(sim, 0.2)
    assert np.abs(inside.forces.sum(axis=(0, 1))).max() < 1e-9
    assert ball.positions.mean(axis=0) == pytest.approx((30.0, -20.0, 10.0), abs=1e-9)
    full = volume(ball)
    inside.pressure = 0.0
    advance(sim, 2.0)
    assert volume(ball) == pytest.approx(ball.mesh.volume, rel=1e-4) and full > 1.05 * ball.mesh.volume


def test_a_gas_of_constant_p_v_expands_to_its_equilibrium() -> None:
    """Boyle's law in the loop, one step behind: inside and membrane agree in the end."""
    scene = stark.Scene()
    ball = balloon(scene)
    air = scene.add_pressure(ball, 0.0)
    sim = simulate(scene)
    amount = 1500.0 * ball.mesh.volume
    for _ in range(300):
        air.pressure = amount / volume(ball)
        assert not sim.step().failed
    assert air.pressure * volume(ball) == pytest.approx(amount, rel=1e-6)
    assert volume(ball) > 1.2 * ball.mesh.volume


def test_a_cavity_of_a_solid_is_inflated_whatever_its_orientation() -> None:
    scene = stark.Scene()
    block = scene.add_solid(block_with_a_hole(), stark.materials.soft_rubber, name="block")
    inner = np.abs(block.mesh.vertices[block.triangles]).max(axis=(1, 2)) < 0.051
    assert inner.sum() == 12
    scene.add_pressure(block.faces[inner], 500.0)
    sim = simulate(scene)
    walls = block.mesh.vertices[block.triangles[inner]]
    advance(sim, 0.5)
    moved = block.positions[block.triangles[inner]] - walls
    assert np.einsum("nij,nij->", moved, walls) > 1e-4  # away from the centre


@pytest.mark.parametrize(
    ("surface", "words"),
    [
        (lambda s: s.add_cloth(stark.mesh.grid(1, 1, 2), name="sheet"), r"'sheet'.*not closed at 8 edges"),
        (lambda s: balloon(s).faces[:-1], "not closed at 3 edges, first between the vertices"),
        (lambda s: s.add_box(0.1, mass=1.0), "must be a cloth or a solid with a closed surface"),
        (lambda s: balloon(s).edges, "must be a cloth or a solid with a closed surface"),
        (lambda s: None, "must be a cloth or a solid with a closed surface"),
    ],
)
def test_open_surfaces_are_refused(surface: Any, words: str) -> None:
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match=words):
        scene.add_pressure(surface(scene), 1.0, name="air")
    assert scene.energies == ()


def test_forces_accelerate_points_and_bodies() -> None:
    """v = F t/m, exact in implicit Euler, at the centre of mass, which is not the origin of the mesh."""
    scene = stark.Scene()
    box = scene.add_rigid(stark.mesh.box(0.1).translated((0.2, 0, 0)), mass=2.0)
    push = scene.add_force(box, (0.0, 3.0, 0.0))
    patch = scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), stark.materials.towel, position=(2, 0, 0))
    scene.add_force(patch.vertices, np.full((9, 3), (0.0, 0.0, 1e-3)))
    sim = simulate(scene)
    advance(sim, 0.1)
    assert box.velocity == pytest.approx((0.0, 0.15, 0.0), abs=1e-9)
    assert np.abs(box.angular_velocity).max() < 1e-9
    assert patch.velocities[:, 2].mean() > 0.0
    push.force = (0.0, 0.0, 0.0)
    advance(sim, 0.2)
    assert box.velocity == pytest.approx((0.0, 0.15, 0.0), abs=1e-9)


def test_a_force_beside_the_centre_and_a_torque_turn_alike() -> None:
    """w = M t/I for small angles, within the square of the angle."""
    scene = stark.Scene()
    a = scene.add_box(0.1, mass=1.0)
    b = scene.add_box(0.1, mass=1.0, position=(1, 0, 0))
    scene.add_force(a.points((0.05, 0, 0)), (0, 1e-3, 0))
    scene.add_torque(b, (0, 0, 0.05e-3))
    sim = simulate(scene)
    advance(sim, 0.1)
    expected = 0.05e-3 * 0.1 / a.inertia[2, 2]
    assert a.angular_velocity == pytest.approx((0, 0, expected), rel=1e-3, abs=1e-9)
    assert b.angular_velocity == pytest.approx((0, 0, expected), rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("step", [0.01, 0.02])
def test_a_torque_accelerates_a_wheel_as_long_as_it_acts(step: float) -> None:
    """w = M t/I, also where the wheel turns by 0.8 rad in a step."""
    scene = stark.Scene()
    wheel = scene.add_box(0.1, mass=6.0)
    scene.add_torque(wheel, (0, 0, 1.0))
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0))
    sim.run_until(0.4)
    assert wheel.angular_velocity == pytest.approx((0, 0, 0.4 / wheel.inertia[2, 2]), rel=1e-7, abs=1e-9)


def test_a_torque_at_its_end_bends_a_rod_to_a_half_circle() -> None:
    """In steps of 45 degrees: the tip goes to (0, 2 L/pi), and the clamp holds the torque."""
    stuff = stark.RodMaterial(density=1000.0, youngs_modulus=1e7, poissons_ratio=0.0, radius=0.01)
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 40), stuff, clamps=[0], self_contact=False)
    load = scene.add_torque(rod.frame(-1), (0, 0, 0))
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), time={"integrator": "quasistatic"})
    full = np.pi * stuff.section["bending_stiffness_1"]
    for share in (0.25, 0.5, 0.75, 1.0):
        load.torque = (0, 0, share * full)
        assert not sim.step().failed
    assert rod.positions[-1] == pytest.approx((0.0, 2.0 / np.pi, 0.0), abs=1e-3)
    assert rod.clamp_torques[0] == pytest.approx((0, 0, -full), abs=1e-4 * full)


def test_a_force_beside_a_rod_twists_it_and_one_on_joined_points_is_on_each() -> None:
    """Force times lever is the torque that the clamp holds; a box and the rod get their own forces."""
    cane = stark.RodMaterial(density=500.0, youngs_modulus=1e9, radius=2e-3)
    lever, twist = 0.05, 0.01
    load = cane.section["torsional_stiffness"] * twist / 0.2 / lever
    scene = stark.Scene()
    line = stark.mesh.polyline((0, 0, 0), (0.2, 0, 0), 20)
    rod = scene.add_rod(line, cane, clamps=[0], normal=(0, 0, 1))
    box = scene.add_box(0.1, mass=1.0, motion="fixed", position=(0, 1, 0))
    eyelet = rod.points([20], rod.frames[20].T @ (0.0, lever, 0.0))
    scene.add_force(eyelet, (0.0, 0.0, load))
    both = scene.add_force(stark.joined([rod.vertices[[20]], box.points((0, 0, 0))]), [(1, 0, 0), (0, 2, 0)])
    settings = {"time.integrator": "quasistatic", "contact.enabled": False}
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), settings=settings)
    assert not sim.step().failed
    assert rod.clamp_torques[0, 0] == pytest.approx(-load * lever, rel=2e-4)  # the lever turns by 0.01 rad
    assert rod.section_moments[:, 0] == pytest.approx(np.full(20, load * lever), rel=2e-4)
    assert rod.tensions == pytest.approx(np.ones(20), rel=1e-3)
    assert both.forces[:, 0].tolist() == [[1, 0, 0], [0, 2, 0]] and box.holding_force[1] == pytest.approx(
        -2.0
    )


def test_wrong_loads_are_refused() -> None:
    scene = stark.Scene()
    cloth, box = balloon(scene), scene.add_box(0.1, mass=1.0, position=(1, 0, 0))
    with pytest.raises(stark.InvalidArgument, match="must be a rigid body, or points such as"):
        scene.add_force(cloth, (0, 0, 1))
    with pytest.raises(stark.InvalidArgument, match="force"):
        scene.add_force(box, (0, 0))
    with pytest.raises(stark.InvalidArgument, match="must be a frame"):
        scene.add_torque(cloth, (0, 0, 1))
    with pytest.raises(stark.InvalidArgument, match=r"pressure.*finite"):
        scene.add_pressure(cloth, float("nan"))


def test_the_ledger_closes_while_loads_change() -> None:
    """What new values add to the stored energy is reported as placed."""
    scene = stark.Scene()
    ball = scene.add_sphere(0.01, mass=0.014, name="ball", position=(0.0, 0.0, 1.0))
    scene.add_force(ball, lambda t: (0.0, 0.0, 0.13 * max(1.0 - t / 0.2, 0.0)))
    balloon = scene.add_cloth(stark.mesh.sphere(0.05, 2), stark.materials.pet, position=(1.0, 0.0, 0.0))
    load = scene.add_pressure(balloon, 100.0)
    sim = simulate(scene)
    rows = [report_to_dict(sim.step()) for _ in range(10)]
    size, height = volume(balloon), ball.position[2]
    load.pressure = 300.0
    rows += [report_to_dict(sim.step()) for _ in range(20)]
    lost = 0.13 * 0.01 / 0.2  # of the force in the step [N]
    assert rows[10]["energy"]["placed"] == pytest.approx(lost * height - 200.0 * size, rel=1e-9)
    for before, row in pairwise(rows):
        off, rounding = _imbalance(before, row, row["contact_energy_at_start"])
        assert abs(off) <= rounding
