"""Conveyor belts, turntables and tracks against closed forms: what surfaces that move along themselves do to
what lies on them."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _helpers import G

import stark

INTEGRATORS = ("implicit_euler", "bdf2")
MU, SPEED, H = 0.3, 0.6, 0.005


def belt_and_box(
    integrator: str = "implicit_euler", tilt: float = 0.0, h: float = H, **settings: Any
) -> stark.Simulation:
    """A box of 1 kg at rest on a belt that rests, too, and rises by ``tilt`` [rad] along x."""
    scene = stark.Scene()
    scene.default_friction = MU
    turn = stark.rotation(axis="y", angle=-tilt)
    belt = scene.add_box((3.0, 0.4, 0.1), motion="fixed", rotation=turn, name="belt")
    belt.surface_velocity = (0, 0, 0)
    up = turn @ (0, 0, 1)
    scene.add_box(0.1, mass=1.0, rotation=turn, position=0.1009 * up, contact_distance=5e-4, name="box")
    belt_settings = {"contact.distance": 5e-4, "time.integrator": integrator, **settings}
    sim = stark.Simulation(scene, time_step=h, **belt_settings)
    sim.run_until(0.2)
    return sim


def along(sim: stark.Simulation, tilt: float = 0.0) -> tuple[float, float]:
    """Place [m] and speed [m/s] of the box along the belt."""
    axis = stark.rotation(axis="y", angle=-tilt) @ (1, 0, 0)
    return float(sim["box"].position @ axis), float(sim["box"].velocity @ axis)


def closed(before: dict[str, float], energy: dict[str, float], contact: float) -> float:
    """What is left of the balance of a step [J]."""
    stored = ("kinetic", "elastic", "gravity")
    change = sum(energy[key] - before[key] for key in stored) + energy["contact"] - contact
    supplied = sum(energy[key] for key in ("external", "actuation", "belts", "restitution"))
    return change - supplied + sum(energy[key] for key in ("damping", "friction", "numerical"))


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_box_slides_until_it_has_the_speed_of_the_belt(integrator: str) -> None:
    """It gains mu g until it has the speed v, after v / (mu g) and v^2 / (2 mu g); the drive does m v^2, of
    which friction takes half."""
    sim = belt_and_box(integrator)
    sim["belt"].surface_velocity = (SPEED, 0, 0)
    start, duration = along(sim)[0], SPEED / (MU * G)
    work = loss = worst = 0.0
    before, speeds = None, []
    for n, report in enumerate(sim.run(until=0.2 + 2 * duration), start=1):
        if 10 * H < n * H < duration - H:
            speeds.append(along(sim)[1])
        if before is not None:
            worst = max(worst, abs(closed(before, report.energy, report.contact_energy_at_start)))
        before = report.energy
        work, loss = work + report.energy["belts"], loss + report.energy["friction"]
        if integrator == "implicit_euler":
            assert report.energy["friction"] >= -report.bristle_energy_at_start - 1e-12
    # bdf2 takes some steps to the slope of a force that begins at once.
    assert np.diff(speeds) == pytest.approx(MU * G * H, rel=1e-3)
    place, speed = along(sim)
    assert speed == pytest.approx(SPEED, rel=1e-6)
    # The places of implicit Euler are those of velocities at the ends of steps: half a step of the speed.
    expected = SPEED**2 / (2 * MU * G) + SPEED * (sim.time - 0.2 - duration)
    assert place - start == pytest.approx(expected, abs=0.55 * SPEED * H)
    assert work == pytest.approx(SPEED**2, rel=0.03)
    assert loss == pytest.approx(0.5 * SPEED**2, rel=0.05)
    assert worst < 1e-12
    pairs = sim.contacts.of("box", "belt")
    assert np.abs(pairs.slips).max() < 1e-5  # against the material


@pytest.mark.parametrize("tilt, holds", [(0.2, True), (0.35, False)])
def test_an_inclined_belt_carries_what_friction_holds(tilt: float, holds: bool) -> None:
    """Up with mu g cos - g sin to the speed of the belt, where tan is below mu; else it slides down."""
    sim = belt_and_box(tilt=tilt)
    first = along(sim, tilt)[1]
    sim["belt"].surface_velocity = (SPEED, 0, 0)
    gain = G * (MU * np.cos(tilt) - np.sin(tilt))
    steps = 20
    for _ in range(steps):
        sim.step()
    assert along(sim, tilt)[1] - first == pytest.approx(gain * steps * H, rel=5e-3)
    if holds:
        sim.run_until(sim.time + SPEED / gain)
        start, time = along(sim, tilt)[0], sim.time
        sim.run_until(time + 0.3)
        place, speed = along(sim, tilt)
        assert speed == pytest.approx(SPEED, rel=1e-6)
        assert (place - start) / (sim.time - time) == pytest.approx(SPEED, rel=1e-5)  # no creep


def turntable(radius: float, spin: Any, integrator: str, h: float = H) -> stark.Simulation:
    """A puck of 0.1 kg at a distance from the axis of a disk whose surface turns."""
    scene = stark.Scene()
    scene.default_friction = MU
    table = scene.add_box((1.6, 1.6, 0.1), motion="fixed", position=(0.3, 0.1, -0.05), name="table")
    table.surface_center = (-0.3, -0.1, 0.0)  # the origin of the world
    table.surface_spin = spin
    scene.add_box(0.02, mass=0.1, position=(radius, 0, 0.0109), name="puck")
    more = {"contact.distance": 5e-4, "time.integrator": integrator}
    return stark.Simulation(scene, time_step=h, **more)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_turntable_carries_what_holds_on_to_it(integrator: str) -> None:
    """Below w^2 r = mu g a puck goes round with the table, keeps its distance from the axis and its face
    to it."""
    radius, spin = 0.2, 2.0  # w^2 r = 0.27 mu g
    sim = turntable(radius, lambda t: (0, 0, spin * min(t / 0.2, 1.0)), integrator)
    sim.run_until(0.5)
    where, time = sim["puck"].position, sim.time
    start = np.arctan2(where[1], where[0])
    turn = sim["puck"].rotation
    sim.run_until(1.5)
    x, y = sim["puck"].position[:2]
    assert np.hypot(x, y) == pytest.approx(np.hypot(*where[:2]), abs=2e-7)
    angle = spin * (sim.time - time)
    assert np.arctan2(y, x) - start == pytest.approx(angle, abs=2e-4)
    gone = stark.rotation(axis="z", angle=angle) @ turn
    assert np.abs(sim["puck"].rotation - gone).max() < 1e-3


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_what_turns_too_fast_slips(integrator: str) -> None:
    """The spin rises slowly: the puck leaves its circle where w^2 r = mu g."""
    radius, rate = 0.2, 2.0
    sim = turntable(radius, lambda t: (0, 0, 3.0 + rate * t), integrator)
    # It starts at rest: give it the speed of the table.
    sim["puck"].velocity = (0, 3.0 * radius, 0)
    sim["puck"].angular_velocity = (0, 0, 3.0)
    limit = np.sqrt(np.sqrt((MU * G / radius) ** 2 - rate**2))
    found = None
    for report in sim.run(until=1.0):
        distance = np.hypot(*sim["puck"].position[:2])
        if distance > 1.0005 * radius:
            found = 3.0 + rate * report.time
            break
        if 3.0 + rate * report.time < 0.95 * limit:
            assert distance == pytest.approx(radius, abs=2e-5)
    # What is left of the pull, 2 w r rate t, takes 60 ms to move it by 0.1 mm.
    assert found is not None and limit < found < 1.04 * limit


def test_a_belt_turns_a_wheel_that_lies_on_it() -> None:
    """A wheel on a hinge, pressed by its weight on a belt, rolls at v / r."""
    scene = stark.Scene()
    scene.default_friction = 0.5
    belt = scene.add_box((2.0, 0.4, 0.1), motion="fixed", position=(0, 0, -0.05))
    belt.surface_velocity = (-0.4, 0, 0)
    lying, place = stark.rotation(axis="x", angle=90 * stark.deg), (0, 0, 0.1009)
    wheel = scene.add_cylinder(0.1, 0.05, segments=96, mass=1.0, rotation=lying, position=place)
    fork = scene.add_box(0.02, mass=0.1, position=(0, 0, 0.3), name="fork")
    scene.disable_contact(fork, wheel)
    scene.add_slider(None, fork, (0, 0, 0.3), (0, 0, 1))
    axle = scene.add_hinge(fork, wheel, (0, 0, 0.1009), (0, 1, 0))
    sim = stark.Simulation(scene, time_step=H, **{"contact.distance": 5e-4})
    sim.run_until(0.6)
    start = axle.angle
    sim.run_until(1.1)
    assert abs(axle.angle - start) == pytest.approx(0.4 / 0.1 * 0.5, rel=0.01)


def test_a_tracked_body_drives_off_on_its_own_belt() -> None:
    """A dynamic body whose surface moves back at v moves forward at v, after v / (mu g); what drives it does
    m v^2."""
    scene = stark.Scene()
    scene.default_friction = MU
    scene.add_floor(4.0)
    tank = scene.add_box((0.4, 0.3, 0.1), mass=5.0, position=(0, 0, 0.0509))
    tank.surface_velocity = (-SPEED, 0, 0)
    sim = stark.Simulation(scene, time_step=H, **{"contact.distance": 5e-4})
    work = sum(report.energy["belts"] for report in sim.run(until=0.6))
    assert tank.velocity[0] == pytest.approx(SPEED, rel=1e-5)
    assert work == pytest.approx(5.0 * SPEED**2, rel=0.03)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_belts_carry_cloth_and_rods(integrator: str) -> None:
    scene = stark.Scene()
    scene.default_friction = 0.6
    belt = scene.add_box((2.0, 1.0, 0.1), motion="fixed", position=(0, 0, -0.05))
    belt.surface_velocity = lambda t: (0.3 * min(t / 0.2, 1.0), 0, 0)
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 4), stark.materials.cotton, position=(0, -0.2, 2.9e-3))
    line = stark.mesh.polyline((0, 0, 0), (0.2, 0, 0), 8)
    material = stark.RodMaterial(radius=2e-3, youngs_modulus=1e7, density=1100.0)
    rod = scene.add_rod(
        line, material, position=(0, 0.2, 2.9e-3), rotation=stark.rotation(axis="z", angle=0.5)
    )
    more = {"contact.distance": 1e-3, "time.integrator": integrator}
    sim = stark.Simulation(scene, time_step=0.01, **more)
    sim.run_until(0.5)
    before = [body.positions[:, 0].copy() for body in (cloth, rod)]
    energies = [report.energy for report in sim.run(until=0.8)]
    for body, x in zip((cloth, rod), before, strict=True):
        assert body.positions[:, 0] - x == pytest.approx(0.3 * 0.3, abs=2e-5)
    work, drag = (sum(energy[key] for energy in energies) for key in ("belts", "damping"))
    assert work == pytest.approx(
        drag, rel=0.05
    )  # of the air, to the tolerance of forces; nothing else resists
    assert abs(sum(energy["friction"] for energy in energies)) < 1e-9


def test_friction_of_belts_may_depend_on_the_direction() -> None:
    """Grooves along x on a belt that moves obliquely: the force of sliding is that of the ellipse."""
    along_x, across, steps = 0.1, 0.4, 10
    scene = stark.Scene()
    belt = scene.add_box((2.0, 2.0, 0.1), motion="fixed", position=(0, 0, -0.05))
    belt.surface_direction, belt.surface_velocity = (1, 0, 0), (0, 0, 0)
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.0509))
    scene.friction[box, belt] = stark.Anisotropic(along_x, across)
    sim = stark.Simulation(scene, time_step=1e-3, **{"contact.distance": 5e-4})
    sim.run_until(0.1)
    belt.surface_velocity = (3.0, 4.0, 0)
    for _ in range(steps):
        sim.step()
    squares = np.array([along_x**2, across**2])
    force = G * squares * (3.0, 4.0) / np.sqrt(squares @ (9.0, 16.0))
    # The slip turns by the speed of the box over that of the belt, 1 %.
    assert box.velocity[:2] == pytest.approx(force * steps * 1e-3, rel=0.02)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_motion_of_the_belt_adds_to_that_of_its_body(integrator: str) -> None:
    """A belt on a cart that goes along y, turned by a right angle: its x is the y of the world."""
    scene = stark.Scene()
    scene.default_friction = MU
    cart = scene.add_box((2.0, 0.5, 0.1), motion="scripted", position=(0, 0, -0.05), velocity=(0.1, 0.2, 0),
                         rotation=stark.rotation(axis="z", angle=90 * stark.deg))  # fmt: skip
    cart.surface_velocity = (0.3, 0, 0)
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.0509))
    sim = stark.Simulation(scene, time_step=H, **{"contact.distance": 5e-4, "time.integrator": integrator})
    sim.run_until(0.5)
    assert box.velocity == pytest.approx([0.1, 0.5, 0], abs=1e-5)


def test_quasistatic_steps_carry_along() -> None:
    scene = stark.Scene()
    scene.default_friction = MU
    belt = scene.add_box((2.0, 0.4, 0.1), motion="fixed", position=(0, 0, -0.05))
    belt.surface_velocity = (0.3, 0, 0)
    soft = stark.SolidMaterial(density=300.0, youngs_modulus=2e4)
    block = scene.add_solid(stark.mesh.tet_box(0.1, 2), soft, position=(0, 0, 0.0509))
    settings = {"contact.distance": 1e-3, "time.integrator": "quasistatic"}
    sim = stark.Simulation(scene, time_step=0.01, **settings)
    sim.run_until(0.1)
    start = block.positions[:, 0].copy()
    sim.run_until(0.2)
    assert block.positions[:, 0] - start == pytest.approx(0.03, abs=1e-5)


@pytest.mark.slow
def test_the_example_carries_a_box_a_block_and_a_towel(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(Path(__file__).parents[3] / "examples/conveyor.py"))["main"]()
    assert (tmp_path / "out/conveyor.png").stat().st_size > 10_000
