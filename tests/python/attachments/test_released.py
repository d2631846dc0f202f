"""What joints and attachments keep from contact touches again once they release it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

MIDDLE = [16, 17, 23, 24, 25, 31, 32]  # of a sheet of 7 x 7 vertices


def _sheet_on_box(height: float = 0.003, glued: Any = MIDDLE, **options: Any) -> tuple[stark.Scene, Any, Any]:
    scene = stark.Scene()
    box = scene.add_box(0.2, motion="fixed", name="box")
    sheet = scene.add_cloth(stark.mesh.grid(0.15, 0.15, 6), position=(0, 0, 0.1 + height), name="sheet")
    return scene, sheet, scene.attach(sheet.vertices[glued], box, name="glue", **options)


def _hinged(offset: float, **options: Any) -> tuple[stark.Scene, Any, Any]:
    scene = stark.Scene()
    base = scene.add_box(0.1, motion="fixed", name="base")
    arm = scene.add_box(0.1, mass=0.2, position=(0, 0, offset), name="arm")
    return scene, arm, scene.add_hinge(base, arm, anchor=(0, 0, 0), axis=(0, 1, 0), name="pin", **options)


@pytest.mark.parametrize("distance", [5e-4, 2e-3])
def test_cloth_whose_glue_breaks_does_not_sink_into_the_box(distance: float) -> None:
    scene, sheet, glue = _sheet_on_box(break_force=1e-3)
    sim = stark.Simulation(scene, contact_distance=distance)
    for report in sim.run(0.5):
        assert report.caveats == []
        assert sheet.positions[:, 2].min() > 0.1
    assert glue.broken.any()
    assert sheet.positions[:, 2].min() < 0.1 + 3.0 * distance  # it came down


def test_released_hinges_do_not_let_bodies_overlap() -> None:
    scene, arm, pin = _hinged(0.12)
    assert not scene.contact_enabled("base", "arm")
    sim = stark.Simulation(scene)
    sim.run_until(0.05)
    pin.enabled = False
    for report in sim.run(0.4):
        assert report.caveats == [] and arm.position[2] > 0.1
    assert arm.contact_force[2] == pytest.approx(0.2 * 9.81, rel=1e-3)


def test_bodies_that_overlap_when_they_are_released_are_named_until_they_are_apart() -> None:
    scene, _, pin = _hinged(0.09)
    sim = stark.Simulation(scene)
    pin.enabled = False
    report = sim.step()
    assert report.caveats == ["released_overlap"]
    assert "'base' and 'arm' overlap" in report.message and "joint 'pin'" in report.message
    assert "released_overlap" in report.to_dict()["caveats"]
    pin.pull_together()
    assert sim.step().caveats == []


def test_a_release_of_bodies_that_overlap_can_be_an_error() -> None:
    scene, _, pin = _hinged(0.09)
    sim = stark.Simulation(scene, **{"contact.released_overlap": "refuse"})
    sim.step()
    pin.enabled = False
    before = sim.state
    with pytest.raises(stark.InitialIntersection, match=r"'base' and 'arm' overlap.*joint 'pin' released"):
        sim.step()
    assert sim.state == before


def test_glued_flush_parts_are_apart_once_they_have_come_off() -> None:
    scene, sheet, glue = _sheet_on_box(height=0.0, glued=range(49))
    sim = stark.Simulation(scene, contact_distance=1e-3, gravity=(0, 0, 2.0))
    glue.enabled = False
    reports = list(sim.run(0.1))
    assert reports[0].caveats == ["released_overlap"] and reports[-1].caveats == []
    assert len(sim.state.arrays()["contact_regained"]) == 49
    assert sheet.positions[:, 2].min() > 0.1


def test_enabled_contact_of_connected_bodies_overrules_the_joint() -> None:
    scene, _, _ = _hinged(0.12)
    scene.enable_contact("base", "arm")
    assert scene.contact_enabled("base", "arm")
    stark.Simulation(scene).step()
    overlapping, _, _ = _hinged(0.09)
    overlapping.enable_contact("base", "arm")
    with pytest.raises(stark.InitialIntersection, match="'base' and 'arm' intersect"):
        stark.Simulation(overlapping)


@pytest.mark.parametrize("threads", [1, 3])
def test_runs_go_on_from_a_checkpoint_bit_for_bit_after_a_release(tmp_path: Path, threads: int) -> None:
    def simulation() -> stark.Simulation:
        scene, _, _ = _sheet_on_box(break_force=1e-3)
        return stark.Simulation(scene, time_step=0.01, contact_distance=1e-3, threads=threads)

    sim = simulation()
    sim.run_until(0.1)
    regained = sim.state.arrays()["contact_regained"]
    assert len(regained) > 0
    sim.save(tmp_path / "half.npz")
    sim.run_until(0.2)
    again = simulation()
    again.load(tmp_path / "half.npz")
    assert np.array_equal(again.state.arrays()["contact_regained"], regained)
    again.run_until(0.2)
    assert again.state == sim.state
