"""Scans to soft bodies, with the edge length that was asked for."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from mesh._scans import animal, scan

import stark
from stark.mesh import edge_lengths

pytest.importorskip("pytetwild")
pytest.importorskip("fast_simplification")


def test_a_small_scan_becomes_a_solid(tmp_path: Path) -> None:
    said: list[tuple[str, float]] = []
    dirty = scan(4)
    found = stark.mesh.solid_from_scan(
        dirty, edge_length=0.02, progress=lambda what, share: said.append((what, share))
    )
    assert abs(found.mesh.volume - animal(4).volume) < 0.05 * animal(4).volume
    assert abs(edge_lengths(found.mesh).mean() - 0.02) < 0.15 * 0.02
    assert (found.mesh.volumes > 0.0).all() and found.surface.is_closed
    assert [share for _, share in said] == sorted(share for _, share in said) and said[-1] == ("done", 1.0)
    assert "tetrahedra, mean edge" in str(found.report) and found.report.count("simplified") > 0
    dirty.save(tmp_path / "scan.npz")
    again = stark.mesh.solid_from_scan(tmp_path / "scan.npz", edge_length=0.05)
    assert abs(again.mesh.volume - found.mesh.volume) < 0.05 * found.mesh.volume


@pytest.mark.slow
def test_a_scan_of_seventy_thousand_triangles_falls_as_a_soft_body_within_a_minute_of_cpu() -> None:
    dirty = scan(6)
    assert 65_000 < len(dirty.triangles) < 82_000
    start = time.process_time()
    solid = stark.mesh.solid_from_scan(dirty, edge_length=0.025)
    scene = stark.Scene()
    scene.add_floor(1.0)
    body = scene.add_solid(solid.mesh, stark.materials.soft_rubber, position=(0, 0, 0.2))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.25)
    assert body.positions[:, 2].min() > 0.0 and body.positions[:, 2].mean() < 0.15
    assert time.process_time() - start < 60.0


def test_wrong_arguments_are_named(tmp_path: Path) -> None:
    with pytest.raises(
        stark.InvalidArgument, match="solid_from_scan: edge_length = 0 m: must be a number > 0"
    ):
        stark.mesh.solid_from_scan(stark.mesh.box(1.0), edge_length=0)
    stark.mesh.tet_box(1.0, 1).save(tmp_path / "box.npz")
    with pytest.raises(stark.InvalidMesh, match="has TetMesh: must be a surface"):
        stark.mesh.solid_from_scan(tmp_path / "box.npz", edge_length=0.1)
