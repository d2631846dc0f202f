"""Robots with loops: the q that close them, where they start and where they are placed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from robots._robots import written_mjcf
from robots.test_mjcf_equalities import BODY, FOUR_BAR, LOOP

import stark

pytest.importorskip("mujoco")

#: Crank, coupler, rocker and ground of the linkage [m], and the directions of crank and coupler at q = 0.
CRANK, ROD, GROUND = math.hypot(0.1, 0.1), math.hypot(0.3, 0.1), 0.4
ROCKER = 0.2


def closes(q: np.ndarray) -> float:
    """Distance of the ends of coupler and rocker [m]; turns about y go from z to x."""

    def along(x: float, z: float, angle: float) -> np.ndarray:
        c, s = math.cos(angle), math.sin(angle)
        return np.array([c * x + s * z, c * z - s * x])

    end = along(0.1, 0.1, q[0]) + along(0.3, 0.1, q[0] + q[1])
    return float(np.linalg.norm(end - np.array([GROUND, 0.0]) - along(0.0, ROCKER, q[2])))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return written_mjcf(tmp_path, FOUR_BAR, LOOP)


@pytest.mark.parametrize("crank", [-0.6, 0.0, 0.3, 1.0])
def test_a_linkage_starts_closed(crank: float, file: Path) -> None:
    scene = stark.Scene()
    robot = scene.add_robot(file, q={"a": crank})
    assert robot.q[0] == crank and closes(robot.q) < 1e-8
    sim = stark.Simulation(scene, time_step=0.01)
    assert not sim.step().failed
    assert list(robot.closures) == ["loop"] and np.abs(robot.closures["loop"].residuals).max() < 1e-6


def test_a_linkage_is_placed_closed_and_stays_so(file: Path) -> None:
    scene = stark.Scene()
    robot = scene.add_robot(file)
    motor = robot.joints["a"].add_motor(target=2.0, cap=20.0, delta=0.1)
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.3)
    robot.q = {"a": 0.5}
    assert abs(robot.q[0] - 0.5) < 1e-12 and closes(robot.q) < 1e-8
    assert not sim.step().failed and closes(robot.q) < 2e-6
    assert abs(motor.joint.rates["angle"] - 2.0) < 0.2
    before = sim.state.hash
    with pytest.raises(
        stark.InvalidArgument, match=r"q: 'loop' holds 'rod' and 'rocker' together, which stay"
    ):
        robot.q = [0.1, 0.2, 0.3]
    assert sim.state.hash == before


def test_documents_keep_loops(file: Path, tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_robot(file, q={"a": 0.2})
    again = stark.load_scene(scene.save(tmp_path / "scene.json"))
    sims = [stark.Simulation(each, time_step=0.01) for each in (scene, again)]
    for sim in sims:
        sim.step()
        sim.robots[0].q = {"a": 0.4}
        sim.step()
    assert sims[0].state.hash == sims[1].state.hash
    assert sims[1].robots[0].closures["loop"].kind == "ball"


def test_what_cannot_be_closed_is_refused(file: Path) -> None:
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match=r"'loop' holds 'rod' and 'rocker' together.* apart"):
        scene.add_robot(file, q={"a": 0.3, "b": 0.0, "c": 0.0})
    assert not scene.bodies and not scene.joints


def test_links_behind_ball_joints_are_where_kinematics_says(tmp_path: Path) -> None:
    body = (
        f'<body name="arm" pos="0 0 1"><joint name="j" axis="0 1 0"/>{BODY}'
        f'<body name="hand" pos="0.3 0 0"><joint name="wrist" type="ball"/>{BODY}'
        f'<body name="tip" pos="0.2 0 0"><joint name="k" axis="0 0 1"/>{BODY}</body></body></body>'
    )
    scene = stark.Scene()
    robot = scene.add_robot(written_mjcf(tmp_path, body))
    assert robot.coordinates == ("j", "k")
    sim = stark.Simulation(scene, time_step=0.005)
    sim.run_until(0.5)
    assert robot.joints["wrist"].kind == "ball"
    frames = robot.forward_kinematics(robot.q)
    for name, link in robot.links.items():
        np.testing.assert_allclose(frames[name][0], link.position, atol=1e-6)
    # The arm turns, and what hangs on the ball joint with it.
    turned = robot.forward_kinematics({"j": float(robot.q[0]) + 0.5})
    shoulder, wrist = np.array([0.0, 0.0, 1.0]), turned["hand"][0]
    assert abs(np.linalg.norm(wrist - shoulder) - 0.3) < 1e-6
    assert abs(np.linalg.norm(turned["tip"][0] - wrist) - 0.2) < 1e-6
    robot.q = {"j": 0.2}
    np.testing.assert_allclose(robot.links["hand"].position, turned_about_y(0.2), atol=1e-6)
    assert not sim.step().failed


ANGLES = np.radians([60.0 * (k // 2 * 2) + 15.0 * (-1) ** k for k in range(6)])
FEET = 0.5 * np.column_stack((np.cos(ANGLES), np.sin(ANGLES), np.zeros(6)))
HIPS = (
    0.3 * np.column_stack((np.cos(ANGLES + np.pi), np.sin(ANGLES + np.pi), np.zeros(6)))[[3, 4, 5, 0, 1, 2]]
)
HOME = np.array([0.0, 0.0, 0.6])


def lengths(position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Of the legs of a platform in the frame of its base [m]."""
    found: np.ndarray = np.linalg.norm(position + HIPS @ rotation.T - FEET, axis=1)
    return found


