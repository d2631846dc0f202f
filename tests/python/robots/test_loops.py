"""Gravity compensation in closed loops: right where all joints of the loop have it, refused elsewhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark
from stark.robots.loops import in_loops

_LINK = '<inertial pos="0.1 0 0" mass="0.5" diaginertia="1e-3 3e-3 3e-3"/>'
_HINGE = '<joint name="{}" type="hinge" axis="0 -1 0"/>'
# Two links of 0.2 m in a row and a third one, 0.25 m beside, which meets their end.
_MODEL = f"""<mujoco model="loop"><compiler angle="radian"/><worldbody>
  <body name="base"><inertial pos="0 0 0" mass="1" diaginertia="1e-3 1e-3 1e-3"/>
    <body name="crank">{_HINGE.format("j1")}{_LINK}
      <body name="coupler" pos="0.2 0 0">{_HINGE.format("j2")}{_LINK}</body></body>
    <body name="rocker" pos="0.25 0 0">{_HINGE.format("j3")}{_LINK}</body></body>
</worldbody></mujoco>"""
_START = {"j1": 1.2, "j2": -1.0}


def linkage(folder: Path, *, closed: bool = True) -> tuple[stark.Scene, stark.robots.Robot]:
    file = folder / "loop.xml"
    file.write_text(_MODEL)
    scene = stark.Scene()
    tip = 0.2 * np.array([np.cos(1.2) + np.cos(0.2), np.sin(1.2) + np.sin(0.2)])
    away = tip - [0.25, 0.0]
    robot = scene.add_robot(file, q={**_START, "j3": float(np.arctan2(away[1], away[0]))}, contact=False)
    if closed:
        ends = [robot.links[name].body for name in ("coupler", "rocker")]
        scene.add_ball(*ends, anchor=(tip[0], 0.0, tip[1]), name="closing")
    return scene, robot


def test_joints_of_loops_are_found(tmp_path: Path) -> None:
    for closed in (True, False):
        scene, robot = linkage(tmp_path, closed=closed)
        sim = stark.Simulation(scene)
        found = in_loops(robot.coordinates, robot.joints, sim)
        assert found == (dict.fromkeys(("j1", "j2", "j3"), "closing") if closed else {})


def test_a_loop_with_a_joint_that_nothing_drives_is_refused(tmp_path: Path) -> None:
    scene, robot = linkage(tmp_path)
    servos = robot.add_servos(["j1"], stiffness=5.0, damping=0.3, cap=20.0, gravity_compensation=True)
    sim = stark.Simulation(scene, time_step=0.005)
    before = sim.state
    with pytest.raises(
        stark.InvalidArgument, match="'closing' closes a loop with 'j2', 'j3', which has no such"
    ):
        sim.step()
    assert sim.state == before
    servos.gravity_compensation = False
    servos.feedforward = 1.0
    assert not sim.step().failed


def test_a_loop_whose_joints_all_have_it_stays_where_it_is(tmp_path: Path) -> None:
    scene, robot = linkage(tmp_path)
    robot.add_servos(stiffness=0.5, damping=0.1, cap=20.0, gravity_compensation=True)
    sim = stark.Simulation(scene, time_step=0.005)
    start = robot.q
    sim.run_until(0.5)
    assert np.abs(robot.q - start).max() < 1e-5  # [rad]


def test_an_open_tree_with_passive_joints_is_allowed(tmp_path: Path) -> None:
    scene, robot = linkage(tmp_path, closed=False)
    robot.add_servos(["j1"], stiffness=5.0, damping=0.3, cap=20.0, gravity_compensation=True)
    assert not stark.Simulation(scene, time_step=0.005).step().failed
