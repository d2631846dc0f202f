"""Energy that integration creates is named, and limits a certificate where it is much."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from verify._recorded_runs import record

import stark
from stark.recording import Recorder
from stark.verify import Certificate, verify

G = 9.81


def limits_of_energy(certificate: Certificate) -> list[str]:
    return [limit for limit in certificate.limits if limit.startswith("integration created")]


def test_a_joint_that_pulls_its_body_together_creates_energy(tmp_path: Path) -> None:
    """A fall of 0.2 s and back in one step of 1 ms: (gap / h)^2 / 2 J a kilogram, lost in the step after."""
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    joint = scene.add_fixed(None, box, anchor=(0, 0, 0))
    sim = stark.Simulation(scene, time_step=1e-3)
    with Recorder(tmp_path, sim, certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        joint.enabled = False
        for report in sim.run(until=0.25):
            recorder.report(report)
            recorder.record_state(sim)
            if abs(report.time - 0.2) < 1e-6:
                gap = float(np.linalg.norm(box.position))
                joint.pull_together()
        recorder.record(sim)
    certificate = verify(tmp_path)
    (limit,) = limits_of_energy(certificate)
    created = 0.5 * (gap / 1e-3) ** 2
    assert f"created {created:.3g} J from 0.2 s to 0.201 s, 100 % of the largest energy" in limit
    assert certificate.verdict == "certified"  # the ledger closes; the limit says at what price
    assert f"integration created {created:.3g} J and dissipated" in certificate["energy_ledger"].detail


def test_bodies_that_turn_while_they_are_pressed_create_next_to_nothing(tmp_path: Path) -> None:
    """Two spheres that a spring presses together, 10 rad/s at 5 ms: what bdf2 created was most of what there
    was."""
    scene = stark.Scene()
    scene.default_friction, r, w = 0.5, 0.0101, 10.0
    a, b = (
        scene.add_sphere(
            0.01, mass=0.01, position=(s * r, 0, 0), velocity=(0, s * w * r, 0), angular_velocity=(0, 0, w)
        )
        for s in (-1.0, 1.0)
    )
    scene.add_span(a, b, (-r, 0, 0), (r, 0, 0), contact=True).add_spring(100.0, rest=0.0102)
    bdf2 = {"time.integrator": "bdf2"}
    folder = record(tmp_path, scene, 60, time_step=5e-3, gravity=(0, 0, 0), **bdf2)
    certificate = verify(folder)
    assert certificate.verdict == "certified"
    assert not limits_of_energy(certificate)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_ordinary_runs_create_next_to_nothing(tmp_path: Path, integrator: str) -> None:
    """A pendulum and a ball that bounces on a cloth."""
    scene = stark.Scene()
    arm = scene.add_box((0.4, 0.05, 0.05), mass=1.0, position=(0.2, 0.0, 1.0))
    scene.add_hinge(None, arm, anchor=(0.0, 0.0, 1.0), axis="y")
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, cells=6), pins=[0, 6, 42, 48], position=(2.0, 0.0, 0.0))
    scene.add_sphere(0.03, mass=0.05, position=(2.0, 0.0, 0.06))
    certificate = verify(record(tmp_path, scene, 60, time_step=0.01, **{"time.integrator": integrator}))
    assert not limits_of_energy(certificate)
    assert "integration created" in certificate["energy_ledger"].detail


def test_what_the_tolerance_of_joints_lets_the_weight_do_is_no_energy(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_ball(None, scene.add_box(0.1, mass=0.1), anchor=(0, 0, 0))
    assert not limits_of_energy(verify(record(tmp_path, scene, 10, time_step=0.01)))
