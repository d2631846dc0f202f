"""What handles of joints measure and do: coordinates, reactions, releasing, holding again."""

from __future__ import annotations

import copy
import warnings

import numpy as np
import pytest

import stark

G = 9.81


def body(
    scene: stark.Scene, position: tuple[float, float, float] = (0.0, 0.0, 0.0), mass: float = 1.0
) -> stark.RigidBody:
    return scene.add_box(0.1, mass=mass, position=position)


def simulate(scene: stark.Scene, **settings: object) -> stark.Simulation:
    return stark.Simulation(scene, **{"time_step": 0.01, "contact.enabled": False, **settings})


def test_a_slider_measures_free_fall_and_carries_nothing_along_its_axis() -> None:
    scene = stark.Scene()
    slider = scene.add_slider(None, body(scene), anchor=(0, 0, 0), axis=(0, 0, 1))
    sim = simulate(scene)
    for _ in range(10):
        sim.step()
    np.testing.assert_allclose(slider.displacement, -G * 1e-4 * 55, rtol=1e-6)
    np.testing.assert_allclose(slider.rates["displacement"], -G * 0.1, rtol=1e-6)
    assert abs(slider.reaction.force[2]) < 1e-9


def test_a_distance_joint_is_a_pendulum_rod() -> None:
    scene = stark.Scene()
    bob = body(scene, (0.5, 0.0, 0.0))
    rod = scene.add_distance(None, bob, anchor_a=(0, 0, 0), anchor_b=(0.5, 0, 0))
    sim = simulate(scene)
    for _ in range(30):
        sim.step()
        np.testing.assert_allclose(np.linalg.norm(bob.position), 0.5, atol=1e-6)
    assert np.linalg.norm(rod.reaction.force) > 0.0


def test_release_and_hold_again() -> None:
    scene = stark.Scene()
    falling = body(scene)
    joint = scene.add_ball(None, falling, anchor=(0, 0, 0))
    assert joint.enabled
    sim = simulate(scene)
    sim.step()
    joint.enabled = False
    sim.step()
    assert falling.position[2] < -9e-4 and not joint.enabled
    joint.pull_together()
    assert joint.enabled
    assert not sim.step().failed
    assert abs(falling.position[2]) < 1e-6


def test_a_joint_whose_frames_are_apart_is_not_held_again() -> None:
    """A fall of 0.44 m; a step that pulls it back would throw it with 19 kJ."""
    scene = stark.Scene()
    falling = body(scene)
    joint = scene.add_fixed(None, falling, anchor=(0, 0, 0), name="hold")
    sim = simulate(scene)
    joint.enabled = False
    joint.enabled = True  # it has not moved
    joint.enabled = False
    sim.run_until(0.3)
    falling.rotation = stark.rotation(axis="x", angle=0.2)
    before = sim.state
    with pytest.raises(
        stark.InvalidArgument,
        match=r"'hold': its frames differ by 0\.456 m and 0\.2 rad now: must be within 1e-06 m and 1e-05 rad",
    ):
        joint.enabled = True
    assert sim.state == before and not joint.enabled
    falling.position, falling.rotation = (0.0, 0.0, 0.0), np.eye(3)  # the remedy of the message
    joint.enabled = True
    falling.velocity = falling.angular_velocity = (0.0, 0.0, 0.0)
    report = sim.step()
    assert joint.enabled and not report.failed and np.abs(falling.position).max() < 1e-6
    assert abs(report.energy["numerical"]) < 1e-6


def test_a_joint_needs_a_simulation_to_be_read() -> None:
    scene = stark.Scene()
    joint = scene.add_hinge(None, body(scene), anchor=(0, 0, 0))
    with pytest.raises(stark.InvalidArgument, match="needs a simulation"):
        _ = joint.angle
    with pytest.raises(AttributeError, match="no attribute 'angel'"):
        _ = joint.angel


