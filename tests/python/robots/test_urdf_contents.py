"""URDF files: what nothing reads is named once; quaternions turn as the angles that they stand for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._robots import pair

import stark.robots
from stark.rotations import as_matrix

pytest.importorskip("yourdfpy")

AXIS = '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="5" velocity="2"/>'
MASS = '<mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>'


def test_what_nothing_reads_is_named_once(tmp_path: Path) -> None:
    file = tmp_path / "pair.urdf"
    joint = AXIS.replace("velocity", 'acceleration="3" velocity') + (
        '<dynamics damping="1" spring_stiffness="7"/><hardwareInterface/>'
    )
    link = (
        f"<inertial>{MASS}</inertial><contact><lateral_friction value='2'/></contact><colision/>"
        '<visual><geometry><box size="1 1 1"/></geometry><material name="m"><texture filename="m.png"/>'
        "</material></visual>"
    )
    file.write_text(pair(joint, link))
    assert [str(finding) for finding in stark.robots.read(file).report.dropped] == [
        "link 'arm': <contact> in <link> is not read",
        "link 'arm': <colision> in <link> is not read",
        "link 'arm': <texture> in <material> is not read",
        "joint 'hinge': <hardwareInterface> in <joint> is not read",
        "joint 'hinge': <limit acceleration='3'> is not read",
        "joint 'hinge': <dynamics spring_stiffness='7'> is not read",
    ]


def test_what_is_there_twice_is_suspicious(tmp_path: Path) -> None:
    file = tmp_path / "pair.urdf"
    other = MASS.replace('mass value="1"', 'mass value="3"')
    file.write_text(pair(link=f"<inertial>{MASS}</inertial><inertial>{other}</inertial>"))
    robot = stark.robots.read(file)
    assert "link 'arm': <inertial> is there 2 times: the first is taken" in str(robot.report)
    inertia = robot.links["arm"].inertia
    assert inertia is not None and inertia.mass == 1.0


@pytest.mark.parametrize(
    "xyzw", [(0.1, -0.4, 0.7, 0.5), (0.0, 0.5**0.5, 0.0, 0.5**0.5), (0.5, -0.5, 0.5, 0.5)]
)
def test_quaternions_of_origins_turn(xyzw: tuple[float, ...], tmp_path: Path) -> None:
    """The second and third point the x axis down and up, where roll and yaw are one."""
    file = tmp_path / "pair.urdf"
    text = " ".join(map(str, xyzw))
    file.write_text(pair(f'<origin xyz="0 0 1" quat_xyzw="{text}"/>{AXIS}'))
    joint = stark.robots.read(file).joints["hinge"]
    unit = np.array([xyzw[3], *xyzw[:3]]) / np.linalg.norm(xyzw)
    np.testing.assert_allclose(joint.rotation, as_matrix(unit, "origin"), atol=1e-12)
    np.testing.assert_allclose(joint.position, (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("origin", "message"),
    [
        ('quat_xyzw="0 0 0 1" rpy="0 0 0"', "must not stand beside rpy"),
        ('quat_xyzw="0 0 0 0"', "must not be zero"),
        ('quat_xyzw="0 0 1"', "must be 4 finite numbers"),
    ],
)
def test_quaternions_that_turn_nothing_are_refused(origin: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "pair.urdf"
    file.write_text(pair(f"<origin {origin}/>{AXIS}"))
    with pytest.raises(stark.InvalidArgument, match=f"joint 'hinge': <origin .*{message}"):
        stark.robots.read(file)
