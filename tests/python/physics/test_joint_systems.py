"""Many joints at the default settings: long chains, a curtain of closed loops, masses of different orders."""

from __future__ import annotations

import numpy as np
import pytest
from _mechanisms import Work, bar, simulate
from _validation import validate

import stark

G = 9.81  # [m/s^2]
LINK, LINK_MASS = 0.1, 0.1  # [m], [kg]
STEP = 0.01  # [s]
LENGTH_TOLERANCE, ANGLE_TOLERANCE = 1e-6, 1e-5  # [m], [rad], the defaults


def chain(links: int, *, load: float | None = None) -> tuple[stark.Scene, list[stark.RigidBody]]:
    """Links along x, joined by hinges and balls in turn and held at the origin; a ball of `load` [kg] at its
    end."""
    scene = stark.Scene()
    bodies: list[stark.RigidBody] = []
    for k in range(links):
        at = (LINK * k, 0, 0)
        link = bar(scene, at, (LINK * (k + 1), 0, 0), mass=LINK_MASS)
        last = bodies[-1] if bodies else None
        if k % 2:
            scene.add_ball(last, link, anchor=at)
        else:
            scene.add_hinge(last, link, anchor=at, axis=(0, 1, 0))
        bodies.append(link)
    if load is not None:
        end = (LINK * links, 0, 0)
        weight = scene.add_sphere(LINK, subdivisions=1, mass=load, position=end)
        scene.add_ball(bodies[-1], weight, anchor=end)
        bodies.append(weight)
    return scene, bodies


def run(sim: stark.Simulation, until: float, look_every: int = 1) -> tuple[Work, list[float]]:
    """Work, and mechanical energy [J] after each step; looks at the joints every so many steps."""
    work, energies = Work(), []
    for k, report in enumerate(sim.run(until)):
        assert not report.failed, report.message
        work.add(report)
        if k % look_every == 0:
            work.look_at(sim.joints)
        energies.append(report.energy["kinetic"] + report.energy["gravity"])
    return work, energies


def test_chain_of_50_links_for_10_s() -> None:
    scene, _ = chain(50)
    work, energies = run(simulate(scene, STEP), 10.0)
    validate("chain.iterations", work.mean_iterations)
    validate("chain.retried", work.retried)
    assert work.worst_residual <= ANGLE_TOLERANCE
    # Implicit Euler only loses energy. Joints are within their tolerance, which at a tension of 100 N is
    # 1e-4 J of work; steps solved to 0.01 m/s^2 add as much.
    assert np.max(np.diff(energies)) < 0.01
    # Damped, it has come near to hanging straight down: its lowest energy is -m g l/2 = -122.6 J.
    lowest = -50 * LINK_MASS * G * 50 * LINK / 2
    assert lowest < energies[-1] < 0.0


def hang(load: float, links: int = 50) -> Work:
    """A chain that hangs straight down for 0.5 s, with a ball of ``load`` [kg] at its end."""
    scene = stark.Scene()
    last = None
    for k in range(links):
        at = (0, 0, -LINK * k)
        link = bar(scene, at, (0, 0, -LINK * (k + 1)), mass=LINK_MASS)
        scene.add_ball(last, link, anchor=at)
        last = link
    end = (0, 0, -LINK * links)
    weight = scene.add_sphere(LINK, subdivisions=1, mass=load, position=end)
    scene.add_ball(last, weight, anchor=end)
    # A distance of 1e-6 m in a step is a force of 10 N on a weight of 1 t.
    return run(simulate(scene, STEP, **{"joints.length_tolerance": 1e-9}), 0.5)[0]


@pytest.mark.parametrize("load", [1e3, 1e-5])
def test_weight_of_a_loaded_chain_arrives_at_its_support(load: float) -> None:
    """A weight of 1e4 times, or 1e-4 times, the mass of a link."""
    work = hang(load)
    name = "heavy" if load > 1.0 else "light"
    validate(f"mass_ratio.{name}_support", work.reaction[2])
    validate(f"mass_ratio.{name}_iterations", work.mean_iterations)
    assert work.retried == 0


def test_chain_swings_a_weight_of_1e4_times_the_mass_of_a_link() -> None:
    scene, bodies = chain(50, load=1e4 * LINK_MASS)
    sim = simulate(scene, STEP)
    work, energies = run(sim, 2.0)
    validate("mass_ratio.swing_iterations", work.mean_iterations)
    validate("mass_ratio.swing_retried", work.retried)
    assert work.worst_residual <= ANGLE_TOLERANCE
    # A taut chain: the weight stays on a circle of 5 m, inside of which it may be where links fold.
    assert np.linalg.norm(bodies[-1].position) <= 50 * LINK + 51 * LENGTH_TOLERANCE
    assert np.max(np.diff(energies)) < 1e-3 * abs(energies[-1])


def curtain(cells: int) -> stark.Scene:
    """Square net of bars with balls at its nodes, its first row of nodes held: closed loops everywhere."""
    scene = stark.Scene()
    first_at: dict[tuple[int, int], stark.RigidBody] = {}
    for i in range(cells + 1):
        for j in range(cells + 1):
            for other in ((i + 1, j), (i, j + 1)):
                if max(other) > cells or other[0] == i == 0:  # no bars along the row that is held
                    continue
                ends = [(LINK * p, LINK * q, 0.0) for p, q in ((i, j), other)]
                body = bar(scene, *ends, mass=LINK_MASS)
                for node, at in zip(((i, j), other), ends, strict=True):
                    if node in first_at:
                        scene.add_ball(first_at[node], body, anchor=at)
                    else:
                        first_at[node] = body
    for j in range(cells + 1):
        scene.add_ball(None, first_at[0, j], anchor=(0, LINK * j, 0))
    return scene


@pytest.mark.slow
def test_a_thousand_joints_in_closed_loops() -> None:
    scene = curtain(19)
    assert len(scene.joints) > 1000
    work, energies = run(simulate(scene, STEP), 1.0, look_every=20)
    validate("loops.iterations", work.mean_iterations)
    validate("loops.retried", work.retried)
    assert work.worst_residual <= LENGTH_TOLERANCE
    assert np.max(np.diff(energies)) < 1e-3 * abs(energies[-1])


def test_small_curtain_falls_and_holds() -> None:
    scene = curtain(5)
    work, _ = run(simulate(scene, STEP), 1.0)
    validate("loops.small_iterations", work.mean_iterations)
    validate("loops.small_retried", work.retried)
    assert work.worst_residual <= LENGTH_TOLERANCE