def test_reactions_after_a_rewind_are_those_of_the_state() -> None:
    scene = stark.Scene()
    arm = body(scene, (0.2, 0.0, 0.0))
    hinge = scene.add_hinge(None, arm, anchor=(0, 0, 0), axis=(0, 1, 0))
    sim = simulate(scene)
    for _ in range(5):
        sim.step()
    before, reaction = sim.state, hinge.reaction
    for _ in range(20):
        sim.step()
    assert np.abs(hinge.reaction.force - reaction.force).max() > 1.0
    sim.state = before
    # Forces are kept, not multipliers alone. The sums of both differ by the rounding of positions times the
    # stiffness of the joint, a few times 2.8e-9 N here.
    np.testing.assert_allclose(hinge.reaction.force, reaction.force, rtol=0.0, atol=2e-8)
    np.testing.assert_allclose(hinge.reaction.torque, reaction.torque, rtol=0.0, atol=2e-8)
    other = simulate(scene)
    other.state = before
    np.testing.assert_array_equal(other.joints[0].reaction.force, hinge.reaction.force)


def test_torques_on_a_patch_are_about_the_origin_of_its_frame() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2))
    place = (0.03, 0.04, 0.02)  # off the vertices, above the plane
    ball = scene.add_ball(stark.world_frame(place), cloth.frame((4, 5, 7), position=place))
    sim = simulate(scene)
    for _ in range(5):
        assert not sim.step().failed
    force, torque = ball.reaction
    assert np.linalg.norm(force) > 1e-2
    # A ball joint has no torque about its own centre.
    assert np.linalg.norm(torque) < 1e-6 * np.linalg.norm(force)


def test_attributes_that_would_do_nothing_are_refused() -> None:
    scene = stark.Scene()
    hinge = scene.add_hinge(None, body(scene), anchor=(0, 0, 0), axis=(0, 1, 0))
    sim = simulate(scene)
    with pytest.raises(AttributeError, match="'displacement' cannot be set; angle, coordinates"):
        hinge.displacement = 1.0  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match="'enabeld' cannot be set"):
        hinge.enabeld = False  # type: ignore[attr-defined]
    with pytest.warns(stark.StarkWarning, match="joint 'ball' was added after"):
        later = scene.add_ball(None, scene.bodies[0], anchor=(0, 0, 0))
    with pytest.raises(stark.InvalidArgument, match="was added after the simulation was created"):
        _ = later.reaction
    assert len(sim.joints) == 1
    assert copy.copy(hinge).name == "hinge"


def test_servo_targets_of_many_whole_turns_are_taken_for_degrees() -> None:
    """As angles of stark.rotation; a slider has metres."""
    scene = stark.Scene()
    hinge = scene.add_hinge(None, body(scene), anchor=(0, 0, 0), axis=(0, 1, 0))
    both = scene.add_cylindrical(None, body(scene, (1, 0, 0)), anchor=(1, 0, 0), axis="z")
    gains = {"stiffness": 1.0, "damping": 0.1, "cap": 1.0}
    with pytest.warns(stark.StarkWarning, match=r"'hinge': add_servo: target = 90 rad is 14.3 turns") as told:
        hinge.add_servo(90, **gains)
    assert told[0].filename == __file__
    with pytest.warns(stark.StarkWarning, match=r"target = -45 rad.* write -45 \* stark.deg if"):
        both.add_servo(-45, coordinate="angle", **gains)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hinge.add_servo(90.0, enabled=False, **gains)
        servo = hinge.add_servo(25, enabled=False, **gains)
        along = both.add_servo(90, coordinate="displacement", **gains)
        along.target = 90
    with pytest.warns(stark.StarkWarning, match=r"'position_servo_4': target = 90 rad is 14.3") as told:
        servo.target = 90  # in the loop, too
    assert told[0].filename == __file__ and servo.target == 90.0


def test_angles_of_many_whole_turns_are_taken_for_degrees() -> None:
    scene = stark.Scene()
    hinge = scene.add_hinge(None, body(scene), anchor=(0, 0, 0), axis=(0, 1, 0))
    slider = scene.add_slider(None, body(scene, (1, 0, 0)), anchor=(1, 0, 0), axis="z")
    sim = simulate(scene)
    with pytest.warns(stark.StarkWarning, match="'hinge': angle = 90 rad is 14.3 turns"):
        hinge.angle = 90
    assert abs(hinge.angle - 90.0) < 1e-9
    with pytest.warns(stark.StarkWarning, match=r"write -45 \* stark.deg if"):
        hinge.coordinates = {"angle": -45}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hinge.angle = 90.0
        hinge.rates = {"angle": 90}
        slider.displacement = 90
    assert not sim.step().failed
