"""Point caches: read again as they were, and followed by another simulation."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import stark
from stark.exports.exporter import Exporter


def _hanging() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_floor(1.0, height=-1.0)
    for _ in range(2):
        scene.add_cloth(
            stark.mesh.grid(0.2, 0.1, cells=(4, 2)), pins=[0, 4], position=(0, 0, 0.3 * len(scene.bodies))
        )
    return stark.Simulation(scene, time_step=0.02)


def _export(path: Path, sim: stark.Simulation, steps: int = 5) -> list[np.ndarray]:
    seen = []
    with Exporter(path, sim, fps=50.0) as out:
        for step in range(steps):
            seen.append(sim.bodies[1].positions.copy())  # type: ignore[attr-defined]
            out.record(sim)
            if step < steps - 1:
                sim.step()
    return seen


def test_a_cache_has_the_vertices_in_the_order_of_the_mesh(tmp_path: Path) -> None:
    seen = _export(tmp_path / "drape.pc2", _hanging())
    files = sorted(file.name for file in tmp_path.iterdir())
    assert files == ["drape_cloth.pc2", "drape_cloth_2.pc2"], "no fixed bodies"
    data = (tmp_path / files[0]).read_bytes()
    signature, version, points, start, rate, count = struct.unpack_from("<12siiffi", data)
    assert (signature, version, points, start, count) == (b"POINTCACHE2\0", 1, 15, 0.0, 5)
    assert rate == pytest.approx(1.0)  # steps of 20 ms at 50 frames a second
    rows = np.frombuffer(data, "<f4", offset=32).reshape(5, 15, 3)
    np.testing.assert_array_equal(rows, np.array(seen, dtype=np.float32))


def test_a_character_follows_a_cache(tmp_path: Path) -> None:
    seen = _export(tmp_path / "walk.pc2", _hanging())
    scene = stark.Scene()
    mesh = stark.mesh.TriangleMesh(np.float64(seen[0]), stark.mesh.grid(0.2, 0.1, cells=(4, 2)).triangles)
    body = scene.add_cloth(mesh, pins=range(15))
    body.follow(stark.motion.point_cache(tmp_path / "walk_cloth.pc2", fps=50.0))
    sim = stark.Simulation(scene, time_step=0.01)  # between two frames, too
    sim.step()
    np.testing.assert_allclose(body.positions, 0.5 * (seen[0] + seen[1]), atol=1e-7)
    sim.run_until(0.08)
    np.testing.assert_allclose(body.positions, seen[4], atol=1e-7)


def test_records_at_uneven_times_become_even_frames(tmp_path: Path) -> None:
    """As those of runs whose steps do not divide their end, or some of whose steps were halved."""
    sim, seen = _hanging(), []
    with Exporter(tmp_path / "drape.pc2", sim, fps=25.0) as out:
        for pause in (2, 2, 3, 2, 1, 0):
            seen.append(sim.bodies[1].positions.copy())  # type: ignore[attr-defined]
            out.record(sim)
            for _ in range(pause):
                sim.step()
    data = (tmp_path / "drape_cloth.pc2").read_bytes()
    start, rate, count = struct.unpack_from("<ffi", data, 20)
    assert (start, count) == (0.0, 6) and rate == pytest.approx(1.0), "frames of 0 to 0.2 s"
    rows = np.frombuffer(data, "<f4", offset=32).reshape(6, 15, 3)
    expected = [
        *seen[:3],
        seen[2] + 2 / 3 * (seen[3] - seen[2]),
        seen[3] + 0.5 * (seen[4] - seen[3]),
        seen[5],
    ]
    np.testing.assert_allclose(rows, expected, atol=1e-7)


def test_too_many_even_frames_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stark.exports.pc2._MOST_FRAMES", 2)
    sim = _hanging()
    with (
        pytest.raises(stark.InvalidArgument, match=r"be 13 of 4 records, most of which are 0\.02 s apart"),
        Exporter(tmp_path / "drape.pc2", sim, fps=25.0) as out,
    ):
        for pause in (1, 1, 10, 0):
            out.record(sim)
            for _ in range(pause):
                sim.step()
    assert not list(tmp_path.iterdir())
