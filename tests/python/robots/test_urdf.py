"""URDF files: masses and inertias are those of pinocchio; faults are named, gaps reported."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from robots._robots import ARM, pair, random_urdf

import stark.robots

pytest.importorskip("yourdfpy")


@pytest.mark.parametrize("seed", range(4))
def test_masses_centres_and_tensors_are_those_of_pinocchio(seed: int, tmp_path: Path) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    file = tmp_path / "tree.urdf"
    file.write_text(random_urdf(seed))
    robot = stark.robots.read(file)
    model = pinocchio.buildModelFromUrdf(str(file))
    for joint in robot.joints.values():
        if not joint.is_moving:
            continue
        fixed = [joint.child]
        parts = [robot.links[joint.child].inertia]
        frames = {joint.child: (np.zeros(3), np.eye(3))}
        for other in robot.joints.values():  # pinocchio adds what is fixed to a link
            if other.kind == "fixed" and other.parent in fixed:
                position, rotation = frames[other.parent]
                frames[other.child] = position + rotation @ other.position, rotation @ other.rotation
                fixed.append(other.child)
                parts.append(robot.links[other.child].inertia.moved(*frames[other.child]))
        ours = stark.robots.Inertia.sum(parts)
        theirs = model.inertias[model.getJointId(joint.name)]
        assert abs(ours.mass - theirs.mass) < 1e-9
        np.testing.assert_allclose(ours.center, theirs.lever, atol=1e-9)
        np.testing.assert_allclose(ours.tensor, theirs.inertia, atol=1e-9)


INERTIAL = '<inertial>{}<inertia ixx="{}" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>'
LIMIT = '<axis xyz="0 0 1"/><limit lower="{}" upper="1" effort="{}" velocity="2"/>'
BAD = {
    "not XML": ("<robot", "must be XML"),
    "tags": ("<robot name='r'><link name='a'></robot>", "mismatched tag: line 1.*: must be XML"),
    "xacro": (
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:leg/><link name="a"/></robot>',
        "<xacro:leg>: is a macro: must be expanded first; write the file by `xacro robot.xacro",
    ),
    "another format": ("<sdf/>", "begins with <sdf>: must be a URDF file"),
    "no name": ("<robot name='r'><link/></robot>", "<link>: name: must be given"),
    "number": (pair(LIMIT.format("low", 5)), "joint 'hinge': <limit lower='low'>: must be a finite number"),
    "infinite": (pair(LIMIT.format("-inf", 5)), "joint 'hinge': <limit lower='-inf'>: must be a finite"),
    "three numbers": (pair('<axis xyz="0 1"/>'), "joint 'hinge': <axis xyz='0 1'>: must be 3 finite numbers"),
    "no axis": (
        pair('<axis xyz="0 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'),
        "joint 'hinge': <axis .*: must not be zero",
    ),
    "no limit": (pair('<axis xyz="0 0 1"/>'), "joint 'hinge': <limit> is missing: .* must have one"),
    "limits": (
        pair(LIMIT.format(2, 5)),
        "joint 'hinge': lower = 2, upper = 1 rad: lower must be below upper",
    ),
    "effort": (pair(LIMIT.format(-1, -5)), "joint 'hinge': <limit effort='-5'>: must be >= 0"),
    "planar": (pair(kind="planar"), "joint 'hinge': type = 'planar': must be one of fixed, revolute"),
    "type": (pair(kind="hinge"), "joint 'hinge': type = 'hinge': must be one of"),
    "no mass": (pair(link=INERTIAL.format("", 0.01)), "link 'arm': <inertial> has no <mass>"),
    "mass": (pair(link=INERTIAL.format("<mass/>", 0.01)), "link 'arm': <mass>: value is missing"),
    "geometry": (
        pair(link="<visual><geometry><cone/></geometry></visual>"),
        "link 'arm': <visual> with the geometry cone: must be one of box",
    ),
    "mesh": (
        pair(link='<visual><geometry><mesh filename="package://pair/arm.stl"/></geometry></visual>'),
        "link 'arm': mesh 'package://pair/arm.stl': must be a file; .* give packages=",
    ),
    "child": (
        pair(more='<joint name="two" type="fixed"><parent link="base"/><child link="leg"/></joint>'),
        "joint 'two': child = 'leg': must be one of the links",
    ),
    "no parent": (
        pair(more='<joint name="two" type="fixed"><child link="arm"/></joint>'),
        "joint 'two': <parent> is missing",
    ),
    "loop": (
        pair(more='<joint name="two" type="fixed"><parent link="base"/><child link="arm"/></joint>'),
        "link 'arm': is the child of the joints 'hinge' and 'two'",
    ),
    "two roots": (pair(more='<link name="leg"/>'), "links: without a parent: 'base', 'leg'"),
    "twice": (pair(more='<link name="arm"/>'), "link 'arm': is there twice"),
    "mimic": (
        pair(LIMIT.format(-1, 5) + '<mimic joint="other"/>'),
        "joint 'hinge': mimics 'other': both must be joints",
    ),
    "itself": (pair(LIMIT.format(-1, 5) + '<mimic joint="hinge"/>'), "joint 'hinge': mimics itself"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_with_a_file_is_named(case: str, tmp_path: Path) -> None:
    file = tmp_path / "bad.urdf"
    file.write_text(BAD[case][0])
    with pytest.raises(stark.InvalidArgument, match=BAD[case][1]) as caught:
        stark.robots.read(file)
    assert str(caught.value).startswith(f"'{file}': ")


def test_a_missing_reader_is_named_with_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "yourdfpy", None)
    with pytest.raises(ImportError, match=r"need yourdfpy: pip install 'stark-sim\[robots\]'"):
        stark.robots.read(ARM)


def test_what_is_left_out_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "pair.urdf"
    more = '<transmission name="t"/><gazebo/>'
    file.write_text(pair('<limit effort="0" upper="1"/><safety_controller/><mimic joint="x"/>', more=more))
    text = file.read_text().replace('<mimic joint="x"/>', "")
    file.write_text(text)
    report = stark.robots.read(file).report
    assert [str(finding) for finding in report.dropped] == [
        "joint 'hinge': <safety_controller> is not read",
        "transmission 't': is not read",
        "<gazebo>: is not read",
    ]
    assert [str(finding) for finding in report.assumed] == [
        "joint 'hinge': no <axis>: x, as URDF has it",
        "joint 'hinge': no limit of velocity, which URDF demands: none",
        "joint 'hinge': <limit> without lower: 0, as URDF has it",
        "link 'base': no inertia: has no mass, must be fixed to a link that has",
    ]
    assert [str(finding) for finding in report.suspicious] == [
        "joint 'hinge': limit of effort 0: taken as none; drives need a cap"
    ]
    assert f"robot from '{file}'" in str(report) and "  dropped (3):" in str(report)


def test_damping_of_joints_without_an_axis_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "pair.urdf"
    file.write_text(pair('<dynamics damping="3" friction="0"/>', kind="floating"))
    report = stark.robots.read(file).report
    assert "joint 'hinge': <dynamics>: floating joints have no damping and no friction" in str(report)


def test_robots_without_a_name_get_that_of_the_file(tmp_path: Path) -> None:
    file = tmp_path / "crane.urdf"
    file.write_text("<robot><link name='a'/></robot>")
    robot = stark.robots.read(file)
    assert robot.name == "crane"
    assert robot.report.assumed[0].text == "no name, which URDF demands: 'crane', that of the file"


def test_collada_meshes_have_the_unit_that_they_name(tmp_path: Path) -> None:
    pytest.importorskip("collada")
    trimesh = pytest.importorskip("trimesh")
    file = tmp_path / "box.dae"
    trimesh.creation.box((100.0, 200.0, 300.0)).export(file)
    text, unit = file.read_text(), '<unit name="millimeter" meter="0.001"/>'
    file.write_text(re.sub(r"<up_axis|</asset>", lambda found: unit + found[0], text, count=1))
    shape = '<collision><geometry><mesh filename="box.dae"/></geometry></collision>'
    urdf = tmp_path / "pair.urdf"
    urdf.write_text(pair(link=INERTIAL.format('<mass value="1"/>', 0.01) + shape))
    robot = stark.Scene().add_robot(urdf)
    mesh = robot.links["arm"].collision
    assert mesh is not None
    np.testing.assert_allclose(mesh.bounds[1], [0.05, 0.1, 0.15], atol=1e-6)
    assert "mesh 'box.dae' is in units of 0.001 m" in str(robot.report)


def test_meshes_are_found_by_package_and_scaled(tmp_path: Path) -> None:
    folder = tmp_path / "arms/meshes"
    folder.mkdir(parents=True)
    (folder / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    shape = '<{0}><origin xyz="0 0 1"/><geometry><mesh filename="{1}" scale="1 2 -1"/></geometry></{0}>'
    for name in ("package://arms/meshes/a.obj", "meshes/a.obj", f"file://{folder}/a.obj"):
        link = INERTIAL.format('<mass value="1"/>', 0.01) + shape.format("collision", name)
        file = tmp_path / "arms/pair.urdf"
        file.write_text(pair(link=link))
        scene = stark.Scene()
        robot = scene.add_robot(file)
        mesh = robot.links["arm"].collision
        assert mesh is not None
        np.testing.assert_allclose(mesh.bounds, [[0, 0, 0], [1, 2, 1]], atol=1e-15)
        assert mesh.volume > 0.0  # a mirror turns triangles over
        assert robot.links["arm"].visual is None
    file.write_text(
        pair(link=INERTIAL.format('<mass value="1"/>', 0.01) + shape.format("collision", "package://x/a.obj"))
    )
    assert stark.Scene().add_robot(file, packages={"x": folder}).links["arm"].collision is not None
