"""Deformable parts of a description: what holds them, what they are of, what is assumed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stark
from stark.robots import Geometry, Inertia, Link, RobotDescription, RobotJoint
from stark.robots.description import Flex

SHEET = stark.mesh.grid(0.2, 0.2, cells=4)
BLOCK = stark.mesh.tet_box((0.1, 0.1, 0.1), cells=2).translated((0.5, 0.0, 0.0))


def flag(**more: object) -> Flex:
    """A sheet beside its link, held at one side."""
    vertices = SHEET.vertices + np.array([0.15, 0.0, 0.0])
    held = tuple(np.flatnonzero(SHEET.vertices[:, 0] < -0.099).tolist())
    made = Flex("flag", "arm", vertices, SHEET.triangles, 0.05, held)
    return replace(made, **more)  # type: ignore[arg-type]


def robot_with(*flexes: Flex) -> RobotDescription:
    inertia = Inertia(1.0, np.zeros(3), 0.01 * np.eye(3))
    links = [Link("stand"), Link("arm", inertia, collisions=(Geometry("box", (0.06, 0.3, 0.06)),))]
    joint = RobotJoint("turn", "continuous", "stand", "arm", axis=np.array([0.0, 0.0, 1.0]))
    return RobotDescription("waver", links, [joint], flexes=flexes)


def test_held_vertices_follow_their_link() -> None:
    """A robot that starts turned, with a sheet that hangs from its arm."""
    scene = stark.Scene()
    robot = scene.add_robot(robot_with(flag()), q=[0.7], position=(0.0, 0.0, 1.0))
    assert robot.flexes["flag"].name == "waver.flag" and len(scene.attachments) == 1
    servo = robot.add_servos(stiffness=50.0, damping=5.0, cap=20.0)
    sim = stark.Simulation(scene, time_step=0.01)
    held = list(flag().held)
    servo.target = [1.2]
    sim.run_until(0.5)
    position, rotation = robot.links["arm"].pose
    local = (sim.robots[0].flexes["flag"].positions[held] - position) @ rotation
    np.testing.assert_allclose(local, flag().vertices[held], atol=1e-5)
    assert robot.q[0] == pytest.approx(1.2, abs=0.05)
    assert sim.robots[0].flexes["flag"].positions[:, 2].min() < 0.95
    assert "no elasticity or thickness: cotton" in str(robot.report)


def test_what_the_world_holds_is_pinned() -> None:
    scene = stark.Scene()
    held = tuple(np.flatnonzero(BLOCK.vertices[:, 2] > 0.049).tolist())
    block = Flex(
        "block", "stand", BLOCK.vertices, BLOCK.tets, 1.0, held, youngs_modulus=1e5, poissons_ratio=0.3
    )
    robot = scene.add_robot(robot_with(block), position=(0.0, 0.0, 2.0))
    assert sorted(robot.flexes["block"].pins) == sorted(held) and not scene.attachments
    sim = stark.Simulation(scene, time_step=0.01)
    before = sim["waver.block"].positions[list(held)]
    sim.run_until(0.1)
    assert np.array_equal(sim["waver.block"].positions[list(held)], before)


def test_names_of_links_are_checked_and_scenes_stay_whole() -> None:
    with pytest.raises(stark.InvalidArgument, match="flex 'flag': link 'leg': must be the name of a link"):
        robot_with(flag(link="leg"))
    with pytest.raises(stark.InvalidArgument, match="flex 'flag': is there twice"):
        robot_with(flag(), flag())
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match="mass"):
        scene.add_robot(robot_with(flag(), flag(name="other", mass=-1.0)))
    assert not scene.bodies and not scene.attachments and not scene.robots


def test_a_rod_of_which_nothing_is_said() -> None:
    line = stark.mesh.polyline((0.1, 0.0, 0.0), (0.4, 0.0, 0.0), segments=3)
    cord = Flex("cord", "arm", line.vertices, line.edges, 0.01, (0,))
    robot = stark.Scene().add_robot(robot_with(cord))
    rod = robot.flexes["cord"]
    assert isinstance(rod, stark.Rod) and rod.mass == pytest.approx(0.01)
    assert (rod.material.radius, rod.material.youngs_modulus) == pytest.approx((5e-4, 1e6))
    for said in ("no diameter: 0.001 m", "no elasticity: a modulus of 1e+06 Pa", "1 vertices are fixed"):
        assert said in str(robot.report)
