"""Energies that depend on the time: what they gain as it goes on is work of the ledger, so that the balance
closes from the end of one step to the end of the next, and certificates hold. [theory eq. 27b]"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import stark
from stark.recording import Recorder
from stark.verify import verify

INTEGRATORS = ("implicit_euler", "bdf2", "quasistatic")
STORED = ("kinetic", "elastic", "gravity", "contact")
SUPPLIED = ("external", "placed", "actuation", "restitution", "belts")


@stark.energy
def push(p: stark.Point, t: stark.Time, force: float = 10.0):
    return -force * t * p.x[0]


@stark.energy
def steady(p: stark.Point, force: float = 0.0):
    return -force * p.x[0]


@stark.energy
def swinging(a: stark.Point, b: stark.Point, t: stark.Time, h: stark.TimeStep, k: float = 50.0):
    """A spring whose rest length swings, with a damper."""
    d, v = a.x - b.x, a.v - b.v
    length = 0.3 + 0.05 * stark.sin(20 * t)
    return 0.5 * k * (stark.sqrt(d @ d) - length) ** 2 + 0.5 * h * (v @ v)


@stark.material(stress_free=False)
def shrinking_solid(F: stark.DeformationGradient, t: stark.Time, mu: float = 1e4, bulk: float = 2e4):
    E = 0.5 * (F.T @ F - (1 - t) * stark.identity(3))
    return mu * stark.squared_norm(E) + 0.5 * bulk * stark.trace(E) ** 2


@stark.material(stress_free=False)
def flowing(
    F: stark.DeformationGradient, h: stark.TimeStep, t: stark.Time, flow: stark.Mat3 = stark.internal(0.0)
):
    """Shrinks, and relaxes within 50 ms."""
    E = 0.5 * (F.T @ F - (1 - t) * stark.identity(3))
    ratio, trial = h / 0.05, E - flow
    psi = 1e4 * stark.squared_norm(E) + 2e4 / (1 + ratio) * stark.squared_norm(trial)
    return psi, {"flow": flow + ratio / (1 + ratio) * trial}


@stark.material(stress_free=False)
def shrinking(stretch, curvature, twist, t: stark.Time):
    return 50.0 * (stretch - 1 + t) ** 2 + 1e-3 * (curvature @ curvature) + 1e-3 * twist**2


def a_point(scene: stark.Scene) -> None:
    scene.add(push(scene.add_box(0.1, mass=1.0).points((0.01, 0.02, 0.03))))


def a_spring(scene: stark.Scene) -> None:
    ball = scene.add_sphere(0.05, mass=0.1)
    box = scene.add_box(0.1, mass=1.0, position=(0.4, 0, 0))
    scene.add(swinging(ball.points((0, 0.05, 0)), box.points((0, 0, 0))))


def a_solid(law: Callable[..., stark.SolidMaterial], cubes: bool) -> Callable[[stark.Scene], None]:
    def build(scene: stark.Scene) -> None:
        mesh = stark.mesh.box_hexahedra(0.1, 2) if cubes else stark.mesh.tet_box(0.1, 2)
        scene.add_solid(mesh, law(density=500.0), pins=mesh.vertices[:, 2] > 0.049)

    return build


def a_rod(scene: stark.Scene) -> None:
    law = shrinking(base=stark.RodMaterial(density=1000.0, youngs_modulus=1e6, radius=0.005))
    scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.3, 0, 0), 6), law, clamps=[0])


SCENES = {
    "point": a_point,
    "spring": a_spring,
    "tetrahedra": a_solid(shrinking_solid, cubes=False),
    "hexahedra": a_solid(shrinking_solid, cubes=True),
    "flowing": a_solid(flowing, cubes=True),
    "rod": a_rod,
}


def imbalances(sim: stark.Simulation, steps: int) -> list[float]:
    """What the energy stored at the end of each step is off from that at the end of the one before and all
    terms, over the largest of them."""
    off, before = [], None
    for _ in range(steps):
        energy = sim.step().energy
        stored = sum(energy[name] for name in STORED)
        given = sum(energy[name] for name in SUPPLIED)
        lost = energy["damping"] + energy["friction"] + energy["numerical"]
        if before is not None:
            off.append(abs(stored - before - given + lost) / max(map(abs, energy.values())))
        before = stored
    return off


#: Nothing holds the free bodies of the first two in quasistatic steps.
CASES = [(n, i) for n in SCENES for i in INTEGRATORS if i != "quasistatic" or n not in ("point", "spring")]


@pytest.mark.parametrize(("name", "integrator"), CASES)
def test_the_balance_closes_from_step_to_step(name: str, integrator: str) -> None:
    scene = stark.Scene()
    SCENES[name](scene)
    sim = stark.Simulation(scene, {"time.integrator": integrator}, time_step=0.01)
    assert max(imbalances(sim, 8)) < 1e-11


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_the_work_of_time_is_that_of_a_growing_force(integrator: str) -> None:
    """m x'' = F t: x = F t^3 / 6 m, and time alone changes -F t x by -F x dt, in all by -F^2 t^4 / 24 m."""
    force, until = 10.0, 1.0
    errors = []
    for step in (0.02, 0.01):
        scene = stark.Scene()
        scene.add(push(scene.add_box(0.1, mass=1.0).points((0, 0, 0)), force=force))
        sim = stark.Simulation(scene, {"time.integrator": integrator}, time_step=step, gravity=(0, 0, 0))
        work = sum(report.energy["external"] for report in sim.run(until=until))
        errors.append(abs(work / (-(force**2) * until**4 / 24) - 1))
    assert errors[1] < 0.05
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_live_value_of_the_same_course_gives_the_same_energy_between_steps(integrator: str) -> None:
    work = {}
    for name, energy in {"external": push, "placed": steady}.items():
        scene = stark.Scene()
        load = scene.add(energy(scene.add_box(0.1, mass=1.0).points((0, 0, 0))))
        sim = stark.Simulation(scene, {"time.integrator": integrator}, time_step=0.01, gravity=(0, 0, 0))
        work[name] = []
        for _ in range(20):
            if name == "placed":
                load.force = 10.0 * (sim.time + 0.01)
            work[name].append(sim.step().energy[name])
    assert work["external"] == pytest.approx(work["placed"], rel=1e-9, abs=1e-15)


def test_actuators_of_the_time_need_no_more_than_their_own_work() -> None:
    @stark.actuator
    def winding(c: stark.Coordinate, t: stark.Time, k: float = 2.0):
        return 0.5 * k * (c.q - t) ** 2

    scene = stark.Scene()
    wheel = scene.add_box(0.1, mass=1.0)
    hinge = scene.add_hinge(wheel, None, anchor=(0, 0, 0), axis=(0, 0, 1))
    scene.add_actuator(winding, hinge)
    sim = stark.Simulation(scene, time_step=0.01)
    assert max(imbalances(sim, 20)) < 1e-11
    report = sim.step()
    assert report.energy["external"] == 0.0
    assert report.energy["actuation"] != 0.0


def test_values_set_after_a_rewind_give_what_they_do_at_the_time_of_the_state() -> None:
    scene = stark.Scene()
    load = scene.add(push(scene.add_box(0.1, mass=1.0, position=(2, 0, 0)).points((0, 0, 0)), force=1.0))
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    assert load.energy == 0.0  # at time 0
    state = sim.state
    for _ in range(5):
        sim.step()
    assert load.energy == pytest.approx(-0.05 * 2.0, rel=1e-3)
    sim.state = state
    assert load.energy == 0.0
    load.force = 7.0
    assert sim.step().energy["placed"] == 0.0


def test_an_energy_that_is_not_finite_at_time_0_is_refused() -> None:
    @stark.energy
    def fading(p: stark.Point, t: stark.Time):
        return p.x[0] / t

    scene = stark.Scene()
    scene.add(fading(scene.add_box(0.1, mass=1.0, position=(2, 0, 0)).points((0, 0, 0))))
    with pytest.raises(
        stark.InvalidArgument, match="'fading': element 0 has an energy of inf when the time is 0"
    ):
        stark.Simulation(scene)


@pytest.mark.parametrize("name", ["point", "flowing"])
def test_runs_with_energies_of_the_time_are_certified(name: str, tmp_path: Path) -> None:
    scene = stark.Scene()
    SCENES[name](scene)
    sim = stark.Simulation(scene, {"time.integrator": "bdf2"}, time_step=0.01)
    with Recorder(
        tmp_path / "run", sim, settings=sim.settings.to_dict(), scene=name, certify=True
    ) as recorder:
        recorder.record_state(sim)
        for report in sim.run(until=0.3):
            recorder.report(report)
            recorder.record_state(sim)
    certificate = verify(tmp_path / "run")
    (ledger,) = (claim for claim in certificate.claims if claim.name == "energy_ledger")
    assert ledger.status == "verified", ledger.detail
    assert certificate.verdict == "certified", certificate.text()
    assert not [limit for limit in certificate.limits if "created" in limit]
    assert np.isfinite(ledger.worst)
