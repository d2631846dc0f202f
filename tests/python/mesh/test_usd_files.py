"""Surfaces of USD files: units and axes, frames, skeletons, parts, doubles, damage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import mesh
from stark.mesh.usd_files import read_usd, without_unused

pytest.importorskip("pxr")
from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

SQUARE = [(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)]  # [cm], as seen from the front, y up


def stage_of(path: Path, up: str = "Y", metre: float = 0.01) -> Any:
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, metre)
    stage.SetTimeCodesPerSecond(20)
    return stage


def square(stage: Any, path: str, points: Any = SQUARE) -> Any:
    made = UsdGeom.Mesh.Define(stage, path)
    made.CreatePointsAttr(points)
    made.CreateFaceVertexCountsAttr([4])
    made.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    return made


def test_centimetres_with_y_up_are_metres_with_z_up(tmp_path: Path) -> None:
    stage = stage_of(tmp_path / "wall.usda")
    wall = square(stage, "/World/wall")
    UsdGeom.XformCommonAPI(UsdGeom.Xform.Define(stage, "/World").GetPrim()).SetTranslate((0, 0, 200))
    stage.Save()
    found = mesh.load(tmp_path / "wall.usda")
    assert np.allclose(found.vertices, [(0, -2, 0), (1, -2, 0), (1, -2, 1), (0, -2, 1)], atol=1e-12)
    a, b, c = found.vertices[found.triangles[0]]
    assert np.cross(b - a, c - a)[1] < 0.0  # faces the front, which is -y
    for mirrored in (True, False):  # a mirror turns triangles over, and the file may say that they are
        wall.CreateOrientationAttr("leftHanded" if not mirrored else "rightHanded")
        scale = wall.GetPrim().GetAttribute("xformOp:scale")
        (scale or wall.AddScaleOp().GetAttr()).Set(Gf.Vec3f(-1 if mirrored else 1, 1, 1))
        stage.Save()
        a, b, c = (found := mesh.load(tmp_path / "wall.usda")).vertices[found.triangles[0]]
        assert np.sign(np.cross(b - a, c - a)[1]) == (-1.0 if mirrored else 1.0)


def test_points_and_frames_move(tmp_path: Path) -> None:
    stage = stage_of(tmp_path / "walk.usda", "Z", 1.0)
    skin = square(stage, "/World/skin", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    lifted = UsdGeom.Xform.Define(stage, "/World").AddTranslateOp()
    for code, height in ((10, 0.0), (14, 2.0)):
        lifted.Set((0, 0, height), code)
    points = skin.GetPointsAttr()
    points.Set([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], 10)
    points.Set([(0, 0, 0), (3, 0, 0), (3, 3, 0), (0, 3, 0)], 12)
    stage.Save()
    found = read_usd(tmp_path / "walk.usda", moving=True)
    assert found.times.tolist() == [0.0, 0.1, 0.2]  # 20 time codes a second
    assert found.frames[:, 2].tolist() == [[1, 1, 0], [3, 3, 1], [3, 3, 2]]
    assert len(read_usd(tmp_path / "walk.usda").frames) == 1


def test_skeletons_move_their_skins(tmp_path: Path) -> None:
    """The upper half of a strip bends forward by 90 degrees at a joint."""
    stage = stage_of(tmp_path / "bow.usda")
    UsdSkel.Root.Define(stage, "/Man")
    strip = UsdGeom.Mesh.Define(stage, "/Man/strip")
    strip.CreatePointsAttr([(x, y, 0) for y in (0, 10, 20) for x in (0, 5)])
    strip.CreateFaceVertexCountsAttr([4, 4])
    strip.CreateFaceVertexIndicesAttr([0, 1, 3, 2, 2, 3, 5, 4])
    bones, places = ["hip", "hip/chest"], [Gf.Matrix4d(1), Gf.Matrix4d().SetTranslate((0, 10, 0))]
    skeleton = UsdSkel.Skeleton.Define(stage, "/Man/bones")
    skeleton.CreateJointsAttr(bones)
    skeleton.CreateBindTransformsAttr(places)
    skeleton.CreateRestTransformsAttr(places)
    bow = UsdSkel.Animation.Define(stage, "/Man/bow")
    bow.CreateJointsAttr(bones)
    bow.CreateTranslationsAttr([(0, 0, 0), (0, 10, 0)])
    bow.CreateScalesAttr([(1, 1, 1)] * 2)
    turns = bow.CreateRotationsAttr()
    for k in range(5):
        bent = Gf.Quatf(Gf.Rotation((1, 0, 0), 22.5 * k).GetQuat())
        turns.Set(Vt.QuatfArray([Gf.Quatf(1, 0, 0, 0), bent]), k)
    binding = UsdSkel.BindingAPI.Apply(strip.GetPrim())
    binding.CreateSkeletonRel().SetTargets(["/Man/bones"])
    binding.CreateJointIndicesPrimvar(False, 1).Set([0, 0, 0, 0, 1, 1])
    binding.CreateJointWeightsPrimvar(False, 1).Set([1.0] * 6)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/Man/bow"])
    stage.Save()
    before = (tmp_path / "bow.usda").read_bytes()
    found = read_usd(tmp_path / "bow.usda", moving=True)
    assert np.allclose(found.frames[0, 4:], [(0, 0, 0.2), (0.05, 0, 0.2)], atol=1e-7)
    assert np.allclose(found.frames[-1, 4:], [(0, -0.1, 0.1), (0.05, -0.1, 0.1)], atol=1e-7)
    assert (found.frames[:, :4] == found.frames[0, :4]).all()
    assert (tmp_path / "bow.usda").read_bytes() == before


def test_parts_are_groups_and_hidden_ones_are_left_out(tmp_path: Path) -> None:
    stage = stage_of(tmp_path / "suit.usda", "Z", 1.0)
    for k, path in enumerate(("/Suit/left/sleeve", "/Suit/right/sleeve", "/Suit/hat", "/Suit/ghost")):
        made = square(stage, path, [(x, y, k) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    made.MakeInvisible()
    stage.Save()
    file = tmp_path / "suit.usda"
    suit, groups = mesh.load(file), mesh.load_groups(file)
    assert len(suit.vertices) == 12
    assert {name: group.elements.tolist() for name, group in groups.items()} == {
        "/Suit/left/sleeve": [0, 1], "/Suit/right/sleeve": [2, 3], "hat": [4, 5],
    }  # fmt: skip
    assert (suit.vertices[groups["hat"].vertices, 2] == 2.0).all()
    assert len(read_usd(file, "/Suit/left").triangles) == 2
    for below, message in (
        ("/Suit/shoe", "no prim '/Suit/shoe': must be a path, such as one of /Suit/left/sleeve"),
        ("hat", "no prim 'hat'"),
        ("/Suit/ghost", "no mesh at or below '/Suit/ghost' has faces and is visible"),
    ):
        with pytest.raises(stark.InvalidMesh, match=message):
            read_usd(file, below)


def test_doubles_that_stay_together_become_one(tmp_path: Path) -> None:
    """Two triangles of a sheet, with all corners written twice; the second pair of doubles comes apart."""
    stage = stage_of(tmp_path / "torn.usda", "Z", 1.0)
    torn = UsdGeom.Mesh.Define(stage, "/torn")
    torn.CreateFaceVertexCountsAttr([3, 3])
    torn.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 4, 5])
    start = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (9, 9, 9)]
    end = [*start[:5], (0, 1, 1), (9, 9, 9)]
    torn.CreatePointsAttr().Set(start, 0)
    torn.GetPointsAttr().Set(end, 1)
    stage.Save()
    found = without_unused(read_usd(tmp_path / "torn.usda", moving=True))
    assert found.frames.shape == (2, 5, 3) and found.triangles.tolist() == [[0, 1, 2], [1, 3, 4]]
    assert found.frames[1, 4].tolist() == [0, 1, 1] and found.parts["torn"].tolist() == [0, 1]
    assert len(mesh.load(tmp_path / "torn.usda").vertices) == 4


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("no stage", "USD cannot read it"),
        ("#usda 1.0\n", "no mesh has faces and is visible"),
        (
            '#usda 1.0\ndef Mesh "a" {\n point3f[] points = [(0, 0, 0)]\n int[] faceVertexCounts = [3]\n'
            " int[] faceVertexIndices = [0, 0, 1]\n}\n",
            "/a: faceVertexIndices do not fit",
        ),
        (
            '#usda 1.0\ndef Mesh "a" {\n point3f[] points.timeSamples = { 0: [(0,0,0),(1,0,0),(0,1,0)], '
            "1: [(0,0,0)] }\n int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n}\n",
            "/a has 1 points at the time code 1.0: must be 3",
        ),
    ],
)
def test_what_cannot_be_read_is_named(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "bad.usda").write_text(text)
    with pytest.raises(stark.InvalidMesh, match=message) as caught:
        read_usd(tmp_path / "bad.usda", moving=True)
    assert "bad.usda'" in str(caught.value)
