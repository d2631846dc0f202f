"""Gases and liquids inside closed surfaces against closed forms, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _load_scenes import advance, block_with_a_hole, simulate

import stark
from stark import scenes
from stark.recording import Recording

ROOT = Path(__file__).resolve().parents[3]
OUTSIDE = 101325.0  # [Pa]


def limp(
    density: float = 1.0, thickness: float = 1e-4, modulus: float = 1e2, **values: Any
) -> stark.ShellMaterial:
    return stark.ShellMaterial(
        density=density,
        thickness=thickness,
        youngs_modulus=modulus,
        poissons_ratio=0.3,
        bending_stiffness=0.0,
        **values,
    )


def volume(body: Any) -> float:
    a, b, c = (body.positions[body.triangles[:, i]] for i in range(3))
    return float(np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0)


def over_outside(filling: Any) -> float:
    return -filling.total_slopes["volume"]


def piston(scene: stark.Scene) -> tuple[stark.Cloth, np.ndarray]:
    """A closed box of 0.1 m of cloth, all of it held, whose lid can be moved."""
    mesh = stark.mesh.box(0.1)
    skin = scene.add_cloth(mesh, limp(), pins=list(range(len(mesh.vertices))), self_contact=False)
    return skin, np.flatnonzero(skin.mesh.vertices[:, 2] > 0.049)


def held_with(skin: stark.Cloth, lid: np.ndarray, lift: list[float]) -> np.ndarray:
    """Targets of all vertices, those of the lid moved."""
    targets = np.array(skin.mesh.vertices)
    targets[lid] += lift
    return targets


@pytest.mark.parametrize("exponent", [1.0, 1.4, 1.67])
def test_pressure_of_a_gas_follows_its_volume(exponent: float) -> None:
    """p V^gamma is constant; a pump that adds gas of the same entropy raises p with amount^gamma."""
    scene = stark.Scene()
    skin, lid = piston(scene)
    gas = scene.add_gas(skin, 2e4, exponent=exponent)
    sim = simulate(scene)
    for step in range(1, 6):
        skin.pin_targets = held_with(skin, lid, [0.0, 0.0, -0.01 * step])
        assert not sim.step().failed
        assert gas.volume == pytest.approx(1e-3 * (1 - 0.1 * step), rel=1e-12)
        expected = (OUTSIDE + 2e4) * (1e-3 / gas.volume) ** exponent
        assert over_outside(gas) + OUTSIDE == pytest.approx(expected, rel=1e-12)
    gas.amount = 1.3
    assert not sim.step().failed
    expected = (OUTSIDE + 2e4) * (1.3 * 1e-3 / gas.volume) ** exponent
    assert over_outside(gas) + OUTSIDE == pytest.approx(expected, rel=1e-12)
    # What it stores is the work of pressing it together, less that of the air outside.
    work = _work(OUTSIDE + 2e4, exponent, gas.volume)
    gas.amount = 1.0
    assert not sim.step().failed
    assert gas.energy == pytest.approx(work, rel=1e-9)


def _work(pressure: float, exponent: float, end: float) -> float:
    """Integral of -(p - outside) dV from 1e-3 m^3 on [J]."""
    start = 1e-3
    if exponent == 1.0:
        inner = -pressure * start * np.log(end / start)
    else:
        inner = pressure * start / (exponent - 1.0) * ((start / end) ** (exponent - 1.0) - 1.0)
    return float(inner + OUTSIDE * (end - start))


@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_a_limp_balloon_breathes_at_the_frequency_of_its_gas(exponent: float) -> None:
    """Skin of mass m about a gas of the pressure outside: omega^2 = 12 pi gamma p R/m, the skin apart. The
    polyhedron has masses and areas of its own: V' by m-weighted inertia, 3 V for 4 pi R^3."""
    scene = stark.Scene()
    ball = scene.add_cloth(stark.mesh.sphere(0.1, 3), limp(density=5.0, thickness=1e-3), self_contact=False)
    rest = ball.mesh.vertices
    gas = scene.add_gas(ball, exponent=exponent)
    mass = ball.mass
    inertia = mass * float(np.mean(np.sum(rest**2, axis=1)))
    omega = np.sqrt(exponent * OUTSIDE * 9.0 * volume_of(ball.mesh) / inertia)
    period = 2.0 * np.pi / omega
    sim = simulate(scene, period / 400, **{"time.integrator": "bdf2"})
    ball.velocities = rest * 0.5  # breathing: 5 cm/s
    volumes, times = [volume_of(ball.mesh)], [0.0]
    for _ in range(620):
        report = sim.step()
        assert not report.failed, report.message
        volumes.append(gas.volume)
        times.append(report.time)
    found = crossings(np.array(times), np.array(volumes) - volumes[0])
    assert found[1] - found[0] == pytest.approx(period / 2, rel=0.02)
    assert found[2] - found[0] == pytest.approx(period, rel=0.01)


