"""Joints and attachments that hold what they find: suction cups, pickers."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

import stark

STEP = 0.01


def suction(**options: object) -> tuple:
    """A box on a floor, turned and off the centre of a tool that comes down and goes up again; a weld between
    them. Returns scene, box, tool, weld."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    turned = stark.rotation(axis="z", angle=0.3)
    box = scene.add_box(0.1, mass=0.5, position=(0.013, 0.007, 0.051), rotation=turned, name="box")
    tool = scene.add_box(0.04, motion="scripted", position=(0.0, 0.0, 0.2), name="tool")
    weld = scene.add_fixed(tool, box, anchor=(0.0, 0.0, 0.2), enabled=False, name="weld", **options)
    tool.follow(
        position=stark.motion.linear(
            [0.0, 0.2, 0.3, 0.6], [(0, 0, 0.2), (0, 0, 0.123), (0, 0, 0.123), (0, 0, 0.3)]
        ),
        rotation=lambda t: stark.rotation(axis="x", angle=np.clip(t - 0.3, 0.0, 0.3)),
    )
    return scene, box, tool, weld


def seen_from(tool: stark.RigidBody, box: stark.RigidBody) -> tuple[np.ndarray, np.ndarray]:
    (origin, axes), (position, rotation) = tool.pose, box.pose
    return axes.T @ (position - origin), axes.T @ rotation


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_weld_lifts_what_it_finds_as_it_finds_it(integrator: str) -> None:
    scene, box, tool, weld = suction()
    sim = stark.Simulation(scene, time_step=STEP, settings={"time.integrator": integrator})
    sim.run_until(0.25)
    place, turn = seen_from(tool, box)
    assert np.linalg.norm(place - (0.0, 0.0, -0.151)) > 0.01  # not where it was at time 0
    weld.hold_here()
    assert weld.enabled
    sim.run_until(0.8)
    lifted, turned = seen_from(tool, box)
    tolerance = sim.settings["joints.length_tolerance"]
    assert np.linalg.norm(lifted - place) < tolerance + 0.1 * sim.settings["joints.angle_tolerance"]
    assert abs(turned - turn).max() < sim.settings["joints.angle_tolerance"]
    assert box.position[2] > 0.2
    # At rest it carries the weight, about the place where the tool was welded to the box.
    weight = 0.5 * 9.81
    assert weld.reaction.force == pytest.approx([0.0, 0.0, weight], abs=1e-3 * weight)
    lever = box.position - tool.position
    torque = -np.cross(lever, [0.0, 0.0, -weight])  # about the frame, which is where the tool's is
    assert weld.reaction.torque == pytest.approx(torque, abs=1e-3 * weight * 0.1)


def test_a_weld_takes_over_the_momentum_of_both() -> None:
    scene = stark.Scene()
    a = scene.add_box(0.1, mass=1.0, velocity=(1.0, 0.0, 0.0))
    b = scene.add_box(
        0.1, mass=3.0, position=(0.0, 0.3, 0.0), velocity=(1.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 20.0)
    )
    weld = scene.add_fixed(a, b, anchor=(0, 0, 0), enabled=False)
    sim = stark.Simulation(scene, time_step=STEP, gravity=(0, 0, 0))
    sim.run_until(0.05)
    before = sim.step()
    weld.hold_here()
    after = sim.step()
    assert after.momentum == pytest.approx(before.momentum, abs=1e-9)
    assert after.angular_momentum == pytest.approx(before.angular_momentum, abs=1e-9)
    sim.step()
    inertia = 4.0 * 0.1**2 / 6.0 + 0.75 * 0.3**2  # of both about their centre [kg m^2]
    for box in (a, b):
        assert box.angular_velocity[2] == pytest.approx(20.0 * 3.0 * 0.1**2 / 6.0 / inertia, rel=1e-3)


