"""Bodies attached to themselves touch themselves everywhere but at the seam."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark
from stark.recording import Recorder, Recording
from stark.verify import verify

RADIUS, LENGTH, AROUND, ALONG = 0.05, 0.1, 24, 4


def sewn_tube(gap: float, *, break_force: float = np.inf) -> tuple:
    """A flat sheet without friction, bent to a tube and sewn along the top, `gap` [m] open; its lower half is
    a fixed trough, and the seam is pressed down on it with 0.05 N a vertex. Returns scene, cloth, seam, and
    vertices of the left and right side of the seam and of the trough."""
    width = 2 * np.pi * RADIUS
    mesh = stark.mesh.grid(width, LENGTH, cells=(AROUND, ALONG))
    flat = np.array(mesh.vertices)
    angle = flat[:, 0] / width * (2 * np.pi - gap / RADIUS)
    bent = np.column_stack([-RADIUS * np.sin(angle), flat[:, 1], -RADIUS * np.cos(angle)])
    left, right = (np.flatnonzero(side * flat[:, 0] > width / 2 - 1e-9) for side in (-1, 1))
    trough = np.flatnonzero(abs(flat[:, 0]) < width / 4 + 1e-9)
    scene = stark.Scene()
    tube = scene.add_cloth(mesh, stark.materials.cotton, initial_positions=bent, pins=trough, name="tube")
    seam = scene.attach(tube.vertices[left], tube.vertices[right], name="seam", break_force=break_force)
    scene.add_force(tube.vertices[np.concatenate([left, right])], (0, 0, -0.05))
    scene.name = "tube"
    scene.default_friction = 0.0
    return scene, tube, seam, [left, right, trough]


@pytest.mark.parametrize("gap", [0.0, 0.003])
def test_a_seam_does_not_go_through_its_own_cloth(gap: float, tmp_path: Path) -> None:
    scene, _, _, (left, right, trough) = sewn_tube(gap)
    folder = tmp_path / "run"
    sim = stark.Simulation(scene, time_step=0.01)
    with Recorder(folder, sim, settings=sim.settings.to_dict(), scene=scene.name, certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for report in sim.run(until=0.5):
            assert not report.failed and not report.caveats, report.message
            recorder.report(report)
            recorder.record_state(sim)
        recorder.record(sim)
    certificate = verify(folder)
    assert certificate.verdict == "certified", certificate.text()
    assert any("against what is near what carries them" in limit for limit in certificate.limits)
    heights = Recording(folder).positions("tube", -1)[:, 2]
    assert min(heights[left].min(), heights[right].min()) > heights[trough].min()


def test_a_seam_comes_to_rest_on_its_own_cloth() -> None:
    scene, tube, _, (left, right, trough) = sewn_tube(0.0)
    sim = stark.Simulation(scene, time_step=0.01)
    for report in sim.run(until=0.6):
        assert not report.failed and not report.caveats, report.message
    lowest = tube.positions[trough, 2].min()
    assert tube.positions[left, 2].min() > lowest and tube.positions[right, 2].min() > lowest
    assert tube.positions[left, 2].min() < lowest + 0.02, "it must have come down there"
    assert report.contact_count > 0
    assert np.abs(tube.positions[left] - tube.positions[right]).max() < 2e-6


def test_contact_comes_back_where_a_seam_breaks() -> None:
    """The sides of a torn seam touch each other from when they are apart on."""
    scene, _, seam, _ = sewn_tube(0.003, break_force=1e-3)
    sim = stark.Simulation(scene, time_step=0.01)
    for report in sim.run(until=0.3):
        assert not report.failed, report.message
    assert seam.broken.all() and not report.caveats
