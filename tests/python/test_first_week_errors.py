"""Slips of the first week: each answer names the object, what was asked, and what to write instead."""

from __future__ import annotations

import pytest

import stark


def test_values_of_actuators_go_by_place_as_in_the_guide() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis="z")
    spring = hinge.add_spring(2.0, 0.1, 0.5)
    assert (spring.stiffness, spring.damping, spring.rest) == (2.0, 0.1, 0.5)
    assert hinge.add_friction(1.0, 2e-3).stick_rate == 2e-3
    assert hinge.add_brake(1.0, 2e-4).give == 2e-4


def test_parts_that_there_are_not() -> None:
    scene = stark.Scene()
    robot = scene.add_robot("examples/robot_arm.urdf")
    with pytest.raises(stark.InvalidArgument, match=r"unknown link 'pam' \(did you mean 'palm'\?\)"):
        robot.links["pam"]
    with pytest.raises(stark.InvalidArgument, match="joint 0: must be a name, not a number"):
        robot.joints[0]
    assert "pam" not in robot.links and robot.links.get("pam") is None
    with pytest.raises(IndexError, match=r"joint number 99: must be in \[-"):
        scene.joints[99]
    with pytest.raises(IndexError, match="joint number 0: must be of one that there is: there are none"):
        stark.Scene().joints[0]


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("tetrahedra", "write tets"),
        ("faces", "write triangles"),
        ("translate", "mesh.translated"),
        ("vertex", "vertices"),
    ],
)
def test_names_of_meshes(name: str, hint: str) -> None:
    with pytest.raises(AttributeError, match=f"TetMesh has no attribute '{name}'.*{hint}"):
        getattr(stark.mesh.tet_box(0.1, 1), name)
    assert not hasattr(stark.mesh.box(0.1), name)


def test_friction_of_a_scene_is_assigned_by_pair() -> None:
    with pytest.raises(
        AttributeError, match=r"friction can be read, not assigned: write scene.friction\[a, b\]"
    ):
        stark.Scene().friction = 0.5  # type: ignore[misc]


def test_the_last_report_is_what_a_step_returns() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    sim = stark.Simulation(scene)
    with pytest.raises(AttributeError, match=r"no attribute 'report': write what sim.step\(\)"):
        sim.report  # noqa: B018


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("mas", "did you mean 'mass'"),
        ("restitution", r"of pairs: scene\.restitution\[body, other\]"),  # it was taken for rotation
        ("kinematic", "give motion='scripted'"),  # and this for inertia
        ("static", "give motion='fixed'"),
        ("material", "give mass= or density="),
        ("surface_velocity", r"assign it to the body: body\.surface_velocity = "),  # for velocity
        ("center_of_mass", r"give inertia=\(mass, centre of mass"),
    ],
)
def test_words_of_other_simulators_for_rigid_bodies(word: str, hint: str) -> None:
    scene = stark.Scene()
    with pytest.raises(
        TypeError, match=rf"add_box\(\) got an unexpected keyword argument '{word}'; .*{hint}"
    ):
        scene.add_box(0.1, **{word: 1.0})
    assert not scene.bodies
