"""Impacts and BDF2: no energy from its history, and no impact changes how others move."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import G

import stark

BDF2: dict[str, Any] = {"time.integrator": "bdf2"}
CORNER = float(np.arctan(np.sqrt(2.0)))  # turns a corner of a box down [rad]


def dropped(kind: str, tilt: float, friction: float) -> stark.Scene:
    """1 kg, 0.1 m above a floor, with a velocity along it where there is friction."""
    scene = stark.Scene()
    scene.default_friction = friction
    scene.add_floor(2.0)
    velocity = (0.5 if friction else 0.0, 0.0, 0.0)
    if kind == "ball":
        scene.add_sphere(0.05, mass=1.0, position=(0, 0, 0.15), velocity=velocity, name="body")
    else:
        rotation = stark.rotation(axis="x", angle=tilt)
        height = 0.1 + 0.0501 * np.sqrt(3.0)
        scene.add_box(
            0.1, mass=1.0, position=(0, 0, height), rotation=rotation, velocity=velocity, name="body"
        )
    return scene


@pytest.mark.parametrize("h", [1 / 60, 1 / 240, 1e-3])
@pytest.mark.parametrize(("kind", "tilt"), [("ball", 0.0), ("box", 0.0), ("box", 0.5), ("box", CORNER)])
def test_no_drop_gains_energy(kind: str, tilt: float, h: float) -> None:
    for friction in (0.0, 0.5):
        for distance, stiffness in ((1e-3, 100.0), (2e-3, 1.0), (0.01, 10.0)):
            settings = {**BDF2, "contact_distance": distance, "contact.stiffness_factor": stiffness}
            sim = stark.Simulation(dropped(kind, tilt, friction), time_step=h, **settings)
            body = sim["body"]
            start = 0.5 * body.mass * (body.velocity @ body.velocity) + G * body.mass * body.position[2]
            largest = 0.0
            for report in sim.run(until=0.5):
                assert not report.failed
                energy = report.energy
                largest = max(largest, energy["kinetic"] + energy["gravity"] + energy["contact"])
            assert largest <= start * (1.0 + 1e-6)


@pytest.mark.parametrize("h", [1 / 60, 1e-3])
def test_what_nothing_happens_to_keeps_its_order(h: float) -> None:
    """Free fall is exact but for the first step, which is one of implicit Euler: so it stays while a box hits
    the floor far away."""
    scene = dropped("box", 0.0, 0.5)
    scene.add_box(0.1, mass=1.0, position=(50, 0, 0), velocity=(1, 0, 2), name="far")
    sim = stark.Simulation(scene, time_step=h, **BDF2)
    kinds, met = [], False
    for report in sim.run(until=0.5):
        kinds.append(report.integrator)
        met = met or report.contact_count > 0
        t = sim.time
        exact = (50 + t, 0.0, 2 * t - G * t * t / 2 - G * h * h / 2)
        assert sim["far"].position == pytest.approx(exact, abs=1e-9)
    assert met
    assert [str(kind) for kind in kinds[1:]] == [str(kinds[1])] * (len(kinds) - 1)
    assert kinds[0] != kinds[1]


def test_the_weight_of_contact_is_none_of_its_force() -> None:
    """A box that has come to rest beside one that hits the floor after 0.48 s: contact has another weight in
    the steps of the impact, its force is the weight of the box all the time."""
    scene = stark.Scene()
    scene.add_floor(2.0)
    scene.add_box(0.1, mass=1.0, position=(0.0, 0.0, 0.0515), name="resting")
    scene.add_box(0.1, mass=1.0, position=(0.5, 0.0, 1.2), name="falling")
    sim = stark.Simulation(scene, time_step=1 / 240, contact_distance=1e-3, **BDF2)
    forces, hit = [], False
    for _ in sim.run(until=0.7):
        hit = hit or sim["falling"].contact_force[2] > 10.0 * G
        if sim.time > 0.45:
            forces.append(sim["resting"].contact_force[2])
    assert hit
    assert np.array(forces) == pytest.approx(G, rel=1e-4)


@pytest.mark.parametrize("h", [1 / 30, 1 / 60, 0.01])
def test_a_box_does_not_creep_in_a_grip_that_speeds_up(h: float) -> None:
    """Two fingers with 10 N each carry 0.2 kg upwards; friction carries less than half of what it can.
    Measured by velocities with lags of their own, what stuck moved by 29 mm at 1/30 s, 2.3 mm at 1/60 s."""
    scene = stark.Scene()
    scene.default_friction = 0.5
    palm = scene.add_box((0.2, 0.06, 0.02), motion="scripted", position=(0, 0, 0.15))
    fingers = [
        scene.add_box((0.01, 0.03, 0.1), mass=0.1, position=(x, 0, 0.08), name=f"finger at {x}")
        for x in (-0.03, 0.03)
    ]
    sliders = [scene.add_slider(palm, body, anchor=body.position, axis=(1, 0, 0)) for body in fingers]
    sliders[1].add_gear(sliders[0], ratio=-1.0)
    sliders[0].add_motor(0.1, cap=20.0, delta=0.02)
    scene.add_floor(1.0)
    load = scene.add_box(0.04, mass=0.2, position=(0, 0, 0.0215), name="load")
    places = [(0, 0, 0.15), (0, 0, 0.25), (0, 0, 0.25)]
    palm.follow(position=stark.motion.spline([0.2, 0.4, 0.6], places))
    sim = stark.Simulation(scene, time_step=h, **BDF2)
    in_grip = []
    while sim.time < 0.75 - 1e-9:
        assert not sim.step().failed
        if sim.time > 0.19:
            in_grip.append(load.position[2] - palm.position[2])
    assert np.ptp(in_grip) < 2e-5  # two stick displacements


@pytest.mark.parametrize("speed", [0.1, 1.0])
def test_what_rests_elsewhere_does_not_change_an_impact(speed: float) -> None:
    """Contact that lasts goes on from step to step, of all bodies or of none: with a box at rest beside it, a
    box that lands had a force half as large again in its first step."""

    def forces(with_rest: bool) -> np.ndarray:
        scene = stark.Scene()
        scene.add_floor(10.0)
        box = scene.add_box(0.05, mass=0.2, position=(0.0, 0.0, 0.045), velocity=(0.0, 0.0, -speed))
        if with_rest:
            scene.add_box(0.1, mass=1.0, position=(1.0, 0.0, 0.0505))
        sim = stark.Simulation(scene, {"time.integrator": "bdf2"}, time_step=0.01)
        return np.array([box.contact_force[2] for _ in sim.run(until=0.2)])

    alone = forces(False)
    np.testing.assert_allclose(forces(True), alone, rtol=0.0, atol=1e-3 * alone.max())


@pytest.mark.parametrize("h", [4e-3, 1e-3])
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_rates_of_joints_miss_a_part_of_an_impact_for_three_steps(friction: float, h: float) -> None:
    """As docs/joints.md says: at most 13 % of what the speed of the bar changes by. Then they are right."""
    scene = stark.Scene()
    scene.default_friction = friction
    scene.add_floor(2.0)
    bar = scene.add_box((0.4, 0.05, 0.05), mass=1.0, position=(0.2, 0, 0.3))
    hinge = scene.add_hinge(None, bar, anchor=(0, 0, 0.3), axis="y")
    sim = stark.Simulation(scene, time_step=h, **BDF2)
    sim.run_until(0.05)
    speeds, errors = [], []
    for _ in range(round(0.3 / h)):
        sim.step()
        speeds.append(bar.angular_velocity[1])
        errors.append(abs(hinge.rates["angle"] - speeds[-1]))
    change = max(speeds) - min(speeds)
    assert change > 7.0  # it hits the floor, and comes back
    assert max(errors) < 0.13 * change
    assert (np.array(errors) > 1e-3 * change).sum() <= 3 * (1 + 2)  # of three impacts at most
