"""Free rigid bodies against closed forms and conservation laws."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import G, advance

import stark

SIZE = (0.10, 0.06, 0.02)  # a block with three different moments of inertia
TIGHT = {
    "newton.residual_tolerance": 1e-10,
    "newton.acceleration_tolerance": 0.0,
    "newton.step_tolerance": 0.0,
}


def angular_momentum(body: Any) -> np.ndarray:
    return body.rotation @ body.inertia @ body.rotation.T @ body.angular_velocity


def test_free_fall_is_implicit_eulers() -> None:
    scene = stark.Scene()
    body = scene.add_box(SIZE, density=800.0, velocity=(1.0, 0.0, 2.0))
    h, n = 0.01, 100
    sim = stark.Simulation(scene, time_step=h)
    advance(sim, n * h)
    # Exact up to the residual; at 0.01 m/s^2 that would be 5e-3 m, here the first iteration solves a
    # quadratic.
    assert body.position == pytest.approx((1.0, 0.0, 2.0 - G * h * h * n * (n + 1) / 2), abs=1e-9)
    assert body.velocity == pytest.approx((1.0, 0.0, 2.0 - G * n * h), abs=1e-9)


def test_moments_of_inertia_of_a_block() -> None:
    body = stark.Scene().add_box(SIZE, density=800.0)
    a, b, c = SIZE
    mass = 800.0 * a * b * c
    expected = mass / 12.0 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
    assert body.mass == pytest.approx(mass, rel=1e-12)
    assert body.inertia == pytest.approx(expected, rel=1e-12, abs=1e-18)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize("h", [1 / 60, 0.01, 0.002])
def test_angular_momentum_of_a_free_body_is_kept(integrator: str, h: float) -> None:
    """At default tolerances: what Newton's method leaves is an error of the place, not of the momentum."""
    scene = stark.Scene()
    body = scene.add_box(SIZE, density=800.0, angular_velocity=(4.0, 6.0, 3.0))
    sim = stark.Simulation(scene, time_step=h, gravity=(0, 0, 0), **{"time.integrator": integrator})
    before = angular_momentum(body)
    advance(sim, 2.0)
    # Rounding: 1e-16 a step, for up to 1000 steps.
    assert np.linalg.norm(angular_momentum(body) - before) < 1e-11 * np.linalg.norm(before)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_tumbling_keeps_its_energy(integrator: str) -> None:
    """Moments 1 : 2 : 3 about the middle axis, 10 rad/s, 10 s of steps of 1/60 s. The midpoint rule on the
    group is symmetric: its energy swings by (w k)^2/24 where a substep k turns by 0.05 rad, without drift."""
    scene = stark.Scene()
    inertia = (1.0, (0.0, 0.0, 0.0), np.diag([0.01, 0.02, 0.03]))
    scene.add_box(0.1, inertia=inertia, angular_velocity=(0.01, 10.0, 0.01))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **{"time.integrator": integrator})
    kinetic = [report.energy["kinetic"] for report in advance(sim, 10.0)]
    assert np.ptp(kinetic) < 1e-4 * kinetic[0]


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_free_needle_keeps_momentum_and_energy(integrator: str) -> None:
    """5 mm long, 30 um thick: an error of place of 1e-7 rad is a spin of 10 rad/s, so whatever the integrator
    carries from step to step must not grow."""
    scene = stark.Scene()
    needle = scene.add_box((5e-3, 3e-5, 2.9e-5), density=1000.0, angular_velocity=(61.0, 1579.0, 43.0))
    sim = stark.Simulation(scene, time_step=6e-4, gravity=(0, 0, 0), **{"time.integrator": integrator})
    momentum = angular_momentum(needle)
    energy = momentum @ needle.angular_velocity
    advance(sim, 0.06)
    assert np.linalg.norm(angular_momentum(needle) - momentum) < 1e-12 * np.linalg.norm(momentum)
    assert angular_momentum(needle) @ needle.angular_velocity == pytest.approx(energy, rel=1e-9)


