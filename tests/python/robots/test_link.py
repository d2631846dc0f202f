"""Links of robots in a scene: contact wrenches against statics."""

from __future__ import annotations

import numpy as np
from robots._robots import ARM

import stark
from stark.robots import Geometry, Inertia, Link, RobotDescription, RobotJoint

BODY = Inertia(0.5, np.zeros(3), 1e-3 * np.eye(3))


def shape(*edges: float, at: tuple[float, float, float] = (0, 0, 0)) -> tuple[Geometry, ...]:
    return (Geometry("box", edges, position=np.array(at, dtype=float)),)


def test_a_floor_carries_the_weight_of_what_stands_on_it() -> None:
    """A block on feet that are links of their own, fixed to it; its centre of mass is off the middle, so that
    the feet carry the weight by the law of the lever."""
    mass, away, center, gravity = 3.0, 0.2, 0.05, 9.81
    links = [
        Link(
            "block",
            Inertia(mass, np.array([center, 0, 0]), 0.01 * np.eye(3)),
            collisions=shape(0.5, 0.1, 0.1),
        ),
        *(Link(name, collisions=shape(0.02, 0.06, 0.04)) for name in ("left", "right")),
    ]
    joints = [
        RobotJoint(f"{name}_fixed", "fixed", "block", name, np.array([x, 0.0, -0.07]))
        for name, x in (("left", -away), ("right", away))
    ]
    scene = stark.Scene()
    scene.add_floor(2.0)
    description = RobotDescription("stool", links, joints, base="floating")
    robot = scene.add_robot(
        description, position=(0.3, 0.4, 0.0905), rotation=stark.rotation(axis=(0, 0, 1), angle=0.5)
    )
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.6)
    wrenches = {name: link.contact_wrench() for name, link in robot.links.items()}
    weight = mass * gravity
    feet = wrenches["left"].force + wrenches["right"].force
    np.testing.assert_allclose(feet, [0, 0, weight], atol=1e-3 * weight)
    np.testing.assert_array_equal(wrenches["block"], 0.0)
    lever = weight * center / away  # difference of what the feet carry
    # A foot carries anywhere on its sole, 0.02 m wide: that shifts the lever by its half at most.
    difference = wrenches["right"].force[2] - wrenches["left"].force[2]
    assert abs(difference - lever) < weight * 0.01 / away
    # Moments about the centre of mass vanish; about the frame of each foot its force is on the sole.
    block = robot.links["block"]
    center_of_mass = block.position + block.rotation @ (center, 0.0, 0.0)
    total = sum(
        wrenches[name].torque + np.cross(robot.links[name].position - center_of_mass, wrenches[name].force)
        for name in ("left", "right")
    )
    np.testing.assert_allclose(total, 0.0, atol=1e-3 * weight * away)
    floor = robot.links["left"].contact_wrench("floor")
    np.testing.assert_array_equal(floor.force, wrenches["left"].force)
    np.testing.assert_array_equal(
        sim.robots[0].links["left"].contact_wrench().torque, wrenches["left"].torque
    )


def test_a_finger_presses_with_the_force_of_its_drive() -> None:
    """A finger on a slide presses a block against a wall with 20 N; its pad is a link of its own, 0.1 m from
    the frame of the finger."""
    press, arm = 20.0, 0.1
    links = [
        Link("stand"),
        Link("finger", BODY, collisions=shape(0.02, 0.02, 0.02)),
        Link("pad", collisions=shape(0.02, 0.03, 0.03)),
    ]
    joints = [
        RobotJoint("slide", "prismatic", "stand", "finger", lower=-0.1, upper=0.1),
        RobotJoint("pad_fixed", "fixed", "finger", "pad", np.array([0.0, 0.0, -arm])),
    ]
    scene = stark.Scene()
    robot = scene.add_robot(RobotDescription("finger", links, joints), position=(0, 0, 0.5))
    scene.add_box((0.1, 0.2, 0.2), name="wall", motion="fixed", position=(0.061, 0, 0.37))
    drive = robot.add_efforts("slide")
    sim = stark.Simulation(scene, time_step=0.01)
    drive.target = press
    sim.run_until(0.3)
    pad, finger = robot.links["pad"].contact_wrench(), robot.links["finger"].contact_wrench("wall")
    np.testing.assert_allclose(pad.force, [-press, 0, 0], atol=1e-3 * press)
    np.testing.assert_array_equal(finger, 0.0)
    # About the frame of the pad: the wall covers all of it, so that the sum acts in its face, 0.01 m ahead.
    assert (np.abs(pad.torque) <= press * 0.015).all()
    # About the frame of the finger the same force has the arm of the pad.
    about_finger = pad.torque + np.cross(
        robot.links["pad"].position - robot.links["finger"].position, pad.force
    )
    assert abs(about_finger[1] - pad.torque[1] - press * arm) < 1e-3 * press * arm


def test_a_part_of_the_world_touches_nothing() -> None:
    links = [Link("stand"), Link("arm", BODY, collisions=shape(0.02, 0.02, 0.02))]
    joint = RobotJoint("turn", "continuous", "stand", "arm")
    robot = stark.Scene().add_robot(RobotDescription("arm", links, [joint]))
    np.testing.assert_array_equal(robot.links["stand"].contact_wrench(), 0.0)


def test_overlapping_links_are_found_by_their_bodies() -> None:
    pairs = []
    for by_link in (True, False):
        scene = stark.Scene()
        robot = scene.add_robot(ARM)
        palm = robot.links["palm"]
        crate = scene.add_box(0.02, mass=0.1, position=palm.position, name="crate")
        chosen = [*robot.links.values(), palm, crate] if by_link else None
        pairs.append([(a.name, b.name) for a, b in scene.disable_overlapping(chosen)])
    assert pairs[0] == pairs[1] and ("arm.palm", "crate") in pairs[0]
