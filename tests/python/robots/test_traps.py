"""What made robots of packages fail or differ, in small files: all agree with pinocchio and mujoco.

``python -m benchmarks.robots`` reads the packages themselves; benchmarks/results/robots.md is its table."""

from __future__ import annotations

from pathlib import Path

import pytest
from benchmarks.robots.compare import QUANTITIES, compare
from robots._traps import INERTIAL, LIMIT, MJCF, URDF, revolute, urdf

import stark


@pytest.mark.parametrize("name", URDF)
def test_urdf_files_agree_with_pinocchio(name: str, tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    pytest.importorskip("pinocchio")
    _agrees(tmp_path / "trap.urdf", *URDF[name])


@pytest.mark.parametrize("name", MJCF)
def test_mjcf_files_agree_with_mujoco(name: str, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    content, coordinates = MJCF[name]
    _agrees(tmp_path / "trap.xml", f'<mujoco model="trap">{content}</mujoco>', coordinates)


def _agrees(file: Path, content: str, coordinates: tuple[str, ...]) -> None:
    file.write_text(content)
    row = compare("tests", file.parent, file)
    assert row.outcome == "agrees" and set(row.differences) == set(QUANTITIES), row
    assert stark.robots.read(file).coordinates == coordinates


@pytest.mark.parametrize("name", URDF)
def test_urdf_files_are_read_and_built(name: str, tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    file = tmp_path / "trap.urdf"
    file.write_text(URDF[name][0])
    robot = stark.Scene().add_robot(file, base="floating")
    assert robot.coordinates == URDF[name][1]


def test_what_is_taken_otherwise_is_reported(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    file = tmp_path / "trap.urdf"
    for name, line in (
        ("limits that are 0", "joint 'hinge': lower and upper limits 0, or none: taken as without limits"),
        ("mimic of a fixed joint", "joint 'weld': <mimic>: fixed joints follow nothing"),
        ("material inside of a geometry", "link 'link': <material> inside of the <geometry> of <visual>"),
    ):
        file.write_text(URDF[name][0])
        assert line in str(stark.robots.read(file).report)


def test_limits_of_mimics_that_leave_no_way_are_not_kept(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    file = tmp_path / "trap.urdf"
    text, _ = URDF["limit without lower and upper"]
    limit = '<limit lower="0" upper="0.5" effort="5" velocity="3"/>'
    follower = f'type="revolute"><axis xyz="0 0 1"/>{limit}<mimic joint="hinge" multiplier="-1"/>'
    text = text.replace('<limit effort="9" velocity="3"/>', limit).replace('type="fixed">', follower)
    file.write_text(text)
    robot = stark.Scene().add_robot(file)
    assert robot.limits[0] == [0.0] and robot.limits[1] == [0.5]
    assert "limits of joints that mimic it leave it no way" in str(robot.report)


def test_all_that_is_dropped_of_an_mjcf_file_is_listed(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    file = tmp_path / "trap.xml"
    file.write_text(f"<mujoco>{MJCF['actuators of all kinds, tendons, loops'][0]}</mujoco>")
    report = str(stark.robots.read(file).report)
    for name in ("m", "i", "d", "cy"):
        assert f"actuator '{name}': is not built: use robot.add_servos" in report
    for name in ("v", "g", "mu"):
        assert f"actuator '{name}': acts on no single joint: use robot.add_servos" in report
    for line in (
        "tendon 't': has several coordinates, of 'x', 'y'",
        "equality 'c': ",
        "equality 'w': ",
        "equality 'lock': ",
        "limit of effort 6 of joint 'x'",
    ):
        assert line in report
    file.write_text(f"<mujoco>{MJCF['gravity that is off, a medium, compensation'][0]}</mujoco>")
    report = str(stark.robots.read(file).report)
    for line in ("gravity [0.0, 0.0, 0.0] m/s^2", "a medium: density", "body 'a': gravcomp"):
        assert line in report


def test_a_scale_of_four_numbers_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    file = tmp_path / "trap.urdf"
    shape = '<visual><geometry><mesh filename="a.stl" scale="1 1 1 1"/></geometry></visual>'
    file.write_text(urdf(revolute(LIMIT), link=INERTIAL + shape))
    with pytest.raises(
        stark.InvalidArgument, match="<mesh scale='1 1 1 1'>: must be 3 finite numbers; correct it"
    ):
        stark.robots.read(file)