def platform(passive: str) -> tuple[str, str]:
    """Bodies and equalities of a platform on six legs: joints of a cardan or a ball at their feet, a slide,
    and a ball that closes the loop with a platform that is free."""
    bodies, loops = f'<body name="plate" pos="0 0 {HOME[2]}"><freejoint/>{BODY}</body>', ""
    for k, (foot, way) in enumerate(zip(FEET, HOME + HIPS - FEET, strict=True)):
        axis, length = np.cross([0.0, 0.0, 1.0], way), np.linalg.norm(way)
        angle = math.atan2(float(np.linalg.norm(axis)), way[2])
        quat = np.r_[math.cos(angle / 2), math.sin(angle / 2) * axis / np.linalg.norm(axis)]
        bodies += f'<body name="low{k}" pos="{foot[0]} {foot[1]} 0" quat="{" ".join(map(str, quat))}">'
        bodies += f'{passive}{BODY}<body name="up{k}"><joint name="s{k}" type="slide"/>{BODY}</body></body>'
        loops += f'<connect name="c{k}" body1="up{k}" body2="plate" anchor="0 0 {length}"/>'
    return bodies, f"<equality>{loops}</equality>"


@pytest.mark.parametrize("passive", ['<joint axis="1 0 0"/><joint axis="0 1 0"/>', '<joint type="ball"/>'])
def test_a_free_platform_follows_its_legs(passive: str, tmp_path: Path) -> None:
    """What closes its loops has no coordinate: the platform, and balls at the feet. The way back from lengths
    to the pose is the closed form of lengths."""
    base, turned = np.array([1.0, -2.0, 0.5]), stark.rotation(axis=(1, 2, 0), angle=0.7)
    pose = HOME + np.array((0.04, -0.05, 0.03)), stark.rotation(axis=(1, -1, 2), angle=0.25)
    file, home = written_mjcf(tmp_path, *platform(passive)), lengths(HOME, np.eye(3))
    strokes = {f"s{k}": float(length) for k, length in enumerate(lengths(*pose) - home)}
    scene = stark.Scene()
    robot = scene.add_robot(file, q=strokes, position=base, rotation=turned, contact=False)
    plate = robot.links["plate"]
    np.testing.assert_allclose(plate.position, base + turned @ pose[0], atol=1e-8)
    np.testing.assert_allclose(plate.rotation, turned @ pose[1], atol=1e-8)
    sim = stark.Simulation(scene, time_step=0.01)
    assert not sim.step().failed
    back = HOME + np.array((-0.03, 0.02, -0.06)), stark.rotation(axis=(0, 1, 1), angle=-0.3)
    robot.q = {f"s{k}": float(length) for k, length in enumerate(lengths(*back) - home)}
    np.testing.assert_allclose(plate.position, base + turned @ back[0], atol=1e-8)
    np.testing.assert_allclose(plate.rotation, turned @ back[1], atol=1e-8)
    assert not sim.step().failed
    with pytest.raises(stark.InvalidArgument, match=r"holds 'up\d' and 'plate' together, which stay"):
        robot.q = {"s0": 5.0, "s1": 0.0, "s2": 0.0, "s3": 0.0, "s4": 0.0, "s5": 0.0}
    with pytest.raises(stark.InvalidArgument, match=r"no joint that may move carries it: .* robot\.q of"):
        robot.inverse_kinematics("plate", plate.position - HOME)


def turned_about_y(angle: float) -> np.ndarray:
    return np.array([0.3 * math.cos(angle), 0.0, 1.0 - 0.3 * math.sin(angle)])
