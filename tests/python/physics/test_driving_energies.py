"""Energies of users that push what is at rest, as wind does: the ledger has their work as external, so that
what it calls numerical is the error of the integrator and falls with the step. [theory eq. 27a]"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import stark
from stark.recording import Recorder
from stark.verify import verify


@stark.energy
def drag(p: stark.Point, h: stark.TimeStep, air: stark.Vec3, c: float = 1.0):
    u = p.v - air
    return 0.5 * h * c * (u @ u)


@stark.energy
def thrust(f: stark.Frame, force: float):
    return -force * ((f.origin - f.origin_prev) @ f.axes_prev[:, 0])


@stark.energy
def sprung(p: stark.Point, h: stark.TimeStep, k: float, c: float):
    """A spring to the start and a damper: nothing that drives."""
    return 0.5 * k * ((p.x - p.x0) @ (p.x - p.x0)) + 0.5 * h * c * (p.v @ p.v)


@stark.energy
def wind(t: stark.Triangle, h: stark.TimeStep, air: stark.Vec3, density: float = 1.2):
    area = stark.cross(t[1].x_prev - t[0].x_prev, t[2].x_prev - t[0].x_prev) / 2
    u = ((t[0].v + t[1].v + t[2].v) / 3 - air) @ area / stark.norm(area)
    return h * density * stark.norm(area) * stark.sqrt(u * u + 1e-6) ** 3 / 6


def turned_over(sim: stark.Simulation, until: float) -> Counter:
    total: Counter = Counter()
    for report in sim.run(until=until):
        assert not report.failed, report.message
        total.update(report.energy)
        total["stored"] = report.energy["kinetic"] + report.energy["elastic"]
    return total


def box(**more: object) -> tuple[stark.Scene, stark.RigidBody]:
    scene = stark.Scene()
    return scene, scene.add_box(0.1, mass=1.0, **more)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_the_work_of_wind_on_a_box_is_external(integrator: str) -> None:
    """m dv/dt = c (w - v): v = w (1 - exp(-c t/m)). The wind would do c w s on a box at rest, along its
    way s, of which c v^2 dt is lost."""
    c, w, until = 1.0, 3.0, 0.3
    v = w * (1 - np.exp(-c * until))
    way = w * (until - (1 - np.exp(-c * until)) / c)
    errors = []
    for step in (0.01, 0.005):
        scene, body = box()
        scene.add(drag(body.points((0, 0, 0)), air=(w, 0, 0), c=c))
        sim = stark.Simulation(scene, {"time.integrator": integrator}, time_step=step, gravity=(0, 0, 0))
        ledger = turned_over(sim, until)
        assert ledger["external"] == pytest.approx(c * w * way, rel=3 * step)
        assert ledger["damping"] == pytest.approx(c * w * way - 0.5 * v**2, rel=6 * step)
        assert ledger["stored"] == pytest.approx(0.5 * v**2, rel=2 * step)
        errors.append(abs(ledger["numerical"]))
    assert errors[1] < 0.6 * errors[0] < 0.6 * 0.05 * ledger["stored"]


def test_the_work_of_thrust_along_a_body_that_turns_is_external() -> None:
    spin, force, until = 1.0, 1.0, 1.0
    scene, body = box(angular_velocity=(0, 0, spin))
    scene.add(thrust(body, force=force))
    sim = stark.Simulation(scene, {"time.integrator": "bdf2"}, time_step=0.005, gravity=(0, 0, 0))
    ledger = turned_over(sim, until)
    velocity = force / spin * np.array([np.sin(spin * until), 1 - np.cos(spin * until), 0])
    assert body.velocity == pytest.approx(velocity, abs=0.01)
    assert ledger["external"] == pytest.approx(0.5 * velocity @ velocity, rel=0.01)
    assert abs(ledger["numerical"]) < 0.01 * ledger["external"]


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_what_stores_and_dissipates_does_no_external_work(integrator: str) -> None:
    scene, body = box(velocity=(1, 0, 0))
    scene.add(sprung(body.points((0, 0, 0)), k=50.0, c=0.5))
    sim = stark.Simulation(scene, {"time.integrator": integrator}, time_step=0.005, gravity=(0, 0, 0))
    ledger = turned_over(sim, 0.5)
    assert ledger["external"] == 0.0
    assert ledger["damping"] > 0.05
    # The spring stores k x^2 / 2, whatever the step: no part of the damper.
    assert sim.step().energy["elastic"] == pytest.approx(
        25.0 * float(body.position @ body.position), rel=1e-9
    )


def flag() -> stark.Scene:
    scene = stark.Scene()
    scene.name = "flag"
    sheet = stark.mesh.grid(1.2, 0.8, cells=(8, 6))
    pole = [k for k, x in enumerate(sheet.vertices) if x[0] < -0.59]
    cloth = scene.add_cloth(sheet, rotation=stark.rotation(axis="x", angle=90 * stark.deg), pins=pole)
    scene.add(wind(cloth.faces, air=(6.0, 1.0, 0.0)))
    return scene


def test_a_certificate_of_a_flag_in_the_wind_finds_no_energy_from_nowhere(tmp_path: Path) -> None:
    sim = stark.Simulation(flag(), time_step=1 / 60)
    with Recorder(
        tmp_path / "run", sim, settings=sim.settings.to_dict(), scene="flag", certify=True
    ) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for report in sim.run(until=0.5):
            assert not report.failed, report.message
            recorder.report(report)
            recorder.record_state(sim)
        recorder.record(sim)
    certificate = verify(tmp_path / "run")
    assert certificate.verdict == "certified", certificate.text()
    assert not [limit for limit in certificate.limits if "created" in limit]


def test_energies_that_are_not_defined_beyond_their_end_count_as_stored() -> None:
    """A logarithm that ends where the box is going."""

    @stark.energy
    def wall(p: stark.Point, h: stark.TimeStep, k: float, c: float):
        return -k * stark.log(1.0 - p.x[0]) + 0.5 * h * c * (p.v @ p.v)

    scene, body = box(velocity=(1, 0, 0))
    scene.add(wall(body.points((0, 0, 0)), k=0.2, c=0.1))
    sim = stark.Simulation(scene, time_step=0.002, gravity=(0, 0, 0))
    ledger = turned_over(sim, 1.5)
    assert ledger["external"] == pytest.approx(0.0, abs=1e-6)
    assert np.isfinite(ledger["numerical"]) and ledger["numerical"] > -1e-6