def test_rotation_stays_a_rotation() -> None:
    scene = stark.Scene()
    body = scene.add_box(SIZE, density=800.0, angular_velocity=(4.0, 6.0, 3.0))
    sim = stark.Simulation(scene, time_step=0.01)
    advance(sim, 1.0)
    assert body.rotation @ body.rotation.T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(body.rotation) == pytest.approx(1.0, abs=1e-14)


def test_intermediate_axis_flips() -> None:
    """Dzhanibekov: rotation about the middle axis turns over, the first time after 0.965 s (Euler's
    equations, integrated for w = (0.1, 10, 0) rad/s); those about the other axes do not."""
    scene = stark.Scene()
    middle = scene.add_box(SIZE, density=800.0, angular_velocity=(0.1, 10.0, 0.0), name="middle")
    for name, w, place in (("long", (10.0, 0.1, 0.0), 1.0), ("short", (0.1, 0.0, 10.0), 2.0)):
        scene.add_box(SIZE, density=800.0, angular_velocity=w, name=name, position=(place, 0, 0))
    sim = stark.Simulation(scene, time_step=1e-3, gravity=(0, 0, 0))
    axes = {"middle": 1, "long": 0, "short": 2}
    lowest = dict.fromkeys(axes, 1.0)
    flipped = None
    for _ in range(1200):
        report = sim.step()
        assert not report.failed
        for name, k in axes.items():
            along = float(sim[name].rotation[k, k])
            lowest[name] = min(lowest[name], along)
            if name == "middle" and flipped is None and along < 0.0:
                flipped = sim.time
    assert lowest["middle"] < -0.8 and flipped is not None
    # Free motion is that of Euler's equations: substeps of 0.05 rad of a rule of second order.
    assert flipped == pytest.approx(0.965, rel=1e-3)
    assert lowest["long"] > 0.9 and lowest["short"] > 0.9
    assert middle.position == pytest.approx((0, 0, 0), abs=1e-12)


@pytest.mark.parametrize("mu", [0.0, 0.6])
def test_collision_of_two_free_bodies_keeps_momentum(mu: float) -> None:
    scene = stark.Scene()
    a = scene.add_box(
        SIZE, density=800.0, velocity=(1.0, 0.1, 0.0), angular_velocity=(0.0, 0.0, 2.0), name="a"
    )
    b = scene.add_sphere(
        0.03, subdivisions=2, density=500.0, position=(0.12, 0.02, 0.004), velocity=(-0.5, 0, 0), name="b"
    )
    scene.friction[a, b] = mu
    sim = stark.Simulation(scene, time_step=1e-3, gravity=(0, 0, 0), contact_distance=5e-4, **TIGHT)

    def momentum() -> np.ndarray:
        return a.mass * a.velocity + b.mass * b.velocity

    def total_angular() -> np.ndarray:
        orbital = sum(np.cross(x.position, x.mass * x.velocity) for x in (a, b))
        return orbital + angular_momentum(a) + angular_momentum(b)

    linear, angular = momentum(), total_angular()
    touched = False
    for report in advance(sim, 0.15):
        touched |= report.contact_count > 0
    assert touched and abs(a.velocity[0] - 1.0) > 0.1
    scale = a.mass * 1.0 + b.mass * 0.5
    # Internal forces cancel pair by pair; what is left is the residual, 1e-10 N for 0.15 s.
    assert np.linalg.norm(momentum() - linear) < 1e-9 * scale
    # Implicit Euler keeps angular momentum to first order only: levers turn within the step (w h = 2e-3 to
    # 2e-2).
    assert np.linalg.norm(total_angular() - angular) < 0.03 * scale * 0.05


