"""Cardan joints, planetary gears, and gears whose involute teeth touch, by closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

BOTH = pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
Floats = np.ndarray[Any, np.dtype[np.float64]]


def simulated(scene: stark.Scene, step: float, integrator: str, **settings: Any) -> stark.Simulation:
    weightless = {"gravity": (0, 0, 0), "time": {"integrator": integrator}}
    return stark.Simulation(scene, time_step=step, **weightless, **settings)


@BOTH
def test_a_cardan_joint_turns_unevenly(integrator: str) -> None:
    """tan(out) = tan(in) / cos(bend), with the angle counted from the plane of both shafts."""
    scene, bend = stark.Scene(), 0.6
    along = np.array([np.cos(bend), np.sin(bend), 0.0])
    across = np.array([-np.sin(bend), np.cos(bend), 0.0])
    shaft = scene.add_box((0.3, 0.05, 0.05), mass=1.0, position=(-0.2, 0, 0))
    turn = stark.rotation(axis="z", angle=bend)
    driven = scene.add_box((0.3, 0.05, 0.05), mass=1.0, position=0.2 * along, rotation=turn)
    before = scene.add_hinge(None, shaft, anchor=(-0.2, 0, 0), axis="x")
    scene.add_universal(shaft, driven, anchor=(0, 0, 0), axis_a=(0, 0, 1), axis_b=across)
    after = scene.add_hinge(None, driven, anchor=0.2 * along, axis=along)
    before.add_motor(5.0, cap=1e3, delta=1e-3)
    after.add_friction(cap=2.0)
    sim = simulated(scene, 0.005, integrator)
    for _ in sim.run(until=1.5):
        yoke = np.array([0.0, -np.sin(before.angle), np.cos(before.angle)])  # axis_a, which is across `along`
        expected = np.arctan2(np.cross(yoke, along)[2], np.cross(yoke, along) @ across)
        assert abs((after.angle - expected + 0.5 * np.pi) % np.pi - 0.5 * np.pi) < 1e-5
    assert before.angle > 2.0 * np.pi


@BOTH
def test_two_cardan_joints_turn_evenly_again(integrator: str) -> None:
    scene, bend = stark.Scene(), 0.5
    along = np.array([np.cos(bend), np.sin(bend), 0.0])
    across = (-np.sin(bend), np.cos(bend), 0.0)
    far = 0.4 * along
    first = scene.add_box((0.3, 0.05, 0.05), mass=1.0, position=(-0.15, 0, 0))
    turn = stark.rotation(axis="z", angle=bend)
    between = scene.add_box((0.3, 0.03, 0.03), mass=0.5, position=0.5 * far, rotation=turn)
    last = scene.add_box((0.3, 0.05, 0.05), mass=1.0, position=far + np.array([0.15, 0, 0]))
    before = scene.add_hinge(None, first, anchor=(-0.15, 0, 0), axis="x")
    after = scene.add_hinge(None, last, anchor=far + np.array([0.15, 0, 0]), axis="x")
    scene.add_universal(first, between, anchor=(0, 0, 0), axis_a=(0, 0, 1), axis_b=across)
    scene.add_universal(between, last, anchor=far, axis_a=across, axis_b=(0, 0, 1))
    motor = before.add_motor(8.0, cap=100.0, delta=1e-3)
    after.add_friction(cap=3.0)
    torques = []
    for report in simulated(scene, 0.005, integrator).run(until=1.5):
        assert abs(before.angle - after.angle) < 1e-5
        torques += [motor.torque] if report.time > 0.3 else []
    assert np.mean(torques) == pytest.approx(3.0, rel=1e-3)


@BOTH
def test_a_planetary_gear_has_the_ratio_of_willis(integrator: str) -> None:
    """With the ring held, the carrier turns at s / (s + r) of the sun, of s and r teeth, and has (s + r) / s
    of its torque; the brake of the ring has the rest. The frame is turned, and away from the origin."""
    teeth_s, teeth_p = 20, 16
    teeth_r = teeth_s + 2 * teeth_p
    turn, off = stark.rotation(vector=(0.3, 0.4, -0.9)), np.array([1.0, 2.0, 3.0])
    axis, scene = turn[:, 2], stark.Scene()

    def wheel(radius: float, place: Any) -> stark.RigidBody:
        return scene.add_cylinder(radius, 0.01, mass=0.1, position=off + turn @ place, rotation=turn)

    carrier, sun, ring = wheel(0.03, [0, 0, -0.02]), wheel(0.02, [0, 0, 0]), wheel(0.06, [0, 0, 0.03])
    of_carrier = scene.add_hinge(None, carrier, anchor=off, axis=axis)
    in_carrier = [scene.add_hinge(carrier, body, anchor=off, axis=axis) for body in (sun, ring)]
    of_sun, of_ring = (scene.add_hinge(None, body, anchor=off, axis=axis) for body in (sun, ring))
    planets = []
    for angle in 2.0 * np.pi / 3.0 * np.arange(3):
        body = wheel(0.016, [0.036 * np.cos(angle), 0.036 * np.sin(angle), 0])
        planets.append(scene.add_hinge(carrier, body, anchor=body.position, axis=axis))
        planets[-1].add_gear(in_carrier[0], ratio=-teeth_s / teeth_p)
    in_carrier[1].add_gear(planets[0], ratio=teeth_p / teeth_r)
    brake = of_ring.add_brake(cap=100.0)
    motor = of_sun.add_motor(10.0, cap=50.0, delta=1e-3)
    of_carrier.add_friction(cap=1.0)
    sim = simulated(scene, 0.005, integrator, contact={"enabled": False})
    sim.run_until(1.0)
    ratio = teeth_s / (teeth_s + teeth_r)
    assert of_carrier.rates["angle"] / of_sun.rates["angle"] == pytest.approx(ratio, rel=1e-6)
    assert motor.torque == pytest.approx(ratio, rel=1e-3)
    assert brake.torque == pytest.approx(1.0 - ratio, rel=1e-3)


def involute(module: float, teeth: int, turned: float = 0.0) -> stark.TriangleMesh:
    """A wheel 10 mm wide of involute teeth at 20 degrees, with 0.2 mm of play."""
    pressure, pitch = np.radians(20.0), 0.5 * module * teeth
    base, tip, root = pitch * np.cos(pressure), pitch + module, pitch - 1.25 * module
    radii = np.linspace(max(base, root), tip, 12)
    roll = np.arccos(np.minimum(base / radii, 1.0))
    half = 0.5 * np.pi / teeth - 1e-4 / pitch + (np.tan(pressure) - pressure) - (np.tan(roll) - roll)
    centers = turned + 2.0 * np.pi * np.arange(teeth) / teeth
    radius = np.r_[root, radii, radii[::-1], root]
    angle = np.r_[-half[0], -half, half[::-1], half[0]]
    around = (centers[:, None] + angle).ravel()
    outline = np.tile(radius, teeth)[:, None] * np.c_[np.cos(around), np.sin(around)]
    return prism(outline, len(radius))


def prism(outline: Floats, tooth: int) -> stark.TriangleMesh:
    """Each tooth is a strip between its flanks, and their feet a fan about the axis."""
    count = len(outline)
    caps: list[tuple[int, int, int]] = []
    for first in range(0, count, tooth):
        low, high = first, first + tooth - 1
        while high - low > 1:
            caps += [(low, low + 1, high)] + ([(low + 1, high - 1, high)] if high - low > 2 else [])
            low, high = low + 1, high - 1
        following = (first + tooth) % count
        caps += [(2 * count, first, first + tooth - 1), (2 * count, first + tooth - 1, following)]
    below = [(c if c < 2 * count else 2 * count, b, a) for a, b, c in caps]
    above = [tuple(v + count if v < count else 2 * count + 1 for v in t) for t in caps]
    sides = []
    for k in range(count):
        n = (k + 1) % count
        sides += [(k, n, n + count), (k, n + count, k + count)]
    flat = np.vstack([outline, outline, np.zeros((2, 2))])
    z = np.r_[np.full(count, -0.005), np.full(count, 0.005), -0.005, 0.005]
    return stark.TriangleMesh(np.c_[flat, z], np.array(below + above + sides))


@BOTH
def test_involute_teeth_turn_evenly_and_carry_the_torque(integrator: str) -> None:
    """16 on 24 teeth that touch without friction: 2/3 of the speed and of the torque. Where the next tooth
    takes over, within 0.5 mrad."""
    scene, module, teeth = stark.Scene(), 0.005, (16, 24)
    scene.default_friction = 0.0
    apart = 0.5 * module * sum(teeth)
    small = scene.add_rigid(involute(module, teeth[0]), density=7800.0)
    mesh = involute(module, teeth[1], np.pi + np.pi / teeth[1])
    large = scene.add_rigid(mesh, density=7800.0, position=(apart, 0, 0))
    drive = scene.add_hinge(None, small, anchor=(0, 0, 0), axis="z")
    driven = scene.add_hinge(None, large, anchor=(apart, 0, 0), axis="z")
    motor = drive.add_motor(3.0, cap=50.0, delta=1e-3)
    driven.add_friction(cap=0.5)
    sim = simulated(scene, 0.005, integrator, contact_distance=5e-5)
    sim.run_until(0.3)
    torques, errors = [], []
    for _ in sim.run(until=0.3 + 2.0 * np.pi / 3.0 / 16.0 * 4.0):  # four teeth
        torques.append(motor.torque)
        errors.append(driven.angle + drive.angle * teeth[0] / teeth[1])
    assert np.ptp(errors) < 5e-4
    assert np.mean(torques) == pytest.approx(0.5 * teeth[0] / teeth[1], rel=0.01)


@pytest.mark.parametrize(("integrator", "beside"), [("implicit_euler", 0.0), ("bdf2", 0.0), ("bdf2", 1.0)])
def test_a_strong_motor_turns_teeth_that_rub(integrator: str, beside: float) -> None:
    """On the way to the solution of a step a motor pushes with all it has until its wheel moves. Where the
    next tooth came into touch, contact was stiffened a thousandfold for that: the driven wheel was thrown
    to 1.8 times its speed, out of nothing. What moves beside them has no part in it."""
    scene, module, teeth, speed = stark.Scene(), 0.005, (16, 24), 4.0
    scene.default_friction = 0.1
    apart, ratio = 0.5 * module * sum(teeth), teeth[0] / teeth[1]
    narrow = involute(module, teeth[0])
    wide = stark.TriangleMesh(narrow.vertices * (1.0, 1.0, 2.0), narrow.triangles)
    small = scene.add_rigid(wide, mass=0.5)
    mesh = involute(module, teeth[1], np.pi + np.pi / teeth[1])
    large = scene.add_rigid(mesh, mass=1.0, position=(apart, 0, 0))
    drive = scene.add_hinge(None, small, anchor=(0, 0, 0), axis="z")
    driven = scene.add_hinge(None, large, anchor=(apart, 0, 0), axis="z")
    motor = drive.add_motor(speed, cap=50.0, delta=0.01)
    brake = driven.add_friction(cap=0.5)
    cart = scene.add_box(0.1, motion="scripted", position=(0, 1, 0))
    sim = simulated(scene, 0.001, integrator, contact_distance=5e-5)
    cart.velocity = (0, beside, 0)
    stored, fastest, given, taken = 0.0, 0.0, 0.0, 0.0
    for report in sim.run(until=0.02 if beside else 0.15):
        assert report.contact_energy_at_start < stored + 1e-3  # the wheels have 0.02 J
        stored = report.energy["contact"]
        fastest = max(fastest, abs(driven.rates["angle"]))
        if report.time > 0.05:
            given += motor.power * report.time_step
            taken += report.energy["friction"] - brake.power * report.time_step
    assert fastest < 1.2 * ratio * speed
    assert given == pytest.approx(taken, rel=0.02)  # and what they speed up by
