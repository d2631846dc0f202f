"""MJCF files: what mujoco compiles is kept, dropped or refused by name."""

from __future__ import annotations

import gc
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from robots._robots import random_mjcf, written_mjcf

import stark.robots

mujoco = pytest.importorskip("mujoco")

BODY = '<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>'


@pytest.mark.parametrize("seed", range(4))
def test_masses_and_tensors_are_those_of_mujoco(seed: int, tmp_path: Path) -> None:
    file = tmp_path / "tree.xml"
    file.write_text(random_mjcf(seed))
    robot = stark.robots.read(file)
    model = mujoco.MjModel.from_xml_path(str(file))
    for name, link in robot.links.items():
        body, inertia = model.body(name), link.inertia
        assert inertia is not None and abs(inertia.mass - body.mass[0]) < 1e-12
        np.testing.assert_allclose(inertia.center, body.ipos, atol=1e-12)
        moments = np.sort(np.linalg.eigvalsh(inertia.tensor))
        np.testing.assert_allclose(moments, np.sort(body.inertia), atol=1e-12)
    joint = robot.joints["j1"]
    assert joint.effort == 20.0 and joint.damping == 0.1 and joint.armature == 0.01
    assert abs(joint.reference - np.deg2rad(10)) < 1e-12


def test_shapes_are_those_of_the_geoms(tmp_path: Path) -> None:
    geoms = (
        '<geom type="box" size=".1 .2 .3" pos="1 0 0"/><geom type="sphere" size=".1"/>'
        '<geom type="capsule" size=".1 .2"/><geom type="cylinder" size=".1 .2"/>'
        '<geom type="ellipsoid" size=".1 .2 .3"/>'
        '<geom type="box" size=".5 .5 .5" contype="0" conaffinity="0" rgba="1 0 0 1"/>'
    )
    robot = stark.robots.read(written_mjcf(tmp_path, f'<body name="a"><freejoint/>{BODY}{geoms}</body>'))
    plane = written_mjcf(tmp_path, f'<body name="a">{BODY}<geom type="plane" size="1 1 1"/></body>')
    link = robot.links["a"]
    kinds = [(shape.kind, shape.size) for shape in link.collisions]
    assert kinds[:4] == [
        ("box", (0.2, 0.4, 0.6)), ("sphere", (0.1,)), ("capsule", (0.1, 0.4)), ("cylinder", (0.1, 0.4))
    ]  # fmt: skip
    assert [shape.size for shape in link.visuals] == [(1.0, 1.0, 1.0)]
    assert link.visuals[0].color == (1.0, 0.0, 0.0) and robot.base == "floating"
    assert "body 'a': a plane: add a floor or a mesh to the scene" in str(stark.robots.read(plane).report)
    scene = stark.Scene()
    placed = scene.add_robot(robot).links["a"].collision
    assert placed is not None and abs(placed.bounds[1, 0] - 1.1) < 1e-12


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("", "<worldbody>: has no body"),
        ('<body name="a"><joint name="j" axis="0 0 x"/></body>', "mujoco cannot read it: "),
    ],
)
@pytest.mark.filterwarnings("ignore:Inertia matrix is too close to singular")
def test_what_is_wrong_with_a_file_is_named(body: str, message: str, tmp_path: Path) -> None:
    file = written_mjcf(tmp_path, body)
    with pytest.raises(stark.InvalidArgument, match=message) as caught:
        stark.robots.read(file)
    assert str(caught.value).startswith(f"'{file}': ")


def test_what_is_dropped_and_kept_is_reported(tmp_path: Path) -> None:
    body = f'<body name="a">{BODY}<joint name="j"/><body name="b">{BODY}<joint name="k"/></body></body>'
    more = (
        '<contact><exclude body1="a" body2="b"/></contact>'
        '<equality><joint joint1="j" joint2="k" polycoef="0 1 1 0 0"/></equality>'
        '<sensor><jointpos joint="j"/></sensor><actuator>'
        '<position name="p" joint="j" kp="1" forcerange="-3 3"/></actuator>'
    )
    robot = stark.robots.read(written_mjcf(tmp_path, body, more))
    report = str(robot.report)
    for line in (
        "equality 'equality_0': only active linear ones of two joints are kept",
        "file: 1 sensors",
        "actuator 'p': stiffness 1 and damping 0 of a servo on 'j'",
        "actuator 'p': limit of effort 3 of joint 'j'",
        "joint 'k': no limit of effort: none",
    ):
        assert line in report
    assert robot.excluded == (("a", "b"),) and robot.joints["j"].effort == 3.0
    assert robot.root == "world" and robot.coordinates == ("j", "k")


