"""USD, read again by usd-core."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from _falls import falling
from fake_simulation import record

import stark
from stark.palette import body_colors
from stark.render.colormaps import linear

pxr = pytest.importorskip("pxr", reason="needs the extra 'usd'")
from pxr import Usd, UsdGeom  # noqa: E402


def test_a_simulation_is_read_again_as_it_was(tmp_path: Path) -> None:
    sim = falling()
    seen = []
    with stark.exports.Exporter(tmp_path / "fall.usdc", sim, fields=("stress", "velocity"), fps=50.0) as out:
        for _ in range(4):
            seen.append((sim.time, sim["soft/jelly"].surface_positions.copy(), sim["box"].positions.copy()))
            out.record(sim)
            assert not (tmp_path / "fall.usdc").exists(), "it is there when it is complete"
            sim.step()
    stage = Usd.Stage.Open(str(tmp_path / "fall.usdc"))
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetTimeCodesPerSecond() == 50.0 and stage.GetFramesPerSecond() == 50.0
    assert stage.GetStartTimeCode() == 0.0 and stage.GetEndTimeCode() == pytest.approx(50.0 * seen[-1][0])
    jelly, box = UsdGeom.Mesh.Get(stage, "/World/soft_jelly"), UsdGeom.Mesh.Get(stage, "/World/box")
    assert jelly.GetPrim().GetDisplayName() == "soft/jelly"
    for time, soft, rigid in seen:
        code = 50.0 * time
        np.testing.assert_allclose(np.array(jelly.GetPointsAttr().Get(code)), soft, atol=1e-7)
        matrix = np.array(box.ComputeLocalToWorldTransform(code))  # rows: USD multiplies from the left
        local = np.array(box.GetPointsAttr().Get(code), dtype=float)
        # Single precision of points 0.3 m from the origin: 3e-8 m each.
        np.testing.assert_allclose(local @ matrix[:3, :3] + matrix[3, :3], rigid, atol=3e-7)
    assert len(jelly.GetPointsAttr().GetTimeSamples()) == 4 and not box.GetPointsAttr().GetTimeSamples()
    stress = UsdGeom.PrimvarsAPI(jelly).GetPrimvar("stress")
    assert stress.GetInterpolation() == "vertex"
    assert len(stress.Get(50.0 * seen[2][0])) == len(seen[0][1])
    colors = body_colors(sim.bodies)
    index = [body.name for body in sim.bodies].index("box")
    np.testing.assert_allclose(np.array(box.GetDisplayColorAttr().Get())[0], linear(colors[index]), atol=1e-6)


def test_between_time_samples_rigid_bodies_turn_in_place(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box", position=(10.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 50.0))
    sim = stark.Simulation(scene, time_step=0.02, gravity=(0.0, 0.0, 0.0))
    with stark.exports.Exporter(tmp_path / "spin.usdc", sim, fps=50.0) as out:
        out.record(sim)
        sim.step()  # by a radian
        out.record(sim)
    stage = Usd.Stage.Open(str(tmp_path / "spin.usdc"))
    box = UsdGeom.Mesh.Get(stage, "/World/box")
    np.testing.assert_allclose(np.array(box.GetPointsAttr().Get()).mean(axis=0), 0.0, atol=1e-7)
    for code in (0.0, 0.5, 1.0):
        matrix = np.array(box.ComputeLocalToWorldTransform(code))
        np.testing.assert_allclose(matrix[3, :3], (10.0, 0.0, 0.0), atol=1e-6)
        turned = np.arctan2(matrix[0, 1], matrix[0, 0])
        assert abs(turned - code) < 2e-5  # [rad]: single precision of points 10 m away, 5 cm from the middle


def test_a_scene_with_y_up_says_so(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    sim = stark.Simulation(scene, gravity=(0.0, -9.81, 0.0))
    with stark.exports.Exporter(tmp_path / "up.usda", sim) as out:
        out.record(sim)
    assert UsdGeom.GetStageUpAxis(Usd.Stage.Open(str(tmp_path / "up.usda"))) == "Y"


def test_a_recording_is_exported_with_velocities(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 4)
    done: list[tuple[int, int]] = []
    files = stark.exports.export_recording(
        run, tmp_path / "out", "usd", progress=lambda k, n: done.append((k, n))
    )
    assert done == [(k, 5) for k in range(1, 6)]
    stage = Usd.Stage.Open(str(files[0]))
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    assert len(meshes) == len(run.bodies)
    k = next(k for k, body in enumerate(run.bodies) if body.kind == "cloth")
    code = 60.0 * float(run.times[2])
    expected = (run.positions(k, 2) - run.positions(k, 1)) / np.float32(run.times[2] - run.times[1])
    velocity = UsdGeom.PrimvarsAPI(meshes[k]).GetPrimvar("velocity").Get(code)
    np.testing.assert_allclose(np.array(velocity), expected, atol=1e-4)


def test_what_fails_leaves_nothing_behind(tmp_path: Path) -> None:
    sim = falling()
    with pytest.raises(RuntimeError, match="stop"), stark.exports.Exporter(tmp_path / "a.usda", sim) as out:
        out.record(sim)
        raise RuntimeError("stop")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(stark.InvalidArgument, match=r"suffix must be one of \.usd"):
        stark.exports.Exporter(tmp_path / "a.doc", sim)
    with pytest.raises(stark.InvalidArgument, match=r"field 'charm': must be one of displacement"):
        stark.exports.Exporter(tmp_path / "a.usd", sim, fields=["charm"])
    with pytest.raises(stark.InvalidArgument, match=r"record at 0 s after one at 0 s: must be later"):
        out = stark.exports.Exporter(tmp_path / "a.usd", sim)
        out.record(sim)
        out.record(sim)
    with pytest.raises(stark.InvalidArgument, match=r"needs a simulation; a recording has positions only"):
        run = record(tmp_path / "run", 2)
        stark.exports.export_recording(run, tmp_path / "out", "usd", fields=["stress"])
    assert not list((tmp_path / "out").glob("*"))


def test_renderers_find_the_velocities_of_what_deforms(tmp_path: Path) -> None:
    sim = falling()
    with stark.exports.Exporter(tmp_path / "fall.usdc", sim, fields=("velocity",), fps=50.0) as out:
        out.record(sim)
        before = sim["soft/jelly"].surface_positions.copy()
        sim.step()
        out.record(sim)
    stage = Usd.Stage.Open(str(tmp_path / "fall.usdc"))
    jelly, box = UsdGeom.Mesh.Get(stage, "/World/soft_jelly"), UsdGeom.Mesh.Get(stage, "/World/box")
    mean = (sim["soft/jelly"].surface_positions - before) / 0.01
    # Single precision of places of 0.1 m over 10 ms: 1e-6 m/s.
    np.testing.assert_allclose(np.array(jelly.GetVelocitiesAttr().Get(0.5)), mean, atol=3e-6)
    assert not box.GetVelocitiesAttr().HasAuthoredValue(), "its frame moves, its points do not"