def volume_of(mesh: Any) -> float:
    return abs(float(mesh.volume))


def crossings(t: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Times at which y changes its sign, by linear interpolation."""
    k = np.flatnonzero(np.sign(y[1:-1]) != np.sign(y[2:])) + 1
    return np.asarray(t[k] - y[k] * (t[k + 1] - t[k]) / (y[k + 1] - y[k]))


def test_a_thin_skin_with_gas_is_stable_at_large_steps() -> None:
    """A law in the loop of a user, a step behind, wants steps of 1/1300 s here (K = 106 kPa)."""
    scene = stark.Scene()
    ball = scene.add_cloth(
        stark.mesh.sphere(0.1, 2), limp(density=5.5, thickness=5e-4, modulus=1e6, mass_damping=5.0)
    )
    gas = scene.add_gas(ball, 5000.0)
    sim = simulate(scene, 1 / 60)
    pressures = []
    for report in sim.run(until=3.0):
        assert not report.failed
        assert report.newton_iterations <= 8
        pressures.append(over_outside(gas))
    assert max(pressures[-10:]) - min(pressures[-10:]) < 1.0
    assert 0.0 < pressures[-1] < 5000.0
    assert (OUTSIDE + pressures[-1]) * gas.volume == pytest.approx(
        (OUTSIDE + 5000.0) * volume_of(ball.mesh), rel=1e-12
    )


def test_a_pump_fills_a_bag_and_a_leak_empties_it() -> None:
    scene = stark.Scene()
    skin, _ = piston(scene)
    gas = scene.add_gas(skin, amount=lambda t: 1.0 + t)
    sim = simulate(scene)
    advance(sim, 0.5)
    assert over_outside(gas) == pytest.approx(0.5 * OUTSIDE, rel=1e-12)
    gas.amount = 0.25
    assert not sim.step().failed
    assert over_outside(gas) == pytest.approx(-0.75 * OUTSIDE, rel=1e-12)


@pytest.mark.parametrize("modulus", [1e6, 2.2e9])
def test_a_bag_of_liquid_carries_a_load_without_change_of_volume(modulus: float) -> None:
    """A plate of 2 N on a bag of water: V/V_l - 1 = -p/K, and iterations do not grow with K."""
    scene = stark.Scene()
    floor = scene.add_floor()
    bag = scene.add_cloth(
        stark.mesh.sphere(0.05, 2), limp(density=17.0, thickness=1e-3, modulus=1e5, mass_damping=5.0),
        position=(0, 0, 0.0515), self_contact=False,
    )  # fmt: skip
    plate = scene.add_box((0.2, 0.2, 0.01), mass=0.2, position=(0, 0, 0.1085))
    for body in (floor, plate):
        scene.friction[bag, body] = 0.5
    liquid = scene.add_liquid(bag, bulk_modulus=modulus)
    sim = stark.Simulation(scene, time_step=1 / 100)
    iterations = []
    for report in sim.run(until=1.5):
        assert not report.failed, report.message
        iterations.append(report.newton_iterations)
    pressure = over_outside(liquid)
    assert liquid.volume == pytest.approx(volume(bag), rel=1e-12)
    assert liquid.volume / volume_of(bag.mesh) - 1.0 == pytest.approx(
        -pressure / modulus, rel=1e-6, abs=1e-15
    )
    assert np.mean(iterations) < 12.0
    # Pressure on the flat of the plate and the pull of the skin carry 2 N together with its tension.
    assert pressure > 100.0
    assert plate.contact_force[2] == pytest.approx(0.2 * 9.81, rel=0.02)


def test_the_example_keeps_its_promises(tmp_path: Path) -> None:
    result = scenes.run(
        scenes.load(ROOT / "examples/water_balloon.py"), out=tmp_path / "run", replay=False, picture=False
    )
    assert (result.status, result.message) == ("complete", "check passed")
    assert Recording(tmp_path / "run").telemetry["newton_iterations"].sum() < 1000


def test_a_liquid_that_is_pulled_parts() -> None:
    scene = stark.Scene()
    skin, lid = piston(scene)
    liquid = scene.add_liquid(skin)
    sim = simulate(scene)
    for lift in (1e-8, 1e-7, 0.01):
        skin.pin_targets = held_with(skin, lid, [0.0, 0.0, lift])
        assert not sim.step().failed
        stretch = 2.2e9 * (liquid.volume / 1e-3 - 1.0)
        assert over_outside(liquid) == pytest.approx(-min(stretch, OUTSIDE), rel=1e-6)


def test_a_cavity_of_a_solid_holds_gas() -> None:
    """By itself gas of the pressure outside does nothing; over that it swells the block evenly about it."""
    scene = stark.Scene()
    block = scene.add_solid(block_with_a_hole(), stark.materials.silicone)
    x = block.mesh.vertices
    inside = np.abs(x[np.array(block.triangles)]).max(
        axis=(1, 2)
    ) < 0.051  # fmt: skip
    gas = scene.add_gas(block.faces[inside])
    sim = simulate(scene)
    assert not sim.step().failed
    assert np.abs(block.velocities).max() < 1e-9
    gas.amount = 1.2
    advance(sim, 0.3)
    assert gas.volume > 1e-3
    assert over_outside(gas) == pytest.approx(OUTSIDE * (1.2 * 1e-3 / gas.volume - 1.0), rel=1e-9)
    assert np.abs(sim.step().momentum).max() < 1e-9


def test_bad_fillings_are_refused() -> None:
    scene = stark.Scene()
    ball = scene.add_cloth(stark.mesh.sphere(0.1, 1), limp())
    sheet = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), limp(), position=(1, 0, 0))
    with pytest.raises(stark.InvalidArgument, match=r"gas on .* surface is not closed"):
        scene.add_gas(sheet)
    with pytest.raises(stark.InvalidArgument, match=r"gas: pressure = -200000.0 Pa over 101325.0 Pa outside"):
        scene.add_gas(ball, -2e5)
    with pytest.raises(stark.InvalidArgument, match=r"gas: exponent = 0\.5: must be at least 1"):
        scene.add_gas(ball, exponent=0.5)
    with pytest.raises(stark.InvalidArgument, match="bulk_modulus"):
        scene.add_liquid(ball, bulk_modulus=0.0)
    with pytest.raises(stark.InvalidArgument, match="filling"):
        scene.add_liquid(ball, -1.0)


@pytest.mark.parametrize("value", [None, "x", [1.0, 2.0], (), {}, lambda t: 1e5])
@pytest.mark.parametrize("name", ["pressure", "outside", "exponent"])
def test_numbers_of_a_gas_are_numbers(name: str, value: Any) -> None:
    """They were added to others first: a TypeError of Python."""
    scene = stark.Scene()
    ball = scene.add_cloth(stark.mesh.sphere(0.1, 1), limp())
    with pytest.raises(stark.InvalidArgument, match=rf"gas: {name} = .*: must be a number"):
        scene.add_gas(ball, **{name: value})
    assert not scene.energies


def test_who_looks_for_the_pressure_is_told_where_it_is() -> None:
    scene = stark.Scene()
    gas = scene.add_gas(scene.add_cloth(stark.mesh.sphere(0.1, 1)), name="air")
    with pytest.raises(
        AttributeError, match=r"its totals are volume; total_slopes\['volume'\] .*minus its pressure"
    ):
        _ = gas.pressure
