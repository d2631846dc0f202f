"""Shapes of prims in any units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._stages import body, shape, stage

import stark
from stark.robots.meshes import mesh_of

pytest.importorskip("pxr")


def test_shapes_and_their_units(tmp_path: Path) -> None:
    """In centimetres, y up: scales, axes, a mesh of quads, left-handed faces."""
    quads = (
        "point3f[] points = [(0,0,0),(1,0,0),(1,1,0),(0,1,0),(0,0,1),(1,0,1),(1,1,1),(0,1,1)]\n"
        "int[] faceVertexCounts = [4,4,4,4,4,4]\n"
        "int[] faceVertexIndices = [0,1,2,3, 7,6,5,4, 1,0,4,5, 2,1,5,6, 3,2,6,7, 0,3,7,4]\n"
    )
    inner = (
        shape("Cube", "double size = 2", scale=(1, 2, 3), place=(10, 0, 0))
        + shape("Sphere", "double radius = 3", scale=(2, 2, 2))
        + shape("Cylinder", 'double radius = 1\ndouble height = 5\nuniform token axis = "X"', scale=(2, 3, 3))
        + shape("Capsule", 'double radius = 1\ndouble height = 4\nuniform token axis = "Y"')
        + shape("Cone", "double radius = 1\ndouble height = 3", collides=False)
        + shape("Mesh", quads + 'uniform token orientation = "leftHanded"', scale=(1, 1, -2))
    )
    robot = stark.robots.read(stage(tmp_path, body("part", inner), metre=0.01, up="Y"))
    found = {shape.kind: shape for shape in robot.links["part"].collisions}
    assert found["box"].size == pytest.approx((0.02, 0.04, 0.06))
    assert found["box"].position == pytest.approx([0.1, 0.0, 0.0])
    assert found["sphere"].size == pytest.approx((0.06,))
    assert found["cylinder"].size == pytest.approx((0.03, 0.1))
    assert found["cylinder"].rotation @ [0, 0, 1] == pytest.approx([1, 0, 0])
    assert found["capsule"].size == pytest.approx((0.01, 0.04))
    assert found["capsule"].rotation @ [0, 0, 1] == pytest.approx([0, 1, 0])
    surface = mesh_of(found["mesh"], "file", "part")
    assert surface.volume == pytest.approx(2e-6)
    (cone,) = robot.links["part"].visuals
    surface = mesh_of(cone, "file", "part")
    assert surface.volume == pytest.approx(np.pi * 1e-6, rel=0.01)
    assert surface.bounds[1][2] == pytest.approx(0.015)
    # The file is y up: so the body is turned, not its shapes.
    assert robot.placement[1] @ [0, 1, 0] == pytest.approx([0, 0, 1])


def test_mirrored_bodies_are_refused_and_mirrored_shapes_are_not(tmp_path: Path) -> None:
    cube = shape("Cube", "double size = 2", scale=(-1, 2, 3))
    robot = stark.robots.read(stage(tmp_path, body("part", cube)))
    assert robot.links["part"].collisions[0].size == pytest.approx((2.0, 4.0, 6.0))
    mirrored = (
        body("part")
        .replace("translate = (0.0, 0.0, 0.0)", "scale = (-1, 1, 1)")
        .replace('"xformOp:translate"', '"xformOp:scale"')
    )
    with pytest.raises(stark.InvalidArgument, match="body /robot/part: is sheared or mirrored: must have"):
        stark.robots.read(stage(tmp_path, mirrored))


def test_what_is_animated_starts_as_the_first_frame_has_it(tmp_path: Path) -> None:
    """As modelling programs save a scene that plays. Without a default USD has no points."""
    points = "[(0,0,0), ({0},0,0), (0,{0},0), (0,0,{0})]"
    frames = (
        f"point3f[] points.timeSamples = {{ 1: {points.format(2)}, 9: {points.format(5)} }}\n"
        "int[] faceVertexCounts = [3,3,3,3]\nint[] faceVertexIndices = [0,2,1, 0,1,3, 0,3,2, 1,2,3]\n"
    )
    moving = body(
        "part", shape("Mesh", frames) + shape("Sphere", "double radius.timeSamples = { 1: 3, 9: 4 }")
    )
    moving = moving.replace(
        "translate = (0.0, 0.0, 0.0)", "translate.timeSamples = { 1: (1, 2, 3), 9: (7, 7, 7) }", 1
    )
    robot = stark.Scene().add_robot(file := stage(tmp_path, moving))
    np.testing.assert_allclose(robot.links["part"].body.position, (1, 2, 3))
    found = {shape.kind: shape for shape in stark.robots.read(file).links["part"].collisions}
    assert found["sphere"].size == pytest.approx((3.0,))
    assert found["mesh"].vertices.max() == pytest.approx(2.0)


def test_shapes_below_a_collider_that_is_no_shape_are_named(tmp_path: Path) -> None:
    """An Xform with the schema is no collider; its shapes fell through the floor without a word."""
    group = 'def Xform "group" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {{\n{}}}\n'
    inner = group.format(shape("Cube", collides=False) + shape("Sphere"))
    with pytest.warns(
        stark.StarkWarning, match=r"group/cube does not touch: PhysicsCollisionAPI is on .*group, "
    ):
        robot = stark.Scene().add_robot(stage(tmp_path, body("part", inner)))
    assert [found.kind for found in robot.description.links["part"].collisions] == ["sphere"]


def test_what_is_invisible_is_not_shown_but_touches(tmp_path: Path) -> None:
    hidden = 'uniform token visibility = "invisible"\n'.replace("uniform ", "")
    inner = shape("Cube", hidden, collides=False) + shape("Sphere", hidden) + shape("Cone", collides=False)
    part = stark.robots.read(stage(tmp_path, body("part", inner))).links["part"]
    assert [found.kind for found in part.collisions] == ["sphere"]
    assert [found.kind for found in part.visuals] == ["mesh"]
