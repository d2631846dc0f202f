"""Toys and textbook problems: dominoes, a falling chimney, a cone that rolls around its tip, a ladder."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stark

BOTH = pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
G = 9.81
Floats = np.ndarray[Any, np.dtype[np.float64]]


def simulated(scene: stark.Scene, step: float, integrator: str, **settings: Any) -> stark.Simulation:
    return stark.Simulation(scene, time_step=step, time={"integrator": integrator}, **settings)


def times_of_hits(count: int, rate: float, height: float, depth: float, gap: float) -> list[float]:
    """When each domino is hit, the first one starting at a rate [rad/s]. Those that have fallen lean on each
    other without friction, sin(a - b) = ((gap + depth) cos b - depth) / height for the angles a of one and b
    of the one before it; impacts are inelastic, and feet do not slip (van Leeuwen 2010)."""
    inertia = (height**2 + depth**2) / 3.0  # of 1 kg

    def train(angle: float, behind: int) -> tuple[Floats, Floats]:
        """Angles from the head back, and their rates over that of the head."""
        angles, rates = [angle], [1.0]
        for _ in range(behind):
            b = angles[-1]
            part = ((gap + depth) * np.cos(b) - depth) / height
            angles.append(b + np.arcsin(part))
            rates.append(rates[-1] * (1.0 - (gap + depth) * np.sin(b) / height / np.sqrt(1.0 - part**2)))
        return np.array(angles), np.array(rates)

    def energy(angle: float, behind: int) -> float:
        angles, _ = train(angle, behind)
        return float(0.5 * G * (height * np.cos(angles) + depth * np.sin(angles)).sum())

    def mass(angle: float, behind: int) -> float:
        return float(inertia * (train(angle, behind)[1] ** 2).sum())

    end, times = np.arcsin(gap / height), [0.0]
    for behind in range(count - 1):
        total = 0.5 * mass(0.0, behind) * rate**2 + energy(0.0, behind)
        edges = np.linspace(0.0, end, 201)
        middles = 0.5 * (edges[1:] + edges[:-1])
        rates = [np.sqrt(2.0 * (total - energy(a, behind)) / mass(a, behind)) for a in middles]
        times.append(times[-1] + float((np.diff(edges) / rates).sum()))
        at_hit = np.sqrt(2.0 * (total - energy(end, behind)) / mass(end, behind))
        before = np.r_[0.0, train(end, behind)[1] * at_hit]
        after = train(0.0, behind + 1)[1]
        rate = float(after @ before / (after @ after))
    return times


@BOTH
def test_a_wave_runs_through_dominoes(integrator: str) -> None:
    """Speed over the last ten of twenty, within 2.5 %: 1 % are steps of the time, the contact distance takes
    1 % of the gap on each side."""
    count, height, depth, gap, distance = 20, 0.048, 0.0075, 0.0165, 2e-4
    scene = stark.Scene()
    scene.default_friction = 0.0
    scene.add_box((2.0, 0.5, 0.1), motion="fixed", position=(0.3, 0, -0.05), name="floor")
    row = []
    for k in range(count):
        place = (k * (gap + depth), 0.0, 0.5 * height + distance)
        row.append(scene.add_box((depth, 0.024, height), mass=0.01, position=place))
        scene.friction[row[-1], "floor"] = 1.5
    sim = simulated(scene, 0.001, integrator, contact_distance=distance)
    row[0].angular_velocity = (0.0, 6.0, 0.0)
    row[0].velocity = (3.0 * height, 0.0, 0.0)
    hit = np.full(count, np.nan)
    for report in sim.run(until=1.0):
        for k, domino in enumerate(row):
            if np.isnan(hit[k]) and domino.rotation[0, 2] > gap / height:
                hit[k] = report.time  # it reaches the next one
        if not np.isnan(hit[-1]):
            break
    expected = times_of_hits(count, 6.0, height, depth, gap)
    assert hit[-1] - hit[-11] == pytest.approx(expected[-1] - expected[-11], rel=0.025)


@BOTH
def test_a_falling_chimney_bends_most_at_a_third(integrator: str) -> None:
    """At a distance s from its hinge the moment is m g sin(angle) s (l - s)^2 / (4 l^2)."""
    scene, count, length, mass, start = stark.Scene(), 6, 3.0, 6.0, 0.3
    turn = stark.rotation(axis="y", angle=start)
    part = length / count
    parts = [
        scene.add_box(
            (0.02, 0.02, part), mass=mass / count, position=turn @ [0, 0, (k + 0.5) * part], rotation=turn
        )
        for k in range(count)
    ]
    foot = scene.add_hinge(None, parts[0], anchor=(0, 0, 0), axis="y")
    welds = [
        scene.add_fixed(parts[k], parts[k + 1], anchor=turn @ [0, 0, (k + 1) * part])
        for k in range(count - 1)
    ]
    sim = simulated(scene, 0.005, integrator)
    sim.run_until(0.6)
    s = part * np.arange(1, count)
    moments = mass * G * np.sin(start + foot.angle) * s * (length - s) ** 2 / (4.0 * length**2)
    np.testing.assert_allclose([weld.reaction.torque[1] for weld in welds], moments, rtol=5e-4)
    assert int(np.argmax(moments)) == 1  # at 1 m of 3 m


@BOTH
def test_a_cone_swings_around_its_tip_on_a_slope(integrator: str) -> None:
    """It rolls without slip about the line where it touches: 3 m h^2 (1 + 5 cos^2 a) / 20 times the angular
    acceleration is the torque of the weight on its centre, at 3/4 h cos a from the tip."""
    scene, a, height, mass, slope, start = stark.Scene(), 0.35, 0.1, 0.5, 0.3, 0.4
    scene.default_friction = 0.8
    turns = np.arange(128) * 2.0 * np.pi / 128
    rim = height * np.tan(a) * np.c_[np.cos(turns), np.sin(turns)]
    points = np.vstack([[0, 0, 0], np.c_[np.full(128, height), rim]])
    scene.add_box((2, 2, 0.1), motion="fixed", position=(0, 0, -0.05))
    lean = stark.rotation(axis="z", angle=start) @ stark.rotation(axis="y", angle=-a)
    cone = scene.add_rigid(stark.mesh.convex_hull(points), mass=mass, position=(0, 0, 1e-4), rotation=lean)
    down = (G * np.sin(slope), 0.0, -G * np.cos(slope))
    sim = simulated(scene, 0.002, integrator, contact_distance=1e-4, gravity=down)
    inertia = 3.0 * mass * height**2 * (1.0 + 5.0 * np.cos(a) ** 2) / 20.0
    torque = mass * G * np.sin(slope) * 0.75 * height * np.cos(a)
    times, angles = [], []
    for report in sim.run(until=1.0):
        axis = cone.rotation[:, 0]
        times.append(report.time)
        angles.append(np.arctan2(axis[1], axis[0]))
    ends = np.minimum(times, 1.0)
    swing = solve_ivp(
        lambda _, y: [y[1], -torque / inertia * np.sin(y[0])], (0, 1), [start, 0], t_eval=ends, rtol=1e-9
    )
    error = 0.01 if integrator == "implicit_euler" else 0.003
    np.testing.assert_allclose(angles, swing.y[0], atol=error)
    assert np.linalg.norm(cone.position[:2]) < 3e-5  # the tip does not creep away


@BOTH
def test_a_ladder_leaves_the_wall_at_two_thirds(integrator: str) -> None:
    """Of the height from which it slides without friction; then it keeps its speed along the floor. 1 %: it
    is 2 mm thick, and the wall lets go of it over the contact distance."""
    scene, length, lean, distance = stark.Scene(), 2.0, 0.35, 2e-4
    scene.default_friction = 0.0
    scene.add_box((6, 6, 0.1), motion="fixed", position=(0, 0, -0.05), name="floor")
    scene.add_box((0.1, 6, 6), motion="fixed", position=(-0.05, 0, 3.05), name="wall")
    turn = stark.rotation(axis="y", angle=-lean)
    corners = np.array([(x, 0.0, z) for x in (-0.001, 0.001) for z in (-0.5 * length, 0.5 * length)]) @ turn.T
    place = np.array([distance, 0.0, distance]) - corners.min(axis=0)
    ladder = scene.add_box((0.002, 0.4, length), mass=3.0, position=place, rotation=turn, name="ladder")
    sim = simulated(scene, 0.001, integrator, contact_distance=distance)
    for _ in sim.run(until=1.0):
        if sim.time > 0.1 and len(sim.contacts.of("ladder", "wall").distances) == 0:
            break
    left, speed = ladder.position[2] / place[2], ladder.velocity[0]
    assert left == pytest.approx(2.0 / 3.0, rel=0.01)
    fallen = place[2] / 3.0
    rate = np.sqrt(2.0 * G * fallen / (length**2 / 4.0 + length**2 / 12.0))
    assert speed == pytest.approx(rate * place[2] * 2.0 / 3.0, rel=0.01)
    sim.run_until(sim.time + 0.15)
    assert ladder.velocity[0] == pytest.approx(speed, rel=2e-3)
