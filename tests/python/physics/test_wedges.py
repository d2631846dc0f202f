"""Wedges: what drives out, holds itself, and gives way on its side, by closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import stark

SLOPE = 0.4  # [rad]
GAP = 5e-4  # contact distance [m]
LOAD = 200.0  # on the ram, beside its weight [N]


def driven_wedge(mu: float, step: float, integrator: str) -> tuple[stark.Simulation, stark.RigidBody]:
    """A wedge of 0.5 kg on a floor, thin at +x, under a ram of 5 kg on a vertical slider."""
    scene = stark.Scene()
    scene.default_friction = mu
    scene.add_box((10, 4, 0.1), motion="fixed", position=(0, 0, -0.05), name="floor")
    rise, low = np.tan(SLOPE), 0.1

    def block(corners: list[tuple[float, float]]) -> stark.TriangleMesh:
        return stark.mesh.convex_hull(np.array([(x, y, z) for x, z in corners for y in (-0.1, 0.1)]))

    def top(x: float) -> float:
        return float(low + (0.4 - x) * rise)

    wedge = block([(0, 0), (0.4, 0), (0, top(0)), (0.4, top(0.4))])
    ram = block([(0.1, top(0.1)), (0.3, top(0.3)), (0.1, top(0) + 0.1), (0.3, top(0) + 0.1)])
    body = scene.add_rigid(wedge, mass=0.5, position=(0, 0, GAP), name="wedge")
    press = scene.add_rigid(ram, mass=5.0, position=(0, 0, GAP + GAP / np.cos(SLOPE)), name="ram")
    scene.add_slider(None, press, anchor=(0.2, 0, top(0) + 0.05), axis="z")
    scene.add_force(press, (0, 0, -LOAD))
    sim = stark.Simulation(scene, time_step=step, contact_distance=GAP, time={"integrator": integrator})
    return sim, body


def acceleration(mu: float) -> float:
    """Of the wedge along x, with the normal forces n of the ram and f of the floor as the other unknowns."""
    s, c, m, ram = np.sin(SLOPE), np.cos(SLOPE), 0.5, 5.0
    matrix = [[m, s - mu * c, -mu], [0.0, -c - mu * s, 1.0], [ram * np.tan(SLOPE), -c - mu * s, 0.0]]
    return float(np.linalg.solve(matrix, [0.0, m * 9.81, -LOAD - ram * 9.81])[0])


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize("step", [0.01, 0.005])
def test_a_wedge_is_driven_out_near_its_limit(step: float, integrator: str) -> None:
    """Friction presses it, which makes more friction: half of each change comes again. 1.5 %: it starts with
    an impact, after which it trembles."""
    mu = 0.9 * np.tan(0.5 * SLOPE)
    sim, wedge = driven_wedge(mu, step, integrator)
    sim.run_until(0.05)
    before = wedge.velocity[0]
    caveats = [report.caveats for report in sim.run(until=0.1)]
    assert (wedge.velocity[0] - before) / 0.05 == pytest.approx(acceleration(mu), rel=0.015)
    assert sum("old_friction" in each for each in caveats) <= len(caveats) // 4
    pairs = sim.contacts.of("wedge", "ram")
    slip = np.linalg.norm(pairs.frictions.sum(axis=0)) / np.linalg.norm(pairs.normal_forces.sum(axis=0))
    assert slip == pytest.approx(mu, rel=2e-3)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_wedge_holds_itself_above_half_of_its_slope(integrator: str) -> None:
    sim, wedge = driven_wedge(1.03 * np.tan(0.5 * SLOPE), 0.01, integrator)
    sim.run_until(0.5)
    place = wedge.position[0]
    sim.run_until(1.0)
    assert abs(wedge.position[0] - place) < 1e-6  # no creep


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_block_on_a_wedge_pushes_it_away(integrator: str) -> None:
    """Without friction, by -m g sin cos / (M + m sin^2), and slides by (M + m) g sin / (M + m sin^2)."""
    scene, slope, wedge_mass = stark.Scene(), 0.5, 4.0
    scene.default_friction = 0.0
    height = np.tan(slope)
    corners = [(0, 0), (1, 0), (0, height)]
    hull = stark.mesh.convex_hull(np.array([(x, y, z) for x, z in corners for y in (-0.2, 0.2)]))
    scene.add_box((10, 4, 0.1), motion="fixed", position=(0, 0, -0.05))
    wedge = scene.add_rigid(hull, mass=wedge_mass, position=(0, 0, GAP))
    along, up = np.array([np.cos(slope), 0, -np.sin(slope)]), np.array([np.sin(slope), 0, np.cos(slope)])
    place = np.array([0, 0, height + GAP]) + 0.25 * along + (0.05 + GAP) * up
    block = scene.add_box(0.1, mass=1.0, position=place, rotation=stark.rotation(axis="y", angle=slope))
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=GAP, time={"integrator": integrator})
    sim.run_until(0.1)
    before = wedge.velocity[0], (block.velocity - wedge.velocity) @ along
    sim.run_until(0.3)
    moved = wedge.mass + np.sin(slope) ** 2
    pushed = -9.81 * np.sin(slope) * np.cos(slope) / moved
    assert (wedge.velocity[0] - before[0]) / 0.2 == pytest.approx(pushed, rel=1e-3)
    slid = (wedge_mass + 1.0) * 9.81 * np.sin(slope) / moved
    assert ((block.velocity - wedge.velocity) @ along - before[1]) / 0.2 == pytest.approx(slid, rel=1e-3)
