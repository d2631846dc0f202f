"""glTF, read again by trimesh."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from _falls import falling
from fake_simulation import record

import stark

trimesh = pytest.importorskip("trimesh", reason="needs the extra 'export'")


def test_a_still_is_read_again_with_the_y_axis_up(tmp_path: Path) -> None:
    sim = falling()
    with stark.exports.Exporter(tmp_path / "fall.glb", sim, fields=("stress",)) as out:
        out.record(sim)
        sim.run_until(0.1)
        out.record(sim)
    scene = trimesh.load(tmp_path / "fall.glb", process=False)
    assert {"soft/jelly", "box"} <= set(scene.graph.nodes_geometry)
    transform, geometry = scene.graph["box"]
    points = trimesh.transform_points(scene.geometry[geometry].vertices, transform)
    expected = sim["box"].positions
    np.testing.assert_allclose(points, expected[:, [0, 2, 1]] * (1, 1, -1), atol=1e-6)
    jelly = scene.geometry[scene.graph["soft/jelly"][1]]
    stress = stark.render.field_values(sim, "stress")["soft/jelly"][np.unique(sim["soft/jelly"].triangles)]
    np.testing.assert_allclose(jelly.vertex_attributes["_STRESS"].ravel(), stress, rtol=1e-6)


def test_a_scene_with_y_up_stays_as_it_is(tmp_path: Path) -> None:
    scene = stark.Scene()
    box = scene.add_box((0.1, 0.2, 0.3), mass=1.0, name="box", position=(1.0, 2.0, 3.0))
    sim = stark.Simulation(scene, gravity=(0.0, -9.81, 0.0))
    with stark.recording.Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
    recording = stark.recording.Recording(tmp_path / "run")
    (file,) = stark.exports.export_recording(recording, tmp_path / "out", "glb")
    read = trimesh.load(file, process=False)
    transform, geometry = read.graph["box"]
    points = trimesh.transform_points(read.geometry[geometry].vertices, transform)
    np.testing.assert_allclose(points, box.positions, atol=1e-6)


def test_frames_of_a_recording_are_files(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 3)
    files = stark.exports.export_recording(run, tmp_path / "out", "glb", frames=[0, 2])
    assert [file.name[-10:] for file in files] == ["000000.glb", "000002.glb"]
    assert len(trimesh.load(files[1]).geometry) == len(run.bodies)


def test_ctrl_c_while_trimesh_is_imported_is_not_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from stark.exports.gltf import GltfWriter

    (tmp_path / "trimesh.py").write_text(
        "import signal\ntry:\n    signal.raise_signal(signal.SIGINT)\nexcept BaseException:\n    pass\n"
    )
    monkeypatch.delitem(sys.modules, "trimesh")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        GltfWriter(tmp_path / "a.glb", each=False)
    monkeypatch.delitem(sys.modules, "trimesh")
    (tmp_path / "cup.off").write_text("OFF\n")
    with pytest.raises(KeyboardInterrupt):
        stark.mesh.load(tmp_path / "cup.off")