@pytest.mark.parametrize(
    ("integrator", "speed"), [("implicit_euler", 60.0), ("bdf2", 60.0), ("implicit_euler", 5.0)]
)
def test_a_driven_hinge_without_friction_takes_no_torque(integrator: str, speed: float) -> None:
    """A rotor that turns at the speed of its motor, 0.6 rad a step: nothing brakes it."""
    scene = stark.Scene()
    inertia = (1.0, (0.0, 0.0, 0.0), np.diag([3e-3, 4e-3, 5e-3]))
    rotor = scene.add_box(0.1, inertia=inertia, angular_velocity=(0, 0, speed))
    hinge = scene.add_hinge(None, rotor, anchor=(0, 0, 0), axis=(0, 0, 1))
    motor = hinge.add_motor(target=speed, cap=10.0, delta=1.0)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **{"time.integrator": integrator})
    for _ in sim.run(until=0.5):
        assert abs(motor.torque) < 1e-9
    assert rotor.angular_velocity == pytest.approx((0, 0, speed), abs=1e-9)


@pytest.mark.parametrize(
    ("integrator", "allowed"), [("implicit_euler", (5e-3, 0.5, 5e-3)), ("bdf2", (2e-4, 2e-3, 1e-5))]
)
def test_a_fast_top_precesses(integrator: str, allowed: tuple[float, float, float]) -> None:
    """A top of 150 rad/s on its tip under its weight: steady precession p at the tilt a is the slow root of
    J1 cos a p^2 - J3 w3 p + m g l = 0 [Goldstein 1980, sec. 5.7]. 1 ms for 1 s; implicit Euler is of first
    order in the torque."""
    mass, length, spin, tilt = 0.5, 0.05, 150.0, 0.3
    centre = np.diag([8e-4, 8e-4, 5e-4])
    J1, J3 = 8e-4 + mass * length**2, 5e-4
    a, b = J1 * np.cos(tilt), J3 * spin
    precession = (b - np.sqrt(b * b - 4.0 * a * mass * G * length)) / (2.0 * a)
    rotation = np.asarray(stark.rotation(axis="x", angle=tilt))
    axis = rotation[:, 2]
    w = precession * np.array([0.0, 0.0, 1.0]) + (spin - precession * np.cos(tilt)) * axis
    scene = stark.Scene()
    top = scene.add_box(
        0.05,
        inertia=(mass, (0, 0, 0), centre),
        position=length * axis,
        rotation=rotation,
        velocity=np.cross(w, length * axis),
        angular_velocity=w,
    )
    scene.add_ball(None, top, anchor=(0, 0, 0))
    sim = stark.Simulation(scene, time_step=1e-3, **{"time.integrator": integrator})
    azimuth = [np.arctan2(axis[1], axis[0])]
    for _ in sim.run(until=1.0):
        axis = top.rotation[:, 2]
        azimuth.append(np.arctan2(axis[1], axis[0]))
    turned = np.unwrap(azimuth)
    assert turned[-1] - turned[0] == pytest.approx(precession, rel=allowed[0])
    assert abs(np.arccos(axis[2]) - tilt) < allowed[1] * stark.deg
    assert top.angular_velocity @ axis == pytest.approx(spin, rel=allowed[2])


@pytest.mark.parametrize(("step", "gain"), [(2e-3, 0.030), (1e-3, 0.0036)])
def test_a_top_that_nods_gains_energy_by_the_third_power_of_the_step(step: float, gain: float) -> None:
    """docs/integrators.md: with bdf2, in 10 s."""
    axes = np.asarray(stark.rotation(axis="y", angle=0.5))
    inertia = np.diag([1.167e-4, 1.167e-4, 2.25e-4])
    scene = stark.Scene()
    top = scene.add_box(
        0.02,
        inertia=(0.5, (0, 0, 0), inertia),
        position=0.05 * axes[:, 2],
        rotation=axes,
        angular_velocity=150.0 * axes[:, 2],
    )
    scene.add_ball(None, top, anchor=(0, 0, 0))
    sim = stark.Simulation(scene, time_step=step, time={"integrator": "bdf2"})
    reports = list(sim.run(until=10.0))
    energies = [report.energy["kinetic"] + report.energy["gravity"] for report in reports]
    whole = 0.5 * inertia[2, 2] * 150.0**2
    assert (energies[-1] - energies[0]) / whole == pytest.approx(gain, rel=0.1)
    shown = -sum(report.energy["numerical"] for report in reports[1:])
    assert shown == pytest.approx(energies[-1] - energies[0], rel=0.01)