def test_a_ball_joint_holds_points_where_they_meet() -> None:
    scene = stark.Scene()
    bar = scene.add_box((0.2, 0.02, 0.02), mass=0.2, position=(0.1, 0.0, 0.0))
    hook = scene.add_ball(bar, None, anchor=(0.0, 0.0, 0.0), enabled=False)
    sim = stark.Simulation(scene, time_step=STEP)
    sim.run_until(0.1)
    hook.hold_here()
    there = bar.position - bar.rotation @ [0.1, 0.0, 0.0]
    sim.run_until(0.4)
    assert bar.position - bar.rotation @ [0.1, 0.0, 0.0] == pytest.approx(there, abs=2e-6)
    assert there[2] < -0.04
    assert np.linalg.norm(bar.angular_velocity) > 1.0


def towel() -> tuple:
    """A cloth on a floor and a picker above a corner; returns scene, cloth, picker, grip."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    cloth = scene.add_cloth(
        stark.mesh.grid(0.2, 0.2, cells=8), stark.materials.cotton, position=(0, 0, 0.003), name="towel"
    )
    picker = scene.add_sphere(0.01, motion="scripted", position=(0.09, 0.09, 0.1), name="picker")
    grip = scene.attach(cloth.vertices, picker, enabled=False, contact=False, name="grip")
    picker.follow(
        position=stark.motion.linear(
            [0.0, 0.1, 0.2, 0.5], [(0.09, 0.09, 0.1), (0.09, 0.09, 0.02), (0.09, 0.09, 0.02), (0, 0, 0.12)]
        ),
        rotation=lambda t: stark.rotation(axis="z", angle=max(0.0, t - 0.2)),
    )
    return scene, cloth, picker, grip


def nearest(cloth: stark.Cloth, picker: stark.RigidBody, count: int) -> np.ndarray:
    return np.argsort(np.linalg.norm(cloth.positions - picker.position, axis=1), kind="stable")[:count]


def test_a_picker_holds_the_vertices_that_are_near_it_and_lets_go() -> None:
    scene, cloth, picker, grip = towel()
    sim = stark.Simulation(scene, time_step=STEP)
    sim.run_until(0.15)
    assert not grip.held.any() and (grip.forces == 0.0).all()
    near = nearest(cloth, picker, 3)
    offsets = (cloth.positions[near] - picker.position) @ picker.rotation
    grip.hold_here(near)
    assert np.flatnonzero(grip.held).tolist() == sorted(near.tolist()) and not grip.enabled
    sim.run_until(0.7)
    now = (cloth.positions[near] - picker.position) @ picker.rotation
    assert abs(now - offsets).max() < 2e-6
    lifted = cloth.positions[:, 2].max()
    assert lifted > 0.1
    # The cloth hangs from the picker, but for what the floor carries.
    weight = 9.81 * cloth.mass
    assert grip.force[2] + cloth.contact_force[2] == pytest.approx(weight, rel=0.05)
    grip.release(near[:1])
    assert grip.held.sum() == 2
    grip.release()
    sim.run_until(1.2)
    assert not grip.held.any() and cloth.positions[:, 2].max() < 0.03


def test_pairs_that_rest_change_no_bits() -> None:
    hashes = set()
    for some in (False, True):
        scene, cloth, picker, _ = towel()
        sim = stark.Simulation(scene, time_step=STEP)
        sim.run_until(0.15)
        del scene, sim
        scene = stark.Scene()
        scene.add_floor(1.0)
        cloth = scene.add_cloth(
            stark.mesh.grid(0.2, 0.2, cells=8), stark.materials.cotton, position=(0, 0, 0.003)
        )
        picker = scene.add_sphere(0.01, motion="scripted", position=(0.09, 0.09, 0.02))
        chosen = [80, 71, 79]
        meant = cloth.vertices[chosen] if some else cloth.vertices
        grip = scene.attach(meant, picker, enabled=False, contact=False)
        picker.follow(position=stark.motion.linear([0.05, 0.2], [(0.09, 0.09, 0.02), (0, 0, 0.1)]))
        sim = stark.Simulation(scene, time_step=STEP)
        sim.run_until(0.05)
        grip.hold_here(None if some else chosen)
        sim.run_until(0.25)
        hashes.add(cloth.positions.tobytes())
    assert len(hashes) == 1


def test_states_know_the_places(tmp_path: Path) -> None:
    scene, cloth, picker, grip = towel()
    sim = stark.Simulation(scene, time_step=STEP)
    sim.run_until(0.15)
    released = sim.state
    grip.hold_here(nearest(cloth, picker, 3))
    sim.run_until(0.2)
    held = sim.state
    sim.run_until(0.3)
    end, force = sim.state, grip.forces
    sim.state = held
    sim.run_until(0.3)
    assert sim.state == end and (grip.forces == force).all()
    sim.save(tmp_path / "held.stark")
    again = stark.Simulation(towel()[0], time_step=STEP)
    again.load(tmp_path / "held.stark")
    assert again.state == end
    # Another place, from a state without any.
    sim.state = released
    assert not grip.held.any()
    sim.run_until(0.19)
    grip.hold_here(nearest(cloth, picker, 4))
    sim.run_until(0.2)
    sim.reset()
    assert not grip.held.any() and len(sim.state.arrays()["held_place"]) == 0
    sim.state = held
    sim.run_until(0.3)
    assert sim.state == end


def test_threads_and_a_second_grip_give_the_same_bits() -> None:
    ends = []
    for threads in (1, 3):
        scene, cloth, picker, grip = towel()
        sim = stark.Simulation(scene, time_step=STEP, settings={"execution.threads": threads})
        for start, end in itertools.pairwise((0.15, 0.22, 0.3, 0.35)):
            sim.run_until(start)
            grip.hold_here(nearest(cloth, picker, 2))
            sim.run_until(end)
            grip.release()
        ends.append(sim.state)
    assert ends[0] == ends[1]


def test_what_cannot_hold_says_why() -> None:
    scene, cloth, picker, grip = towel()
    always = scene.attach(cloth.vertices[[0]], None, name="nail")
    other = scene.add_cloth(
        stark.mesh.grid(0.1, 0.1, cells=4), stark.materials.cotton, position=(0, 0, 0.5), name="other"
    )
    soft = scene.attach(other.vertices[[0]], cloth, enabled=False, name="soft")
    hinge = scene.add_hinge(picker, None, anchor=(0, 0, 0.1), axis="x", enabled=False, name="hinge")
    weld = scene.add_fixed(picker, None, anchor=(0, 0, 0.1), name="weld")
    sim = stark.Simulation(scene, time_step=STEP)
    before = sim.state
    for call, text in (
        (lambda: always.hold_here(), "'nail': it holds from time 0 on.*enabled = false"),
        (lambda: soft.hold_here([0]), "'soft': what carries pair 0 is not rigid.*exchange the sides"),
        (lambda: hinge.hold_here(), "joint 'hinge' of the kind 'hinge', released at time 0: only fixed"),
        (lambda: weld.hold_here(), "joint 'weld' of the kind 'fixed', held at time 0: only fixed"),
        (lambda: grip.hold_here([0, 81]), r"'grip': pair 81: must be in \[0, 81\)"),
        (lambda: grip.hold_here(-1), r"'grip': pair -1: must be in"),
        (lambda: grip.hold_here([0.5]), "'grip': pairs of shape .1,. and type float64: must be numbers"),
        (lambda: grip.hold_here([True, False]), "'grip': pairs of shape .2,. and type bool"),
        (lambda: grip.release([100]), r"'grip': pair 100: must be in"),
    ):
        with pytest.raises(stark.InvalidArgument, match=text):
            call()
    assert sim.state == before
    grip.hold_here([])
    grip.release([])
    assert sim.state == before


def test_what_has_broken_holds_nothing_any_more() -> None:
    scene, box, tool, weld = suction(break_force=2.0)
    lone = scene.attach(box.points((0, 0, 0.05)), None, enabled=False, break_force=1.0, name="lone")
    sim = stark.Simulation(scene, time_step=STEP)
    sim.run_until(0.25)
    weld.hold_here()
    lone.hold_here()
    sim.run_until(0.4)
    assert weld.broken and lone.broken.all() and box.position[2] < 0.06
    with pytest.raises(stark.InvalidArgument, match="joint 'weld' has broken"):
        weld.hold_here()
    with pytest.raises(stark.InvalidArgument, match="'lone': pair 0 has broken"):
        lone.hold_here([0])
    lone.hold_here()  # none is left
    assert tool.position[2] > 0.15
