"""Loads under which plates, arches and rods give way aside, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from _validation import validate

import stark

SETTINGS = {
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "newton.step_tolerance": 1e-9,
    "newton.acceleration_tolerance": 1e-6,
}


def simulation(scene: stark.Scene) -> stark.Simulation:
    return stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), settings=SETTINGS)


def bulge(cells: int, load: float) -> float:
    """Deflection [m] of a square plate on simple supports, shortened by a share of 4 pi^2 D / b^2."""
    modulus, thickness, side, ratio = 2e9, 1e-3, 0.2, 0.3
    rigidity = modulus * thickness**3 / 12.0 / (1.0 - ratio**2)
    skin = stark.ShellMaterial(
        density=1.0,
        thickness=thickness,
        youngs_modulus=modulus,
        poissons_ratio=ratio,
        flexural_rigidity=rigidity,
    )
    mesh = stark.mesh.grid(side, side, cells)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    start = mesh.vertices + np.outer(
        1e-5 * np.cos(np.pi * x / side) * np.cos(np.pi * y / side), [0.0, 0.0, 1.0]
    )
    scene = stark.Scene()
    plate = scene.add_cloth(mesh, skin, initial_positions=start)
    left, right = x < -0.4999 * side, x > 0.4999 * side
    scene.add_rollers(plate.vertices[left | right | (abs(y) > 0.4999 * side)], "z")
    shift = load * 4.0 * np.pi**2 * rigidity / side / modulus / thickness / 2.0
    scene.add_rollers(plate.vertices[left], "x", shift=shift)
    scene.add_rollers(plate.vertices[right], "x", shift=-shift)
    scene.add_rollers(plate.vertices[(left | right) & (abs(y) < 1e-9)], "y")
    sim = simulation(scene)
    assert not sim.step().failed
    return float(np.abs(plate.positions[:, 2]).max())


def test_a_plate_bulges_under_eulers_load() -> None:
    def critical(cells: int) -> float:
        low, high = bulge(cells, 1.03) ** 2, bulge(cells, 1.1) ** 2  # grows as the load beyond it
        return 1.03 - 0.07 * low / (high - low)

    coarse, fine = critical(16), critical(32)
    validate("buckling.plate", [fine, (4.0 * fine - coarse) / 3.0])
    assert bulge(16, 0.95) < 1e-9


def snap(rise: float) -> float:
    """Load at which a shallow pinned arch under q sin(pi x / L) snaps through, over that of theory. ``rise``
    is its height over twice the radius of gyration of its section."""
    segments, radius, modulus = 64, 0.004, 1e9
    gyration, inertia = radius / 2.0, np.pi * radius**4 / 4.0
    x = np.linspace(0.0, 1.0, segments + 1)
    wave = np.sin(np.pi * x)
    wire = stark.RodMaterial(density=1000.0, youngs_modulus=modulus, radius=radius)
    scene = stark.Scene()
    arch = scene.add_rod(np.column_stack([x, 0 * x, 2.0 * gyration * rise * wave]), wire, pins=[0, segments])
    scene.add_rollers(arch.vertices[1:-1], "y")
    if rise < np.sqrt(5.5):
        largest = rise + np.sqrt(4.0 * (rise**2 - 1.0) ** 3 / 27.0)
    else:
        largest = rise + 3.0 * np.sqrt(rise**2 - 4.0)  # it sways to one side
    force = np.zeros((segments + 1, 3))
    force[:, 2] = -largest * 2.0 * modulus * inertia * np.pi**4 * gyration * wave / segments
    force[:, 2] *= 1.0 + 1e-4 * np.cos(np.pi * x)
    load = scene.add_force(arch.vertices, 0.0 * force)
    sim = simulation(scene)
    for share in np.concatenate([[0.3, 0.6, 0.8, 0.9], np.arange(0.95, 1.05, 0.005)]):
        load.force = share * force
        assert not sim.step().failed
        if arch.positions[segments // 2, 2] < 0.0:
            return float(share)
    raise AssertionError("it carries more than theory says")


@pytest.mark.parametrize("rise", [2, 5])
def test_a_shallow_arch_snaps_through(rise: int) -> None:
    validate(f"buckling.arch_{rise}", snap(rise))


def test_a_clamped_rod_that_is_heated_buckles() -> None:
    """Beyond the strain (pi r / L)^2 its force stays that of Euler; 2 r sqrt(heat - 1) aside."""
    segments, radius = 40, 0.01
    wire = stark.RodMaterial(density=1000.0, youngs_modulus=1e9, radius=radius, thermal_expansion=1e-5)
    points = stark.mesh.polyline((0, 0, 0), (1, 0, 0), segments).vertices
    start = points + np.outer(5e-6 * (1.0 - np.cos(2.0 * np.pi * points[:, 0])), [0.0, 0.0, 1.0])
    scene = stark.Scene()
    rod = scene.add_rod(points, wire, clamps=[0, segments], initial_positions=start)
    rod.temperature = 0.0
    sim = simulation(scene)
    critical = (np.pi * radius) ** 2
    forces = []
    for heat in (0.5, 1.5):
        rod.temperature = heat * critical / 1e-5
        assert not sim.step().failed
        forces.append(-rod.tensions.mean() / (1e9 * np.pi * radius**2 * critical))
    validate("buckling.heated_force", forces)
    validate("buckling.heated_way", np.abs(rod.positions[:, 2]).max())


def test_a_flat_cantilever_tips_over() -> None:
    """4.0126 sqrt(B C) / L^2, a force at the tip of a ruler on edge [Timoshenko and Gere]: where what it
    gives way aside under a small force grows without bound."""
    segments = 32
    ruler = stark.RodMaterial(
        density=1000.0,
        axial_stiffness=1e7,
        shear_stiffness=1e7,
        bending_stiffness_1=100.0,
        bending_stiffness_2=0.1,
        torsional_stiffness=0.1,
    )

    def resistance(share: float) -> float:
        scene = stark.Scene()
        line = stark.mesh.polyline((0, 0, 0), (1, 0, 0), segments)
        rod = scene.add_rod(line, ruler, clamps=[0], normal=(0, 1, 0))
        load = 4.0126 * 0.1 * share
        scene.add_force(rod.vertices[[segments]], (0, 1e-6 * load, -load))
        sim = simulation(scene)
        assert not sim.step().failed
        return float(load / rod.positions[-1, 1])

    low, high = resistance(0.9), resistance(0.97)
    validate("buckling.cantilever", np.sqrt(0.97**2 + (0.97**2 - 0.9**2) * high / (low - high)))


def test_a_twisted_rod_gives_way_aside() -> None:
    """At the torque 8.9868 B/L, twice the first root of tan x = x, if both ends keep their direction and one
    may come nearer [Greenhill 1883]. The inverse of the deflection by a small load across vanishes there."""
    length, segments = 1.0, 60
    rubber = stark.RodMaterial(density=1000.0, youngs_modulus=1e7, radius=0.005, poissons_ratio=0.0)
    critical = 8.9868 * rubber.section["bending_stiffness_1"] / length
    scene = stark.Scene()
    line = stark.mesh.polyline((0, 0, 0), (length, 0, 0), segments)
    rod = scene.add_rod(line, rubber, clamps=[0], normal=(0, 0, 1), self_contact=False)
    chuck = scene.add_box(0.02, mass=0.1, position=(length + 0.011, 0, 0))
    scene.add_fixed(rod.frame(segments), chuck)
    guide = scene.add_cylindrical(None, chuck, anchor=(length, 0, 0), axis="x")
    torque = guide.add_effort(0.0, coordinate="angle")
    scene.add_force(rod.vertices[[segments // 2]], (0, 0, 1e-5 * critical / length))
    sim = simulation(scene)

    def resistance(share: float) -> float:
        torque.target = share * critical
        assert not sim.step().failed
        return float(1.0 / np.hypot(*rod.positions[segments // 2, 1:]))

    for share in (0.3, 0.6, 0.8, 0.9):  # the way there
        resistance(share)
    low, high = resistance(0.96), resistance(0.98)
    validate("buckling.twisted_rod", np.sqrt(0.98**2 + (0.98**2 - 0.96**2) * high / (low - high)))


def ovalling(around: int, load: float) -> float:
    """How much out of round a long tube is, that starts out of round by 1e-4, under so many times the outer
    pressure 3 D / R^3. A slice of it, in plane strain."""
    rigidity, radius, width = 1e-3, 0.1, 0.02
    skin = stark.ShellMaterial(density=1.0, thickness=1e-3, youngs_modulus=1e9, flexural_rigidity=rigidity)
    angle = np.arange(around) * 2.0 * np.pi / around
    ring = radius * (1.0 + 1e-4 * np.cos(2.0 * angle)) * np.array([np.cos(angle), np.sin(angle)])
    places = np.concatenate([np.column_stack((*ring, np.full(around, z))) for z in (0.0, width / 2, width)])
    start = np.add.outer((0, around), np.arange(around)).ravel()
    after = np.where(start % around == around - 1, start - around + 1, start + 1)
    triangles = np.concatenate(
        [
            np.column_stack((start, after, after + around)),
            np.column_stack((start, after + around, start + around)),
        ]
    )
    scene = stark.Scene()
    tube = scene.add_cloth(stark.mesh.TriangleMesh(places, triangles), skin, rest_angles="mesh")
    scene.add_symmetry(tube.vertices[places[:, 2] < 1e-9], "z")
    scene.add_symmetry(tube.vertices[places[:, 2] > width - 1e-9], "z")
    scene.add_rollers(tube.vertices[np.abs(places[:, 1]) < 1e-9], "y")
    scene.add_rollers(tube.vertices[np.abs(places[:, 0]) < 1e-9], "x")
    outside = scene.add_face_pressure(tube.faces, 0.0)
    sim = simulation(scene)
    for share in (0.6 * load, load):
        outside.pressure = share * 3.0 * rigidity / radius**3
        assert not sim.step().failed
    x, y, _ = tube.positions.T
    return float(2.0 * np.mean(np.hypot(x, y) * np.cos(2.0 * np.tile(angle, 3))) / radius)


def test_a_tube_becomes_oval_under_outer_pressure() -> None:
    """At 3 D / R^3 [Levy 1884]. The inverse of its ovality is linear in the pressure and vanishes there."""

    def critical(around: int) -> float:
        low, high = 1.0 / ovalling(around, 0.5), 1.0 / ovalling(around, 0.75)
        return 0.5 + 0.25 * low / (low - high)

    coarse, fine = critical(32), critical(64)
    validate("buckling.tube", [fine, (4.0 * fine - coarse) / 3.0])
