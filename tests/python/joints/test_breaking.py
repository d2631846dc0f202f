"""Joints that break: at which force and torque, what follows, states that come back, messages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

QUIET: dict[str, Any] = {"contact.enabled": False}
MASS, ARM, G = 2.0, 0.3, 9.81  # [kg, m, m/s^2]


def beam(**limits: float) -> tuple[stark.Simulation, stark.Joint]:
    """A box held by a weld at the end of an arm without mass: the weight, and the weight times the arm."""
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=MASS, position=(ARM, 0, 0))
    weld = scene.add_fixed(None, box, anchor=(0, 0, 0), **limits)
    return stark.Simulation(scene, time_step=0.01, **QUIET), weld


@pytest.mark.parametrize("limit", ["break_force", "break_torque"])
def test_it_breaks_above_the_reaction_and_holds_below(limit: str) -> None:
    reaction = MASS * G if limit == "break_force" else MASS * G * ARM
    for factor, breaks in ((1.01, False), (0.99, True)):
        sim, weld = beam(**{limit: factor * reaction})
        for _ in range(5):
            assert not sim.step().failed
        assert (weld.broken, weld.enabled) == (breaks, not breaks)
        z = sim.bodies[0].position[2]
        # Released at the end of the first step, it falls freely for four.
        assert z == pytest.approx(-G * 1e-4 * (1 + 2 + 3 + 4) if breaks else 0.0, abs=3e-5)  # joints give way


def test_the_force_of_the_step_that_breaks_it_can_be_read() -> None:
    sim, weld = beam(break_force=0.5 * MASS * G)
    sim.step()
    assert weld.broken
    assert np.linalg.norm(weld.reaction.force) == pytest.approx(MASS * G, rel=1e-2)


def test_broken_joints_stay_so_but_for_a_rewind() -> None:
    sim, weld = beam(break_force=0.5 * MASS * G)
    start = sim.state
    sim.step()
    with pytest.warns(stark.StarkWarning, match="joint 'fixed' is broken and stays released"):
        weld.enabled = True  # it had no effect, silently
    assert weld.broken
    assert not weld.enabled
    sim.run_until(0.05)
    end = sim.state
    sim.state = start
    assert not weld.broken
    assert weld.enabled
    sim.run_until(0.05)
    assert sim.state == end


def test_what_is_broken_is_not_told_to_be_enabled() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=MASS, position=(ARM, 0, 0))
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 1, 0), break_force=0.5 * MASS * G)
    sim = stark.Simulation(scene, time_step=0.01, **QUIET)
    sim.run_until(0.2)
    assert hinge.broken
    with pytest.raises(stark.InvalidArgument, match=r"'hinge' is broken.*place the bodies") as caught:
        hinge.angle = 0.1
    assert "enable" not in str(caught.value)


def test_a_motor_on_a_broken_hinge_rests() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=MASS, position=(0, 0, 0))
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 0, 1), break_force=0.5 * MASS * G)
    motor = hinge.add_motor(10.0, cap=0.05, delta=0.1)
    sim = stark.Simulation(scene, time_step=0.01, **QUIET)
    sim.step()
    spin = np.array(box.angular_velocity)
    assert hinge.broken
    for _ in range(3):
        sim.step()
    assert box.angular_velocity == pytest.approx(spin, abs=1e-9)
    assert motor.effort == 0.0


def test_bodies_of_a_broken_joint_touch_again() -> None:
    scene = stark.Scene()
    plate = scene.add_box((0.2, 0.2, 0.02), motion="scripted", position=(0, 0, -0.2))
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0))
    weld = scene.add_fixed(plate, box, break_force=0.5 * G)
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3)
    sim.run_until(0.6)
    assert weld.broken
    assert box.position[2] == pytest.approx(-0.2 + 0.01 + 0.05, abs=2e-3)


def test_limits_are_in_documents(tmp_path: Any) -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    scene.add_ball(None, box, anchor=(0, 0, 0), break_force=3.0, name="link")
    scene.save(tmp_path / "scene.json")
    loaded = stark.load_scene(tmp_path / "scene.json").joints[0]
    assert (loaded.break_force, loaded.break_torque) == (3.0, np.inf)


@pytest.mark.parametrize("value", [0.0, -1.0, "much"])
def test_wrong_limits_are_named(value: Any) -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    with pytest.raises(stark.InvalidArgument, match="joint 'ball': break_torque"):
        scene.add_ball(None, box, anchor=(0, 0, 0), break_torque=value)


def test_what_holds_nothing_cannot_break() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=MASS, position=(0, 0, 0))

    @stark.joint
    def gauge(a: stark.Frame, b: stark.Frame):
        return stark.hold(displacement={"distance": stark.norm(b.origin - a.origin)})

    for add in (
        lambda: scene.add_span(None, box, (0, 0, 1), (0, 0, 0.05), break_force=5.0),
        lambda: scene.add_tilt(None, box, anchor=(0, 0, 0), axis=(0, 0, 1), break_torque=5.0),
        lambda: scene.add_joint(gauge, None, box, anchor=(0, 0, 1), break_force=5.0),
    ):
        with pytest.raises(stark.InvalidArgument, match="holds nothing that could break"):
            add()
    assert len(scene.joints) == 0


def test_a_limit_that_no_reaction_can_exceed_is_refused() -> None:
    """Each of these had the limit and never broke: the reaction that it bounds is always zero."""

    def held(**limits: float) -> list[Any]:
        scene = stark.Scene()
        a = scene.add_box(0.1, mass=MASS)
        motion: dict[str, Any] = {"velocity": (0.3, 1.0, 2.0), "angular_velocity": (1.0, 3.0, 2.0)}
        b = scene.add_box(0.1, mass=MASS, position=(0.2, 0.05, 0.0), **motion)
        return [
            lambda: (scene, scene.add_ball(a, b, anchor=(0.1, 0, 0), **limits)),
            lambda: (scene, scene.add_point_on_axis(a, b, anchor=(0.1, 0, 0), axis="x", **limits)),
            lambda: (scene, scene.add_distance(a, b, (0.05, 0, 0), (0.15, 0.05, 0), **limits)),
            lambda: (scene, scene.add_joint("orientation", a, b, anchor=(0.1, 0, 0), **limits)),
        ]

    for k, has_no in enumerate(("torque", "torque", "torque", "force")):
        with pytest.raises(stark.InvalidArgument, match=f"break_{has_no} = 5: must be left out"):
            held(**{f"break_{has_no}": 5.0})[k]()
        other = "force" if has_no == "torque" else "torque"
        scene, joint = held(**{f"break_{other}": 1e3})[k]()
        sim = stark.Simulation(scene, gravity=(0, 0, 0), **QUIET)
        sim.step()  # it takes away what the joint does not allow
        assert np.abs(getattr(joint.reaction, has_no)).max() < 1e-9
        assert np.abs(getattr(joint.reaction, other)).max() > 1e-3
