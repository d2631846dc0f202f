"""Joints in closed loops that contradict each other within their tolerances: forces that cancel each other
must not grow, nor brake or drive what moves [theory eq. 25a]."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _mechanisms import simulate

import stark

TILT = np.pi / 2 - 1.5708  # [rad] of an axis, where a file has 1.5708 for a right angle
G = 9.81  # [m/s^2]


def door(
    tilt: float, speed: float = 1.0, **breaks: float
) -> tuple[stark.Scene, stark.RigidBody, list[stark.Joint]]:
    """Turns with 1 rad/s about two hinges, of which one is out of line."""
    scene = stark.Scene()
    turning: dict[str, Any] = {"angular_velocity": (0, 0, speed), "velocity": (0, 0.4 * speed, 0)}
    leaf = scene.add_box((0.8, 0.04, 2.0), mass=6.4, position=(0.4, 0, 1), **turning)
    lower = scene.add_hinge(None, leaf, (0, 0, 0.2), (0, np.sin(tilt), np.cos(tilt)), **breaks)
    upper = scene.add_hinge(None, leaf, (0, 0, 1.8), (0, 0, 1))
    return scene, leaf, [lower, upper]


def wrenches(joints: list[stark.Joint]) -> np.ndarray:
    return np.array([[*joint.reaction.force, *joint.reaction.torque] for joint in joints])


@pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_door_on_hinges_that_are_not_quite_in_line(step: float, integrator: str) -> None:
    """It turns on as if they were in line, with the same forces: they were 10¹² N after 20 ms in steps of
    0.1 ms, and the door turned with 950 rad/s."""
    ends = []
    for tilt in (0.0, TILT):
        scene, leaf, joints = door(tilt)
        sim = simulate(scene, step, **{"time.integrator": integrator})
        for _ in range(300):
            report = sim.step()
            assert not report.failed, report.message
            assert report.newton_iterations < 10
        ends.append((leaf.angular_velocity[2], wrenches(joints)))
    (rate, straight), (tilted_rate, tilted) = ends
    # The change of what the hinges are off by in a step pushes as a damper does: 1.4e-7 / h [1/s].
    duration = 300 * step
    assert tilted_rate == pytest.approx(rate, abs=(1e-4 + 5e-8 / step) * max(1.0, duration))
    assert straight[:, 2] == pytest.approx(np.full(2, 6.4 * G / 2), rel=1e-3)
    assert tilted == pytest.approx(straight, abs=0.5)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_penalties_that_grew_in_a_step_do_not_push_in_the_next_one(integrator: str) -> None:
    """Misfits of a quarter of the tolerance in steps of 0.1 ms: the door was thrown from 3 to -16 rad/s and
    back within two steps, with bdf2 to -25."""
    scene, leaf, joints = door(TILT * 2, speed=3.0)
    sim = simulate(scene, 1e-4, **{"time.integrator": integrator})
    for report in sim.run(until=0.2):
        assert leaf.angular_velocity[2] == pytest.approx(3.0, abs=0.02)  # a damper
        assert "misfit_loop" not in report.caveats
    assert np.abs(wrenches(joints)[:, :3]).max() < 6.4 * (G + 0.4 * 9.0)


@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_a_loop_that_does_not_fit_says_so_before_it_jams(step: float) -> None:
    """Twice as far out of line: off by the tolerance after 70 degrees, where it jams."""
    scene, leaf, joints = door(2 * TILT)
    sim = simulate(scene, step)
    for report in sim.run(until=1.5):
        if report.caveats:
            break
        # Implicit Euler loses half of ω² h a second.
        assert leaf.angular_velocity[2] == pytest.approx(1.0, abs=2e-3 + step)
    assert report.caveats == ["misfit_loop"]
    # Each is off by 0.8 m times the tilt times the sine of the angle, less what the door gives way.
    assert 1.0 < sim.time < 1.3
    for text in ("joint 'hinge'", "joint 'hinge_2'", "joints.length_tolerance = 1e-06 m", "loosen"):
        assert text in report.message
    assert len(joints) == 2


def test_an_attachment_in_a_loop_that_does_not_fit_is_named() -> None:
    """An eye on a post in place of the upper hinge."""
    scene = stark.Scene()
    turning: dict[str, Any] = {"angular_velocity": (0, 0, 1), "velocity": (0, 0.4, 0)}
    leaf = scene.add_box((0.8, 0.04, 2.0), mass=6.4, position=(0.4, 0, 1), **turning)
    post = scene.add_box((0.05, 0.05, 0.05), motion="fixed", position=(-0.2, 0, 1.8))
    scene.add_hinge(None, leaf, (0, 0, 0.2), (0, np.sin(2 * TILT), np.cos(2 * TILT)))
    scene.attach(leaf.points((-0.4, 0, 0.8)), post.points((0.2, 0, 0)), name="eye")
    report = next(r for r in simulate(scene, 1e-3).run(until=1.6) if r.caveats)
    assert report.caveats == ["misfit_loop"]
    assert "a closed loop does not fit: attachment 'eye', pair 0, joint 'hinge', off by " in report.message


def test_a_jam_that_fails_is_named() -> None:
    scene, _, _ = door(2 * TILT, speed=3.0)
    sim = simulate(scene, 1e-2)
    for _ in range(100):
        report = sim.step()
        if report.failed:
            break
    assert report.diagnosis is not None
    assert report.diagnosis.cause == "contradicting_joints"
    assert "closed loop does not fit: joint 'hinge" in report.message


def test_a_loop_that_fits_within_the_tolerance_does_not_break() -> None:
    """It raised its forces from step to step until it broke, after some milliseconds."""
    scene, leaf, joints = door(TILT, break_force=1e3, break_torque=1e3)
    sim = simulate(scene, 1e-4)
    sim.run_until(0.1)
    assert not joints[0].broken
    assert np.abs(wrenches(joints)[:, :3]).max() < 6.4 * G
    assert leaf.angular_velocity[2] == pytest.approx(1.0, abs=1e-3)


def test_a_loop_that_jams_breaks() -> None:
    scene, leaf, joints = door(2 * TILT, break_force=1e3, break_torque=1e3)
    sim = simulate(scene, 1e-3)
    for report in sim.run(until=1.5):
        assert leaf.angular_velocity[2] == pytest.approx(1.0, abs=0.02), report.message
    assert joints[0].broken


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize(("speed", "step", "mass"), [(0.01, 1e-3, 2.0), (0.1, 1e-2, 1e-3), (1e-4, 1e-3, 2.0)])
def test_what_is_torn_breaks(integrator: str, speed: float, step: float, mass: float) -> None:
    """A rigid bar between the world and a grip that moves away: no motion can follow, so the glue breaks."""
    scene = stark.Scene()
    grip = scene.add_box(0.1, motion="scripted", position=(-1, 0, 0), velocity=(-speed, 0, 0))
    bar = scene.add_box((1, 0.1, 0.1), mass=mass)
    scene.add_fixed(grip, bar, (-0.5, 0, 0))
    glue = scene.add_fixed(None, bar, (0.5, 0, 0), break_force=100.0)
    sim = simulate(scene, step, gravity=(0, 0, 0), **{"time.integrator": integrator})
    for _ in range(5):
        report = sim.step()
        assert not report.failed, report.message
    assert not glue.enabled


def test_loops_beside_one_that_may_break_are_relieved() -> None:
    """The door again, next to a bar whose ends may break."""
    scene, _, joints = door(TILT)
    bar = scene.add_box((1, 0.1, 0.1), mass=2.0, position=(0, 3, 0))
    scene.add_fixed(None, bar, (-0.5, 3, 0))
    scene.add_fixed(None, bar, (0.5, 3, 0), break_force=100.0)
    sim = simulate(scene, 1e-4)
    sim.run_until(0.03)
    assert np.abs(wrenches(joints)).max() < 6.4 * G


def parallelogram(excess: float) -> tuple[stark.Scene, list[stark.Joint]]:
    """A coupler on three parallel cranks, of which one is too far away and its pin too high."""
    scene = stark.Scene()
    places = (0.0, 1.0, 2.0 + excess)
    cranks = [scene.add_box((0.05, 0.05, 1.0), density=1000.0, position=(x, 0, -0.5)) for x in places]
    coupler = scene.add_box((2.0, 0.05, 0.05), density=1000.0, position=(1, 0, -1), velocity=(1, 0, 0))
    joints = []
    for k, (x, crank) in enumerate(zip(places, cranks, strict=True)):
        joints.append(scene.add_hinge(None, crank, (x, 0, 0), (0, 1, 0)))
        height = -1.0 + (excess if k == 2 else 0.0)
        joints.append(scene.add_hinge(coupler, crank, (float(k), 0, height), (0, 1, 0)))
    return scene, joints


def test_a_third_crank_that_does_not_quite_fit_carries_its_share() -> None:
    """It carried 8e7 N more after 60 steps, and steps took 16 iterations."""
    ends = []
    for excess in (0.0, 5e-7):
        scene, joints = parallelogram(excess)
        sim = simulate(scene, 1e-4, **{"contact.enabled": False})
        for _ in range(60):
            report = sim.step()
            assert not report.failed, report.message
            assert report.newton_iterations <= 5
        ends.append(wrenches(joints))
    assert ends[1] == pytest.approx(ends[0], abs=0.02)
    weight = G * (3 * 2.5 + 5.0)
    assert np.linalg.norm(ends[0][::2, :3].sum(axis=0)) > weight  # of what swings, too


def test_loops_resume_bit_for_bit_on_any_number_of_threads(tmp_path: Path) -> None:
    hashes = []
    for threads in (1, 3):
        scene, _ = parallelogram(5e-7)
        sim = simulate(scene, 1e-3, **{"contact.enabled": False, "threads": threads})
        sim.run_until(0.02)
        if threads == 1:
            sim.save(tmp_path / "half.stark")
        sim.run_until(0.04)
        hashes.append(sim.state.hash)
    scene, _ = parallelogram(5e-7)
    sim = simulate(scene, 1e-3, **{"contact.enabled": False})
    sim.load(tmp_path / "half.stark")
    sim.run_until(0.04)
    assert {sim.state.hash, *hashes} == {hashes[0]}


def test_a_stop_that_repeats_another_takes_half() -> None:
    """An arm rests on two stops of one hinge, 10⁻⁶ rad apart."""
    scene = stark.Scene()
    arm = scene.add_box((1.0, 0.05, 0.05), mass=2.0, position=(0.5, 0, 0))
    hinge = scene.add_hinge(None, arm, (0, 0, 0), (0, -1, 0))
    stops = [hinge.add_limit(lower=-1e-3), hinge.add_limit(lower=-1e-3 - 1e-6)]
    sim = simulate(scene, 1e-3)
    sim.run_until(0.5)
    torques = [stop.torque for stop in stops]
    assert sum(torques) == pytest.approx(2.0 * G * 0.5, rel=1e-3)
    assert max(map(abs, torques)) < 10.0
