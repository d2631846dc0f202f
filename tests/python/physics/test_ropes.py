"""Ropes: what they transmit over drums, with and without friction; what friction on centre lines does
(docs/rods.md)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from _helpers import G
from _validation import validate
from scipy.integrate import quad

import stark


def pull_over_drum(friction: float, *, speed: float, time_step: float, segments: int) -> float:
    """Force that pulls a rope at a constant speed over half of a fixed drum, over the load of 0.5 kg at its
    other end."""
    radius, rope_radius, distance, length, load = 0.05, 0.002, 5e-4, 0.15, 0.5
    scene = stark.Scene()
    scene.default_friction = friction
    lying = stark.rotation(axis="x", angle=0.5 * np.pi)
    scene.add_cylinder(
        radius, 0.02, motion="fixed", segments=segments, rotation=lying, contact_distance=distance
    )
    around = radius + rope_radius + 0.5 * distance
    arc, straight = np.linspace(np.pi, 0.0, 49), np.linspace(0.0, length, 45)[1:]
    points = [(-around, 0.0, -z) for z in straight[::-1]]
    points += [(around * np.cos(t), 0.0, around * np.sin(t)) for t in arc]
    points += [(around, 0.0, -z) for z in straight]
    material = stark.RodMaterial(
        density=50.0, youngs_modulus=1e4, radius=rope_radius, axial_stiffness=2e4, strain_damping=0.02
    )
    rope = scene.add_rod(np.array(points), material, rest_shape="straight")
    weight = scene.add_sphere(0.02, mass=load, position=(-around, 0.0, -length - 0.02))
    hook = scene.add_box(0.02, mass=0.01, position=(around, 0.0, -length - 0.01))
    scene.add_ball(rope.frame(0), weight, anchor=(-around, 0.0, -length))
    scene.add_ball(rope.frame(-1), hook, anchor=(around, 0.0, -length))
    guide = scene.add_slider(None, hook, anchor=(around, 0.0, -length), axis="z")
    motor = guide.add_motor(target=-speed, cap=50.0, delta=1e-4)
    sim = stark.Simulation(scene, time_step=time_step)
    forces = [0.01 * G - motor.force for _ in sim.run(until=0.5)]
    return float(np.mean(forces[len(forces) // 2 :])) / (load * G)


@pytest.mark.parametrize("speed", [0.05, 0.2])
def test_a_rope_without_friction_is_no_engine(speed: float) -> None:
    """It pulled itself with 1.5 and 4 % of its load: areas of contact followed the normals a step behind."""
    ratio = pull_over_drum(0.0, speed=speed, time_step=0.005, segments=96)
    assert ratio == pytest.approx(1.0, abs=3e-3)


def test_a_rope_holds_as_a_capstan_does() -> None:
    """Euler and Eytelwein: e^(mu pi)."""
    ratio = pull_over_drum(0.3, speed=0.05, time_step=0.005, segments=192)
    assert ratio == pytest.approx(math.exp(0.3 * np.pi), rel=0.005)


def test_the_end_of_a_folded_chain_falls_faster_than_free() -> None:
    """The end of a chain that hangs folded, both ends side by side, is let go. Without losses its speed at
    the depth x is that of free fall times sqrt((1 - x/2L)/(1 - x/L)) [Calkin and March 1989]."""
    length, apart = 1.0, 0.04
    arm = 0.5 * (length - 0.5 * np.pi * apart)
    down, bend = np.linspace(0.0, -arm, 50), np.linspace(0.0, np.pi, 14)[1:-1]
    radius = 0.5 * apart
    points = [(0.0, 0.0, z) for z in down]
    points += [(radius - radius * np.cos(a), 0.0, -arm - radius * np.sin(a)) for a in bend]
    points += [(apart, 0.0, z) for z in down[::-1]]
    limp = stark.RodMaterial(
        density=1000.0,
        radius=0.002,
        axial_stiffness=1e4,
        bending_stiffness_1=1e-9,
        bending_stiffness_2=1e-9,
        torsional_stiffness=1e-8,
    )
    scene = stark.Scene()
    chain = scene.add_rod(np.array(points), limp, pins=[0], rest_shape="straight", self_contact=False)
    sim = stark.Simulation(scene, time_step=5e-4, time={"integrator": "bdf2"})
    times, depths = [0.0], [0.0]
    for report in sim.run(until=0.38):
        times.append(report.time)
        depths.append(-chain.positions[-1, 2])

    def slowness(root: float) -> float:
        x = root**2  # time over its root stays finite at the start
        return 2.0 * root / math.sqrt(2.0 * G * x * (1.0 - x / (2.0 * length)) / (1.0 - x / length))

    expected = [quad(slowness, 1e-12, math.sqrt(x * length))[0] for x in (0.5, 0.8, 0.9)]
    found = np.interp([0.5, 0.8, 0.9], depths, times)
    validate("folded_chain.times", found / expected)
    assert found[2] < 0.88 * math.sqrt(2.0 * 0.9 * length / G)  # of free fall


def test_a_rod_across_a_slope_does_not_roll() -> None:
    """docs/rods.md: friction on the centre line has no torque about it."""
    scene = stark.Scene()
    slope = np.asarray(stark.rotation(axis="y", angle=20 * stark.deg))
    scene.add_box((2, 2, 0.1), motion="fixed", rotation=slope, position=slope @ [0, 0, -0.05])
    ends = np.array([[0, -0.1, 0.0055], [0, 0.1, 0.0055]]) @ slope.T
    bar = stark.RodMaterial(density=1000.0, youngs_modulus=1e8, radius=0.005)
    rod = scene.add_rod(stark.mesh.polyline(*ends, 20), bar, friction=0.5)
    start = rod.positions
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.5)
    assert np.abs((rod.positions - start) @ slope[:, 0]).max() < 1e-4
    rolled = 0.5 * 2.0 / 3.0 * G * math.sin(20 * stark.deg) * 0.5**2
    assert rolled == pytest.approx(0.28, abs=5e-3)  # as the guide says of a round bar


@stark.energy
def draw(p: stark.Point, q: stark.Point, force: float = 0.0):
    """A force that draws two points together [N]."""
    between = p.x - q.x
    return force * stark.sqrt(between @ between)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
@pytest.mark.parametrize("contact_distance", [None, 5e-4])
def test_rods_that_cross_keep_their_spin(axis: tuple[float, ...], contact_distance: float | None) -> None:
    """Two rods that touch turn as a whole: their gap turns with their common normal, theory eq. (19e).
    Friction at the ends of the gap was a couple, which turned them back after 0.1 s."""
    scene = stark.Scene()
    scene.default_friction = 0.5
    bar = stark.RodMaterial(density=1000.0, youngs_modulus=1e8, radius=0.004)
    z = 0.98 * (contact_distance or bar.radius)
    lines = [((-0.1, 0, -z), (0.1, 0, -z)), ((0, -0.1, z), (0, 0.1, z))]
    pair = [
        scene.add_rod(stark.mesh.polyline(*line, 20), bar, contact_distance=contact_distance)
        for line in lines
    ]
    scene.add(draw(pair[0].vertices[[10]], pair[1].vertices[[10]], force=2.0))
    sim = stark.Simulation(scene, time_step=0.005, gravity=(0, 0, 0))
    sim.run_until(0.3)
    for rod in pair:
        rod.velocities = np.cross(5.0 * np.array(axis), rod.positions)
    spins = [report.angular_momentum @ np.array(axis) for report in sim.run(until=0.7)]
    assert spins[-1] == pytest.approx(spins[0], rel=5e-3)
