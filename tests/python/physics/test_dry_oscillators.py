"""Springs and dry friction: a block that sticks and slips on a belt, a swing that dry friction ends."""

from __future__ import annotations

import numpy as np
from _validation import validate

import stark

GRAVITY = 9.81


@stark.energy
def spring(p: stark.Point, stiffness: float = stark.parameter(unit="N/m", min=0.0)):
    return 0.5 * stiffness * p.x[0] ** 2


def block_on(scene: stark.Scene, start: float, stiffness: float) -> stark.RigidBody:
    """A block of 1 kg at the end of a spring."""
    block = scene.add_box(0.1, mass=1.0, position=(start, 0, 0.05 + 9e-5), name="block")
    scene.add(spring(block.points((0, 0, 0)), stiffness=stiffness))
    return block


def simulation(scene: stark.Scene) -> stark.Simulation:
    settings = {"time.integrator": "bdf2", "contact.stick_velocity": 1e-4}
    return stark.Simulation(scene, time_step=1e-3, contact_distance=5e-5, settings=settings)


def test_a_block_sticks_and_slips_on_a_belt() -> None:
    """It rides until the spring pulls by static friction, and swings about kinetic friction until it is as
    fast as the belt again."""
    stiffness, static, kinetic, speed = 100.0, 0.5, 0.3, 0.1
    scene = stark.Scene()
    belt = scene.add_box((4, 1, 0.1), motion="fixed", position=(0, 0, -0.05), name="belt")
    belt.surface_velocity = (speed, 0, 0)
    block = block_on(scene, 0.0, stiffness)
    scene.friction[block, belt] = static, kinetic
    sim = simulation(scene)
    places, times = [], []
    for report in sim.run(until=3.5):
        places.append(block.position[0])
        times.append(report.time)
    x, t = np.array(places), np.array(times)
    middle = kinetic * GRAVITY / stiffness
    above = np.flatnonzero((x[:-1] < middle) & (x[1:] >= middle))
    crossed = t[above] + (middle - x[above]) / (x[above + 1] - x[above]) * 1e-3
    late = x[t > 1.0]
    validate("stick_slip.period", np.diff(crossed)[1:].mean())
    validate("stick_slip.range", [late.max(), late.min()])


def test_dry_friction_ends_a_swing() -> None:
    """Each half swing is shorter by 2 mu m g / k, until the spring holds no more than friction."""
    scene = stark.Scene()
    scene.default_friction = 0.1
    scene.add_floor()
    block = block_on(scene, 0.05, 400.0)
    sim = simulation(scene)
    x = [0.05]
    for _ in sim.run(until=1.8):
        x.append(block.position[0])
    way = np.diff(x)
    turns = np.flatnonzero((way[:-1] * way[1:] < 0) & (np.abs(way[:-1]) > 1e-7)) + 1
    validate("stick_slip.swings", np.abs(np.array(x)[turns[:9]]))
    assert abs(way[-1]) < 1e-9, "it has come to rest"
