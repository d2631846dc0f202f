"""Restitution of rigid bodies: the speed after an impact over that before, whatever the step and the
integrator."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _helpers import G

import stark

INTEGRATORS = ("implicit_euler", "bdf2")
STEPS = (1 / 60, 1 / 240, 1e-3)
DROP = 0.2  # [m]


def dropped(kind: str, e: float | None, h: float, integrator: str, **settings: Any) -> stark.Simulation:
    """1 kg, 0.2 m above a floor."""
    scene = stark.Scene()
    scene.default_friction = 0.0
    scene.add_floor(2.0, name="floor")
    add = scene.add_sphere if kind == "ball" else scene.add_box
    add(0.05 if kind == "ball" else 0.1, mass=1.0, position=(0, 0, 0.05 + DROP), name="body")
    if e is not None:
        scene.restitution["body", "floor"] = e
    return stark.Simulation(scene, time_step=h, **{"time.integrator": integrator, **settings})


def heights_and_energies(sim: stark.Simulation, until: float) -> tuple[np.ndarray, np.ndarray]:
    heights, energies = [], []
    for report in sim.run(until=until):
        heights.append(sim["body"].position[2] - 0.05)
        energies.append(sum(report.energy[key] for key in ("kinetic", "gravity", "contact")))
    return np.array(heights), np.array(energies)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("h", STEPS)
@pytest.mark.parametrize("kind", ["ball", "box"])
def test_bodies_rebound_by_their_coefficient(kind: str, h: float, integrator: str) -> None:
    start = G * (0.05 + DROP)
    for e in (0.3, 0.6, 0.9):
        z, energies = heights_and_energies(dropped(kind, e, h, integrator), until=0.66)
        lowest = int(np.argmin(z[: int(0.35 / h)]))
        measured = np.sqrt(z[lowest:].max() / DROP)
        assert measured == pytest.approx(e, abs=0.03), (e, measured)
        assert energies.max() <= start * (1.0 + 1e-6)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("h", STEPS)
@pytest.mark.parametrize("kind", ["ball", "box"])
def test_nothing_rebounds_without_restitution(kind: str, h: float, integrator: str) -> None:
    sim = dropped(kind, 0.0, h, integrator)
    heights, speeds = [], []
    for _report in sim.run(until=1.0):
        heights.append(sim["body"].position[2])
        speeds.append(sim["body"].velocity[2])
    assert min(speeds) < -0.85 * np.sqrt(2.0 * G * DROP)  # it did fall
    # The layer takes up the impact in the steps around the lowest place and lifts the body again at leisure.
    over = int(np.argmin(heights[: int(0.3 / h)])) + 3
    assert max(speeds[over:]) <= 0.02 * np.sqrt(2.0 * G * DROP)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("h", STEPS)
def test_free_bodies_exchange_momentum(h: float, integrator: str) -> None:
    """A box hits one three times as heavy, in the middle and beside it: momentum is conserved, no energy
    comes from nowhere, and in the middle they part with e times the speed they met with."""
    for e in (0.0, 0.5, 1.0):
        for offset in (0.0, 0.02):
            scene = stark.Scene()
            light = scene.add_box(0.1, mass=1.0, velocity=(2, 0, 0))
            heavy = scene.add_box(0.1, mass=3.0, position=(0.2, offset, 0.0))
            scene.restitution[light, heavy], scene.friction[light, heavy] = e, 0.0
            sim = stark.Simulation(scene, time_step=h, gravity=(0, 0, 0), **{"time.integrator": integrator})
            for report in sim.run(until=0.25):
                assert report.energy["kinetic"] + report.energy["contact"] <= 2.0 * (1.0 + 1e-9)
            assert light.velocity + 3.0 * heavy.velocity == pytest.approx([2, 0, 0], abs=2e-6)
            if offset == 0.0:
                assert heavy.velocity[0] - light.velocity[0] == pytest.approx(2.0 * e, abs=0.03 * 2.0)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("h", STEPS[:2])
@pytest.mark.parametrize("kind", ["ball", "box"])
def test_spinning_bodies_gain_no_energy(kind: str, h: float, integrator: str) -> None:
    """Rates were those of points before they had turned to where they are hit: balls of e = 1 that spin at
    20 rad/s gained 3 % of their energy."""
    for spin in ((0, 20, 0), (0, 0, -20), (5, 15, -10)):
        for offset in (0.0, 0.02):
            scene = stark.Scene()
            add = scene.add_sphere if kind == "ball" else scene.add_box
            size = 0.05 if kind == "ball" else 0.1
            light = add(size, mass=1.0, velocity=(2, 0, 0), angular_velocity=spin)
            heavy = add(size, mass=3.0, position=(0.2, offset, 0.0))
            scene.restitution[light, heavy], scene.friction[light, heavy] = 1.0, 0.0
            sim = stark.Simulation(scene, time_step=h, gravity=(0, 0, 0), **{"time.integrator": integrator})
            energies = [report.energy["kinetic"] + report.energy["contact"] for report in sim.run(until=0.12)]
            assert max(energies) <= energies[0] * (1.0 + 1e-6)
            if kind == "ball":
                assert energies[-1] > 0.93 * energies[0]
            assert light.velocity + 3.0 * heavy.velocity == pytest.approx([2, 0, 0], abs=2e-6)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_contact_forces_have_the_impulse_of_both_phases(integrator: str) -> None:
    e, h = 0.6, 1 / 240
    sim = dropped("ball", e, h, integrator)
    impulse, speed = 0.0, np.sqrt(2.0 * G * DROP)
    for report in sim.run(until=0.3):
        if report.contact_count or impulse:
            contacts = sim.contacts
            forces = contacts.normal_forces[:, 2].sum() if len(contacts.normal_forces) else 0.0
            impulse += abs(forces) * report.time_step
    assert impulse == pytest.approx((1.0 + e) * speed, rel=0.05)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_ever_shorter_bounces_end_at_rest(integrator: str) -> None:
    """Bounces by e take T (1 + e)/(1 - e) after a fall of T; the gap at rest is that of bodies without a
    coefficient."""
    e, h = 0.5, 1e-3
    sim = dropped("box", e, h, integrator)
    fall = np.sqrt(2.0 * DROP / G)
    end = fall * (1.0 + e) / (1.0 - e)
    at_rest = 0.0
    for report in sim.run(until=2.0):
        if np.abs(sim["body"].velocity[2]) > 0.1:
            at_rest = report.time
    assert at_rest == pytest.approx(end, rel=0.12)  # the last bounces are shorter than what counts
    other = dropped("box", None, h, integrator)
    for _report in other.run(until=2.0):
        pass
    gap, expected = sim["body"].position[2] - 0.05, other["body"].position[2] - 0.05
    assert gap == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_an_impact_is_part_of_the_state(integrator: str) -> None:
    """Rewound to any step of an impact, the simulation goes on with the same bits."""
    sim = dropped("box", 0.7, 1 / 240, integrator)
    for _report in sim.run(until=0.19):
        pass
    states, hashes = [], []
    for _ in range(12):
        states.append(sim.state)
        sim.step()
        hashes.append(sim.state.hash)
    assert len(set(hashes)) == len(hashes)
    for state, expected in zip(states, hashes, strict=True):
        sim.state = state
        sim.step()
        assert sim.state.hash == expected


def test_the_ledger_names_what_is_given_back() -> None:
    e = 0.8
    sim = dropped("ball", e, 1 / 240, "bdf2")
    given = [report.energy["restitution"] for report in sim.run(until=0.3)]
    assert np.count_nonzero(given) == 1
    assert sum(given) == pytest.approx(e**2 * G * DROP, rel=0.05)


def test_only_pairs_of_rigid_bodies_have_a_coefficient() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="box")
    floor = scene.add_floor(name="floor")
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), name="towel", position=(0, 0, 1))
    assert scene.restitution[box, floor] is None
    scene.restitution[box, floor] = 0.4
    assert scene.restitution["floor", "box"] == 0.4
    with pytest.raises(stark.InvalidArgument, match="'towel' is a cloth: must be rigid bodies"):
        scene.restitution["box", "towel"] = 0.5
    with pytest.raises(stark.InvalidArgument, match=r"coefficient = 1\.2"):
        scene.restitution[box, floor] = 1.2
    with pytest.raises(stark.InvalidArgument, match="two bodies"):
        scene.restitution[box, box] = 0.5


def test_example() -> None:
    runpy.run_path(str(Path(__file__).parents[3] / "examples/bouncing_balls.py"))["main"]()


@pytest.mark.parametrize("h", [1e-3, 5e-3])
@pytest.mark.parametrize("e", [0.0, 0.3])
def test_a_wall_that_speeds_up_pushes_what_it_has_hit(e: float, h: float) -> None:
    """A layer that has taken up an impact carries next to nothing. It was that soft for most of a second:
    what pushed slowly closed the gap to its bound, where steps may fail with `blocked_motion`."""
    scene = stark.Scene()
    scene.default_friction = 0.0
    wall = scene.add_box((0.2, 1.0, 1.0), motion="scripted", position=(-0.16, 0.0, 0.0))
    wall.follow(position=lambda t: (-0.16 + t + 10.0 * t**2, 0.0, 0.0))
    box = scene.add_box(0.1, mass=0.1)
    scene.restitution[wall, box] = e
    sim = stark.Simulation(scene, time_step=h, contact_distance=3e-3, gravity=(0.0, 0.0, 0.0))
    for report in sim.run(until=0.2):
        assert not report.failed, report.message
        assert report.min_distance > 0.1 * 6e-3
    assert box.velocity[0] == pytest.approx(5.0, rel=0.06)  # of the wall


def test_forces_that_are_shown_are_those_that_act_in_a_corner() -> None:
    """Contacts of an impact that press in several directions: their sum was too large by one over the square
    of its length."""
    scene = stark.Scene()
    scene.default_friction = 0.0
    room = scene.add_rigid(stark.mesh.box(0.4), hollow=True, motion="fixed")
    box = scene.add_box(0.1, mass=0.1, position=(0.1, 0.1, 0.1), velocity=(2.0, 1.9, 2.1))
    scene.restitution[room, box] = 0.5
    sim = stark.Simulation(scene, time_step=1e-3, contact_distance=3e-3, gravity=(0.0, 0.0, 0.0))
    before, given = box.mass * box.velocity, 0.0
    for report in sim.run(until=0.08):
        acting = (box.mass * box.velocity - before) / report.time_step
        assert box.contact_force == pytest.approx(acting, abs=1e-3)
        before = box.mass * box.velocity
        given = max(given, report.energy["restitution"])
    assert given > 0.01


@pytest.mark.parametrize("later", [-30.0, 2.5, 3.0, 30.0])
def test_forces_that_are_shown_are_those_that_act_where_the_wall_turns_round(later: float) -> None:
    """The mass of an impact was taken from the speed of the next step: a wall that came nearer then by more
    than the speed of the impact made it negative, and forces that were shown were not those that acted."""
    scene = stark.Scene()
    scene.default_friction = 0.0
    wall = scene.add_box((0.2, 1.0, 1.0), motion="scripted", position=(-0.16, 0.0, 0.0))
    box = scene.add_box(0.1, mass=0.1, velocity=(-2.0, 0.0, 0.0))
    scene.restitution[wall, box] = 0.6
    sim = stark.Simulation(scene, time_step=1e-4, contact_distance=3e-3, gravity=(0.0, 0.0, 0.0))
    before, has_hit = box.mass * box.velocity, False
    for _ in range(100):
        turns = not has_hit and bool(sim.state.arrays()["restitution_due"].any())
        wall.velocity = (later if turns else 0.0, 0.0, 0.0)
        has_hit = has_hit or turns
        report = sim.step()
        assert not report.failed, report.message
        acting = (box.mass * box.velocity - before) / report.time_step
        assert box.contact_force == pytest.approx(acting, abs=1e-3)
        before = box.mass * box.velocity
    assert has_hit


def test_a_ball_breaks_a_rack_of_touching_balls() -> None:
    """Layers between balls of the rack that had passed an impact on were spent, and too soft to pass on what
    it gave back, in attempts of any length: the step failed."""
    radius, gap, speed, distance = 0.0286, 1e-5, 8.0, 1e-5
    scene = stark.Scene()
    scene.default_friction = 0.0
    floor = scene.add_floor(4.0)
    balls = []
    places = [(r * np.sqrt(0.75), k - r / 2) for r in range(3) for k in range(r + 1)]
    for x, y in np.array(places) * (2 * radius + gap):
        place = (x, y, radius + distance)
        balls.append(scene.add_sphere(radius, subdivisions=2, mass=0.17, position=place))
    cue = {"position": (-0.1, 0.003, radius + distance), "velocity": (speed, 0, 0)}
    balls.append(scene.add_sphere(radius, subdivisions=2, mass=0.17, **cue))
    for k, ball in enumerate(balls):
        scene.restitution[ball, floor] = 0.5
        for other in balls[:k]:
            scene.restitution[ball, other] = 0.95
    sim = stark.Simulation(scene, time_step=2e-3, contact_distance=distance)
    for report in sim.run(until=0.02):
        velocities = np.array([ball.velocity for ball in balls])
        assert velocities[:, :2].sum(axis=0) == pytest.approx([speed, 0.0], abs=1e-8)
        assert report.energy["kinetic"] < 0.5 * 0.17 * speed**2 * 1.001
    assert report.energy["kinetic"] > 0.7 * 0.5 * 0.17 * speed**2


def object_ball(h: float, integrator: str, before: float) -> tuple[float, float]:
    """Direction [deg] and speed of a billiard ball that another one of 1 m/s hits 0.6 of a diameter beside
    its middle, over those of an impact without a time step. ``before``: part of a step by which it is
    later."""
    radius, beside, e = 0.028, 0.6, 0.95
    along = np.sqrt(1.0 - beside**2)
    scene = stark.Scene()
    scene.default_friction = 0.0
    turns = [stark.rotation(axis=axis, angle=angle) for axis, angle in (((3, 1, 2), 0.4), ((1, 2, 3), 0.7))]
    ball = scene.add_sphere(radius, subdivisions=4, mass=0.17, name="object", rotation=turns[0])
    scene.add_sphere(
        radius,
        subdivisions=4,
        mass=0.17,
        name="cue",
        position=(-2 * radius * along - 0.02 - before * h, beside * 2 * radius, 0),
        velocity=(1, 0, 0),
        rotation=turns[1],
    )
    scene.restitution["cue", "object"] = e
    settings = {"contact_distance": 2e-4, "gravity": (0, 0, 0), "time.integrator": integrator}
    sim = stark.Simulation(scene, time_step=h, **settings)
    sim.run_until(0.12)
    x, y = ball.velocity[:2]
    turned = np.degrees(np.arctan2(-y, x) - np.arcsin(beside))
    return float(turned), float(np.hypot(x, y) / (0.5 * (1.0 + e) * along))


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(
    ("h", "turned", "slower"),
    [
        (1 / 60, (12, 15), (0.24, 0.33)),
        (0.01, (6, 8), (0.13, 0.17)),
        (0.005, (2, 5), (0.05, 0.09)),
        (0.002, (0, 2), (0.01, 0.04)),
    ],
)
def test_oblique_impacts_turn_by_the_way_of_a_step(
    h: float, turned: tuple[float, float], slower: tuple[float, float], integrator: str
) -> None:
    """docs/friction.md: the direction of the impact is that at the end of its step."""
    for part in (0.0, 0.25, 0.5, 0.75):
        direction, speed = object_ball(h, integrator, part)
        assert turned[0] - 0.5 < direction < turned[1] + 0.5
        assert slower[0] - 0.006 < 1.0 - speed < slower[1] + 0.006
