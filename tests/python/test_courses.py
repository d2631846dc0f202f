"""Loads and actuators whose values are functions of time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stark


def free_box(**settings: Any) -> tuple[stark.Scene, stark.RigidBody]:
    scene = stark.Scene()
    return scene, scene.add_box(0.1, mass=2.0, name="box")


def simulated(scene: stark.Scene) -> stark.Simulation:
    return stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))


def test_a_force_of_time_gives_its_impulse() -> None:
    scene, box = free_box()
    push = scene.add_force(box, lambda t: (0.0, 0.0, 4.0 * t))
    turn = scene.add_torque(box, lambda t: (0.001 * t, 0.0, 0.0))
    np.testing.assert_array_equal(push.force, (0, 0, 0))
    sim = simulated(scene)
    sim.run_until(0.1)
    np.testing.assert_allclose(push.force, (0, 0, 0.4), rtol=1e-12)  # of the end of the last step
    ends = np.arange(1, 11) * 0.01
    assert box.velocity[2] == pytest.approx((4.0 * ends * 0.01).sum() / 2.0, rel=1e-9)
    inertia = 2.0 * 0.01 / 6.0
    assert box.angular_velocity[0] == pytest.approx((0.001 * ends * 0.01).sum() / inertia, rel=1e-6)
    assert turn.torque[0] == pytest.approx(1e-4)


def test_a_number_ends_what_was_followed_and_a_function_begins_it() -> None:
    scene, box = free_box()
    push = scene.add_force(box, (0.0, 0.0, 1.0))
    sim = simulated(scene)
    sim.step()
    push.force = stark.motion.linear([0.0, 1.0], [(0, 0, 0), (0, 0, 10)])
    sim.step()
    np.testing.assert_allclose(push.force, (0, 0, 0.2))
    push.force = (0, 0, 3)
    sim.step()
    np.testing.assert_array_equal(push.force, (0, 0, 3))


def test_targets_of_motors_are_followed_and_in_the_state() -> None:
    scene, box = free_box()
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 0, 1))
    motor = hinge.add_motor(lambda t: 10.0 * t, cap=5.0, delta=1e-3, name="motor")
    assert motor.target == 0.0
    sim = simulated(scene)
    sim.run_until(0.1)
    assert motor.target == pytest.approx(1.0) and hinge.rates["angle"] == pytest.approx(1.0, abs=1e-3)
    tenth = sim.state
    values = tenth.arrays()["actuator_value"]
    assert values[list(motor.units).index("target")] == pytest.approx(1.0)
    sim.run_until(0.2)
    end = sim.state.hash
    sim.reset(tenth)
    sim.run_until(0.2)
    assert sim.state.hash == end
    motor.target = 0.5
    sim.step()
    assert motor.target == 0.5


def test_a_crane_hoists_its_load_on_a_rope_that_gets_shorter() -> None:
    """The trolley moves x = (1 - cos 2t)/4, the rope has the length l = 2 - 0.3 t, and hangs at the angle u:
    l u'' = -g sin u - x'' cos u - 2 l' u'. Its force is m (g cos u - x'' sin u + l u'^2)."""
    scene = stark.Scene()
    trolley = scene.add_box(0.1, motion="scripted")
    trolley.follow(position=lambda t: (0.25 * (1.0 - np.cos(2.0 * t)), 0.0, 0.0))
    load = scene.add_box(0.1, mass=10.0, position=(0.0, 0.0, -2.0))
    rope = scene.add_span(trolley, load, (0.0, 0.0, 0.0), (0.0, 0.0, -2.0))
    hoist = rope.add_limit(upper=lambda t: 2.0 - 0.3 * t)
    sim = stark.Simulation(scene, time_step=0.005, time={"integrator": "bdf2"})
    sim.run_until(2.0)

    def slope(t: float, y: Any) -> list[float]:
        pull = 9.81 * np.sin(y[0]) + np.cos(2.0 * t) * np.cos(y[0]) - 0.6 * y[1]
        return [y[1], -pull / (2.0 - 0.3 * t)]

    u, rate = solve_ivp(slope, (0.0, 2.0), [0.0, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    x, _, z = load.position - trolley.position
    assert np.arctan2(x, -z) == pytest.approx(u, abs=1e-4)
    assert rope.distance == pytest.approx(1.4, abs=1e-6)
    taut = 10.0 * (9.81 * np.cos(u) - np.cos(4.0) * np.sin(u) + 1.4 * rate**2)
    assert -hoist.force == pytest.approx(taut, rel=1e-3)


def test_two_simulations_follow_at_their_own_times() -> None:
    scene, box = free_box()
    scene.add_force(box, lambda t: (0.0, 0.0, 4.0 * t))
    first, second = simulated(scene), simulated(scene)
    first.run_until(0.1)
    second.run_until(0.05)
    first.run_until(0.12)
    alone = simulated(scene)
    alone.run_until(0.12)
    assert alone.state == first.state


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (lambda t: (1.0, 2.0), r"shape \(2,\)"),
        (lambda t: "far", "must be of real numbers"),
        (lambda t: (0, 0, np.inf), "must be finite"),
        (lambda: (0, 0, 1), "must be a number, or a function of the time"),
    ],
)
def test_functions_of_something_else_are_refused(value: Any, message: str) -> None:
    scene, box = free_box()
    with pytest.raises(stark.InvalidArgument, match=message):
        scene.add_force(box, value)
    push = scene.add_force(box, (0, 0, 1))
    with pytest.raises(stark.InvalidArgument, match=message):
        push.force = value
    sim = simulated(scene)
    sim.step()
    np.testing.assert_array_equal(push.force, (0, 0, 1))


def test_functions_where_numbers_are_bound_are_refused_with_what_may_be_one() -> None:
    scene, box = free_box()

    @stark.energy
    def pull(p: stark.Point, center: stark.Vec3):
        return 0.5 * (p.x - center) @ (p.x - center)

    with pytest.raises(stark.InvalidArgument, match=r"value at time 0; assign .* energy\.center = "):
        pull(box.vertices, center=lambda t: (0.0, 0.0, t))
    energy = scene.add(pull(box.vertices, center=(0.0, 0.0, 0.0)))
    energy.center = lambda t: (0.0, 0.0, t)
    sim = simulated(scene)
    sim.step()
    assert energy.center[2] == pytest.approx(0.01)
    with pytest.raises(stark.InvalidArgument, match=r"break_force = .* only values of loads, actuators and"):
        scene.add_ball(None, box, anchor=(0, 0, 0), break_force=lambda t: 3.0 - t)  # type: ignore[arg-type]


def test_a_function_that_fails_later_says_when(tmp_path: object) -> None:
    scene, box = free_box()
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    hinge.add_effort(lambda t: 1.0 if t < 0.015 else "none", name="effort")
    sim = simulated(scene)
    sim.step()
    before = sim.state
    with pytest.raises(stark.InvalidArgument, match=r"at 0\.02 s"):
        sim.step()
    assert sim.state == before


def test_checkpoints_go_on_with_the_functions_of_the_scene(tmp_path: object) -> None:
    scene, box = free_box()
    scene.add_force(box, lambda t: (0.0, 0.0, 4.0 * t))
    sim = simulated(scene)
    sim.run_until(0.05)
    sim.save(f"{tmp_path}/half.stark")
    sim.run_until(0.1)
    end = sim.state
    sim.load(f"{tmp_path}/half.stark")
    sim.run_until(0.1)
    assert sim.state == end


def test_a_reproducer_has_the_values_of_its_step(tmp_path: object) -> None:
    scene, box = free_box()
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 0, 1))
    hinge.add_motor(lambda t: 10.0 * t, cap=5.0, delta=1e-3)
    sim = simulated(scene)
    sim.run_until(0.05)
    sim.write_reproducer(f"{tmp_path}/step")
    again = stark.reproducer.load(f"{tmp_path}/step")
    assert not again.step().failed
    assert again.state == sim.state and again.actuators == []  # it acts, but has no handle
    assert again._core.actuator_value(0, "target") == pytest.approx(0.5)


def test_a_reproducer_of_a_step_after_placing_starts_from_there(tmp_path: object) -> None:
    scene, box = free_box()
    sim = simulated(scene)
    sim.step()
    box.position, box.velocity = (0, 0, 3), (0, 1, 0)
    sim.step()
    sim.write_reproducer(f"{tmp_path}/step")
    again = stark.reproducer.load(f"{tmp_path}/step")
    again.step()
    assert again.state == sim.state