def test_shapes_have_the_colour_of_their_material(tmp_path: Path) -> None:
    """Unless they have one of their own."""
    asset = '<asset><material name="red" rgba="1 0 0 1"/></asset>'
    geoms = '<geom size=".1" material="red"/><geom size=".2" material="red" rgba="0 1 0 1"/><geom size=".3"/>'
    robot = stark.robots.read(written_mjcf(tmp_path, f'<body name="a"><freejoint/>{geoms}</body>', asset))
    assert [shape.color for shape in robot.links["a"].collisions] == [
        (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.5, 0.5, 0.5)
    ]  # fmt: skip


def test_warnings_of_mujoco_go_to_the_report_and_to_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "robot.xml"
    file.write_text(
        f'<mujoco><compiler settotalmass="3"/><worldbody><body name="a">{BODY}</body></worldbody></mujoco>'
    )
    monkeypatch.chdir(tmp_path)
    robot = stark.robots.read(file)
    assert "mujoco warns: compiler attribute 'settotalmass' is deprecated" in str(robot.report)
    assert [path.name for path in tmp_path.iterdir()] == ["robot.xml"]


def test_threads_that_read_leave_no_handler_of_warnings(tmp_path: Path) -> None:
    import mujoco

    file = written_mjcf(tmp_path, f'<body name="a">{BODY}</body>')
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: stark.robots.read(file), range(40)))
    assert mujoco.get_mju_user_warning() is None


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="lists open files as Linux does")
def test_reading_leaves_no_file_open(tmp_path: Path) -> None:
    file = written_mjcf(tmp_path, f'<body name="a">{BODY}</body>')
    gc.disable()
    try:
        stark.robots.read(file)
        opened = {os.path.realpath(entry) for entry in Path("/proc/self/fd").iterdir()}
    finally:
        gc.enable()
    assert str(file.resolve()) not in opened


def test_a_file_with_a_nan_leaves_no_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """The parser printed a warning, and wrote one into the working directory."""
    file = written_mjcf(tmp_path, f'<body name="a" pos="0 0 nan">{BODY}</body>')
    monkeypatch.chdir(tmp_path)
    with pytest.raises(stark.InvalidArgument) as caught:
        stark.robots.read(file)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")
    assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_a_missing_reader_is_named_with_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = written_mjcf(tmp_path, f'<body name="a">{BODY}</body>')
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r"need mujoco: pip install 'stark-sim\[robots\]'"):
        stark.robots.read(file)


def test_what_stands_around_the_robot_is_reported(tmp_path: Path) -> None:
    around = '<geom name="ground" type="plane" size="1 1 1"/><geom name="wall" type="box" size=".1 .1 .1"/>'
    robot = stark.robots.read(written_mjcf(tmp_path, f'{around}<body name="a"><freejoint/>{BODY}</body>'))
    for name in ("ground", "wall"):
        assert f"body 'world': geom '{name}': not of the robot; add what stands" in str(robot.report)


def test_joints_start_where_the_file_draws_them(tmp_path: Path) -> None:
    """At `ref`, as in mujoco: at 0 the arm would hang 60 degrees below where it is drawn."""
    geom = '<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>'
    slide = f'<body name="b" pos=".3 0 0"><joint name="b" type="slide" ref="0.01"/>{geom}</body>'
    file = written_mjcf(
        tmp_path, f'<body name="a"><joint name="a" axis="0 1 0" ref="60"/>{geom}{slide}</body>'
    )
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    robot = stark.Scene().add_robot(file)
    np.testing.assert_allclose(robot.q, model.qpos0, atol=1e-12)
    np.testing.assert_allclose(robot.links["b"].position, data.body("b").xpos, atol=1e-12)
    np.testing.assert_allclose(
        stark.Scene().add_robot(file, q={"b": 0.2}).q, [model.qpos0[0], 0.2], atol=1e-12
    )
    assert not stark.Scene().add_robot(file, q=np.zeros(2)).q.any()
