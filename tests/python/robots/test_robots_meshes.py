"""Meshes of links: what cannot be is refused with its file, what hardly can be is reported and warned of."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import stark
from stark import mesh
from stark.robots import Geometry, Inertia, Link, RobotDescription, RobotJoint

BOX = mesh.box((0.1, 0.06, 0.04))
# A radius of gyration of 34 mm.
INERTIA = Inertia(
    2.0, np.zeros(3), 2.0 / 12 * np.diag([0.06**2 + 0.04**2, 0.1**2 + 0.04**2, 0.1**2 + 0.06**2])
)


def written(path: Path, vertices: np.ndarray = BOX.vertices) -> Path:
    rows = ["v " + " ".join(map(repr, row)) for row in vertices.tolist()]
    rows += ["f " + " ".join(str(i + 1) for i in row) for row in BOX.triangles.tolist()]
    path.write_text("\n".join(rows))
    return path


def robot_with(*shapes: Geometry, inertia: Inertia = INERTIA, **options: object) -> stark.robots.Robot:
    """An arm with these collision shapes, on a hinge."""
    links = [Link("stand"), Link("arm", inertia, collisions=shapes)]
    description = RobotDescription("arm", links, [RobotJoint("hinge", "continuous", "stand", "arm")])
    return stark.Scene().add_robot(description, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_meshes_in_another_unit_are_suspicious(factor: float, tmp_path: Path) -> None:
    """Millimetres that are read in metres, and metres that are scaled as if they were millimetres."""
    file = written(tmp_path / "box.obj", BOX.vertices * factor)
    with pytest.warns(stark.StarkWarning, match="link 'arm': its meshes reach .* give the mesh the scale"):
        robot = robot_with(Geometry("mesh", file=file))
    (found,) = robot.report.suspicious
    reach = factor * 0.5 * np.sqrt(0.1**2 + 0.06**2 + 0.04**2)
    assert f"its meshes reach {reach:.3g} m from its centre of mass" in found.text
    assert "a radius of gyration of 0.0337 m" in found.text
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fitting = robot_with(Geometry("mesh", file=file, scale=np.full(3, 1.0 / factor)))
    assert not fitting.report.suspicious


def test_what_surrounds_the_inertia_of_a_link_is_not_suspicious(tmp_path: Path) -> None:
    """A badge beside the centre of mass, on a box that has the size; a shape that is no mesh."""
    file = written(tmp_path / "box.obj", BOX.vertices * 1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot_with(Geometry("mesh", file=file), Geometry("box", (0.1, 0.06, 0.04)))
        robot_with(Geometry("mesh", file=file, position=np.array([0.05, 0.0, 0.0])))
        robot_with(Geometry("box", (1e-4, 1e-4, 1e-4)))


def test_meshes_that_are_shown_are_looked_at_too(tmp_path: Path) -> None:
    file = written(tmp_path / "box.obj", BOX.vertices * 1e3)
    links = [
        Link("stand"),
        Link("arm", INERTIA, (Geometry("mesh", file=file),), (Geometry("box", (0.1, 0.06, 0.04)),)),
    ]
    description = RobotDescription("arm", links, [RobotJoint("hinge", "continuous", "stand", "arm")])
    assert not stark.Scene().add_robot(description).report.suspicious
    with pytest.warns(stark.StarkWarning, match="link 'arm': its meshes reach"):
        stark.Scene().add_robot(description, shown="visual")


def test_vertices_that_are_no_numbers_are_refused(tmp_path: Path) -> None:
    vertices = BOX.vertices.copy()
    vertices[3, 1] = np.nan
    file = written(tmp_path / "nan.obj", vertices)
    refused = r"'arm': shape mesh: '.*nan.obj': line 4: 'v .*nan.*': coordinates must be finite"
    with pytest.raises(stark.InvalidArgument, match=refused):
        robot_with(Geometry("mesh", file=file))
    with pytest.raises(stark.InvalidArgument, match="shape mesh: vertex 3 is at"):
        robot_with(Geometry("mesh", vertices=vertices, triangles=BOX.triangles))
    with pytest.raises(stark.InvalidArgument, match=r"'arm': shape mesh: .* refers to vertex 8"):
        robot_with(Geometry("mesh", vertices=BOX.vertices, triangles=BOX.triangles + 1))
    assert "nan.obj" in str(robot_with(Geometry("mesh", file=file), contact=False).report.dropped[0])


def test_scales_with_a_zero_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    written(tmp_path / "box.obj")
    urdf = (
        '<robot name="arm"><link name="arm"><collision><geometry><mesh filename="box.obj" scale="{}"/>'
        "</geometry></collision></link></robot>"
    )
    (tmp_path / "arm.urdf").write_text(urdf.format("0 1 1"))
    refused = r"arm.urdf': link 'arm': shape mesh: '.*box.obj': scale = \[0.0, 1.0, 1.0\]: must have no 0"
    with pytest.raises(stark.InvalidArgument, match=refused):
        stark.Scene().add_robot(tmp_path / "arm.urdf")
    (tmp_path / "arm.urdf").write_text(urdf.format("-1 1 1"))
    body = stark.Scene().add_robot(tmp_path / "arm.urdf").bodies[0]
    assert mesh.TriangleMesh(body.positions, body.triangles).volume == pytest.approx(BOX.volume)


def test_a_mesh_of_a_robot_that_touches_nothing_is_reported_once(tmp_path: Path) -> None:
    """It has no other, so that its visual mesh is the surface of the body and what pictures show."""
    file = written(tmp_path / "box.obj", BOX.vertices * 1e3)
    links = [Link("stand"), Link("arm", INERTIA, visuals=(Geometry("mesh", file=file),))]
    description = RobotDescription("arm", links, [RobotJoint("hinge", "continuous", "stand", "arm")])
    with pytest.warns(stark.StarkWarning, match="its meshes reach"):
        robot = stark.Scene().add_robot(description, contact=False)
    assert len(robot.report.suspicious) == 1