def gyroscope(spin: float, integrator: str) -> stark.Simulation:
    """A disc of 0.2 kg on an arm of 0.1 m that turns about z and nods about y, at the default step."""
    scene = stark.Scene()
    post = scene.add_box(0.02, mass=0.05)
    arm = scene.add_box((0.1, 0.01, 0.01), mass=0.02, position=(0.05, 0, 0))
    about_x = stark.rotation(axis="y", angle=90 * stark.deg)
    place = {"position": (0.1, 0, 0), "rotation": about_x, "angular_velocity": (spin, 0, 0)}
    disc = scene.add_cylinder(0.04, 0.01, mass=0.2, name="disc", **place)
    scene.add_hinge(None, post, anchor=(0, 0, 0), axis=(0, 0, 1))
    scene.add_hinge(post, arm, anchor=(0, 0, 0), axis=(0, 1, 0))
    scene.add_hinge(arm, disc, anchor=(0.1, 0, 0), axis=(1, 0, 0))
    return stark.Simulation(scene, **{"time.integrator": integrator})


@pytest.mark.parametrize("spin", [100.0, 300.0])
@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_gyroscope_gains_no_energy_at_the_default_step(integrator: str, spin: float) -> None:
    """Bearings that hold the axis must not drive its nutation: with steps of a quarter turn of the disc the
    energy grew by a factor of 100 and more. The error of bdf2 is of third order in the step: 2 % in 1 s."""
    sim = gyroscope(spin, integrator)
    start = 0.5 * sim["disc"].inertia[2, 2] * spin**2
    energies = [sum(r.energy[key] for key in ("kinetic", "gravity")) for r in advance(sim, 1.0)]
    assert max(energies) <= start * (1.0 + (0.02 if integrator == "bdf2" else 1e-6))


def test_a_gyroscope_precesses_at_its_rate() -> None:
    """The torque of the weight over the angular momentum, within the nutation of a start at rest."""
    spin = 300.0
    sim = gyroscope(spin, "bdf2")
    way = [np.arctan2(sim["disc"].position[1], sim["disc"].position[0]) for _report in sim.run(until=1.0)]
    turned = np.unwrap(way)[-1]
    inertia = sim["disc"].inertia[2, 2]
    assert turned == pytest.approx((0.2 * 0.1 + 0.02 * 0.05) * G / (inertia * spin), rel=0.05)


def test_what_a_joint_holds_loses_angular_momentum_to_implicit_euler() -> None:
    """docs/troubleshooting.md: a point at a distance loses the share w^2 h of it a second, 29 % in the first
    second from 10 rad/s with steps of 5 ms; and a motor that keeps its speed takes m r^2 w^3 h."""
    scene = stark.Scene()
    ball = scene.add_sphere(
        0.01, mass=1.0, position=(0.2, 0, 0), velocity=(0, 2, 0), angular_velocity=(0, 0, 10)
    )
    hinge = scene.add_hinge(None, ball, anchor=(0, 0, 0), axis="z")
    sim = stark.Simulation(scene, time_step=0.005, gravity=(0, 0, 0))
    sim.run_until(1.0)
    assert hinge.rates["angle"] == pytest.approx(10.0 / np.sqrt(1 + 2 * 100 * 0.005), rel=0.01)

    driven = stark.Scene()
    ball = driven.add_sphere(0.01, mass=1.0, position=(0.2, 0, 0))
    hinge = driven.add_hinge(None, ball, anchor=(0, 0, 0), axis="z")
    motor = hinge.add_motor(target=5.0, cap=10.0, delta=1e-3)
    sim = stark.Simulation(driven, time_step=0.005, gravity=(0, 0, 0))
    sim.run_until(0.5)
    assert motor.torque == pytest.approx(0.2**2 * 5.0**3 * 0.005, rel=0.01)
