"""Actuators in Python: short forms, live values, sensors, errors. Closed forms in motion are in
tests/sim/test_simulation_actuators.cpp."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import stark
from stark.joints.handle import Actuator

G = 9.81
H = 0.01


def machine(kind: str = "hinge", **options: object) -> tuple[stark.Scene, stark.RigidBody, stark.Joint]:
    """A body of 1 kg with moments of inertia of 0.02 kg m^2 on an upright joint."""
    scene = stark.Scene()
    body = scene.add_rigid(stark.mesh.box(0.1), inertia=(1.0, (0, 0, 0), 0.02 * np.eye(3)), **options)
    return scene, body, getattr(scene, f"add_{kind}")(None, body, anchor=(0, 0, 0), axis=(0, 0, 1))


def simulate(scene: stark.Scene, **settings: object) -> stark.Simulation:
    options = {
        "time_step": H,
        "contact.enabled": False,
        "gravity": (0, 0, 0),
        "newton.acceleration_tolerance": 1e-6,
    }
    return stark.Simulation(scene, **{**options, **settings})


def advance(sim: stark.Simulation, steps: int) -> None:
    for _ in range(steps):
        report = sim.step()
        assert report.status == "accepted", report.message


def test_a_press_moves_as_the_closed_form_of_implicit_euler_and_never_beyond_its_cap() -> None:
    scene, _, slider = machine("slider")
    motor = slider.add_motor(0.5, cap=2.0, delta=0.1)
    sim = simulate(scene)
    v = 0.0
    for _ in range(60):
        advance(sim, 1)
        linear = (v + H * 20.0 * 0.5) / (1.0 + H * 20.0)
        v = v + H * 2.0 if 0.5 - linear > 0.1 else linear
        np.testing.assert_allclose(slider.rates["displacement"], v, rtol=1e-7)
        assert abs(motor.force) <= 2.0 * (1.0 + 1e-9)
        assert motor.power == pytest.approx(motor.effort * v)
    assert motor.kind == "velocity_motor" and motor.joint is slider
    assert motor.units == {"target": "m/s", "cap": "N", "delta": "m/s"}


def test_targets_follow_the_loop() -> None:
    scene, _, hinge = machine()
    servo = hinge.add_servo(stiffness=4.0, damping=0.4, cap=3.0)
    sim = simulate(scene)
    for target in (0.5, -2.0, 3.0 * math.tau):
        servo.target = target
        for _ in range(400):
            advance(sim, 1)
            assert abs(servo.torque) <= 3.0 * (1.0 + 1e-9)
        assert hinge.angle == pytest.approx(target, abs=1e-4)


def test_values_before_a_simulation_are_those_it_starts_with() -> None:
    scene, _, hinge = machine()
    drive = hinge.add_effort()
    drive.target = 0.25
    assert drive.target == 0.25 and drive.parameters == {"target": 0.25}
    first = simulate(scene)
    advance(first, 1)
    assert drive.effort == pytest.approx(0.25, rel=1e-12)
    drive.target = -1.0
    second = simulate(scene)
    assert second.actuators[0].target == 0.25 and first.actuators[0].target == -1.0
    assert drive.target == 0.25  # the latest simulation


def test_values_are_part_of_the_state() -> None:
    scene, _, hinge = machine()
    servo = hinge.add_servo(1.0, stiffness=4.0, damping=0.1, cap=3.0, integral=1.0)
    sim = simulate(scene)
    advance(sim, 5)
    before = sim.state.copy()
    servo.target = 2.0
    hashes = [(advance(sim, 1), sim.state.hash)[1] for _ in range(3)]
    sim.state = before
    assert servo.target == 1.0
    servo.target = 2.0
    assert [(advance(sim, 1), sim.state.hash)[1] for _ in range(3)] == hashes


def test_switching_off() -> None:
    scene, _, hinge = machine()
    drive = hinge.add_effort(0.3, enabled=False)
    assert not drive.enabled
    sim = simulate(scene)
    advance(sim, 2)
    assert drive.effort == 0.0 and hinge.angle == 0.0
    drive.enabled = True
    advance(sim, 2)
    assert drive.enabled and drive.torque == pytest.approx(0.3)
    hinge.enabled = False
    advance(sim, 1)
    assert drive.effort == 0.0
    with pytest.raises(stark.InvalidArgument, match="must be True or False"):
        drive.enabled = 1  # type: ignore[assignment]


def test_limits_of_a_hinge_carry_what_leans_on_them() -> None:
    scene = stark.Scene()
    arm = scene.add_box(0.1, mass=2.0, position=(0.5, 0.0, 0.0))
    hinge = scene.add_hinge(None, arm, anchor=(0, 0, 0), axis=(0, 1, 0), limits=(-0.2, 0.4))
    (stop,) = hinge.actuators
    sim = simulate(scene, gravity=(0, 0, -G))
    advance(sim, 100)
    assert hinge.angle == pytest.approx(0.4, abs=1e-5)
    assert stop.torque == pytest.approx(-2.0 * G * 0.5 * math.cos(0.4), rel=1e-3)


def test_springs_ropes_and_cones() -> None:
    scene = stark.Scene()
    load = scene.add_box(0.1, mass=1.0)
    spring = scene.add_spring(None, load, (0, 0, 0.5), (0, 0, 0), stiffness=100.0, damping=20.0)
    assert spring.rest == pytest.approx(0.5) and spring.joint.kind == "span"
    pole = scene.add_box((0.02, 0.02, 0.5), mass=0.3, position=(2.0, 0.0, 0.25))
    scene.add_ball(None, pole, anchor=(2, 0, 0))
    tilt = scene.add_tilt(None, pole, anchor=(2, 0, 0), axis=(0, 0, 1), limit=0.3)
    rope = spring.joint.add_limit(upper=0.9)
    sim = simulate(scene, gravity=(1.0, 0, -G))
    advance(sim, 500)
    pull = math.hypot(1.0, G)
    # The load still swings by a part in a thousand.
    assert spring.joint.distance == pytest.approx(0.5 + pull / 100.0, rel=1e-3)
    assert spring.force == pytest.approx(-pull, rel=1e-2)
    assert tilt.angle == pytest.approx(0.3, abs=1e-5)
    spring.enabled = False
    advance(sim, 300)
    assert spring.joint.distance <= 0.9 + 1e-6
    assert rope.force == pytest.approx(-pull, rel=0.05)  # still swings a little


def test_a_gear_of_two_wheels() -> None:
    scene, _, first = machine()
    other = scene.add_rigid(
        stark.mesh.box(0.1), inertia=(1.0, (0, 0, 0), 0.02 * np.eye(3)), position=(1, 0, 0)
    )
    second = scene.add_hinge(None, other, anchor=(1, 0, 0), axis=(0, 0, 1))
    gear = second.add_gear(first, ratio=-0.5)
    first.add_effort(0.1)
    sim = simulate(scene)
    advance(sim, 50)
    assert second.angle == pytest.approx(-0.5 * first.angle, abs=1e-5)
    # Implicit Euler of a rotation loses h rate^3 of the rate in a second.
    assert first.rates["angle"] == pytest.approx(0.1 / (0.02 + 0.25 * 0.02) * 0.5, rel=1e-2)
    assert gear in first.actuators and gear in second.actuators
    assert [name for _, name in gear.coordinates] == ["angle", "angle"]


def test_friction_and_armature_and_coordinates_of_a_cylindrical_joint() -> None:
    scene = stark.Scene()
    body = scene.add_rigid(
        stark.mesh.box(0.1), inertia=(1.0, (0, 0, 0), 0.02 * np.eye(3)), velocity=(0, 0, 1.0)
    )
    joint = scene.add_cylindrical(None, body, anchor=(0, 0, 0), axis=(0, 0, 1))
    brake = joint.add_friction(2.0, coordinate="displacement")
    joint.add_armature(0.06, coordinate="angle")
    joint.add_effort(0.16, coordinate="angle")
    sim = simulate(scene)
    advance(sim, 20)
    assert brake.force == pytest.approx(-2.0)
    assert joint.rates["angle"] == pytest.approx(0.16 / 0.08 * 0.2, rel=1e-3)
    advance(sim, 60)
    # v^2 / (2 a) less half a step: implicit Euler sums the rates at the ends of the steps.
    assert joint.displacement == pytest.approx(0.25 - 0.5 * H, abs=1e-4)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s, j: j.add_motor(1.0, cap=-1.0, delta=1.0), "cap = -1 N m: must be >= 0"),
        (lambda s, j: j.add_motor(np.nan, cap=1.0, delta=1.0), "target = nan rad/s: must be finite"),
        (lambda s, j: j.add_motor("fast", cap=1.0, delta=1.0), "target = 'fast': must be a number"),
        (lambda s, j: j.add_actuator("velocity_motor", target=1.0, cap=1.0), "'delta' .rad/s. is missing"),
        (lambda s, j: j.add_actuator("effort", torque=1.0), "unknown value 'torque'|is missing"),
        (lambda s, j: j.add_actuator("servo"), "unknown actuator 'servo'"),
        (lambda s, j: j.add_actuator(3), "name of a built-in actuator"),
        (lambda s, j: j.add_effort(coordinate="angel"), "did you mean 'angle'"),
        (lambda s, j: j.add_effort(1.0, nme="x"), r"unknown value 'nme' \(did you mean 'name'\?\).*target"),
        (lambda s, j: j.add_limit(), "neither lower nor upper"),
        (lambda s, j: j.add_limit(1.0, -1.0), "lower must be below upper"),
        (lambda s, j: j.add_limit(-np.inf, 1.0), r"lower = -inf: must be finite; .* joint.add_limit.upper="),
        (lambda s, j: j.add_limit(-1.0, np.inf), r"upper = inf: must be finite; .* joint.add_limit.lower="),
        (lambda s, j: s.add_hinge(None, s.bodies[0], anchor=(0, 0, 0), limits=(1, 0)), "lower < upper"),
        (lambda s, j: s.add_actuator("gear", j, ratio=1.0), "on 1 coordinates: must be on 2"),
        (lambda s, j: s.add_actuator("effort", "hinge", target=1.0), "must be a joint"),
        (lambda s, j: stark.Scene().add_actuator("effort", j, target=1.0), "belongs to another scene"),
        (lambda s, j: s.add_ball(None, s.bodies[0], anchor=(0, 0, 0)).add_effort(), "has no coordinate"),
        (
            lambda s, j: s.add_cylindrical(None, s.bodies[0], anchor=(0, 0, 0), axis=(0, 0, 1)).add_effort(),
            "must name the one to act on",
        ),
    ],
)
def test_bad_actuators_are_refused(call: object, message: str) -> None:
    scene, _, hinge = machine()
    with pytest.raises(stark.InvalidArgument, match=message):
        call(scene, hinge)  # type: ignore[operator]
    assert scene.actuators == ()


def test_bad_values_are_refused_and_change_nothing() -> None:
    scene, _, hinge = machine()
    motor = hinge.add_motor(1.0, cap=2.0, delta=0.5)
    with pytest.raises(stark.InvalidArgument, match="effort needs a simulation"):
        _ = motor.effort
    for sim in (None, simulate(scene)):
        with pytest.raises(stark.InvalidArgument, match="delta = 0 rad/s: must be > 0"):
            motor.delta = 0.0
        with pytest.raises(stark.InvalidArgument, match="must be a number"):
            motor.target = (1.0, 2.0)  # type: ignore[assignment]
        with pytest.raises(AttributeError, match="no value 'speed'; its values are target, cap, delta"):
            motor.speed = 1.0
        with pytest.raises(AttributeError, match="no attribute 'speed'"):
            _ = motor.speed
        assert motor.parameters == {"target": 1.0, "cap": 2.0, "delta": 0.5}, sim
    with pytest.raises(stark.InvalidArgument, match="has no force; use torque"):
        _ = motor.force
    assert "target" in dir(motor) and "velocity_motor" in repr(motor)
    hinge.add_limit(lower=0.1)
    with pytest.raises(stark.InvalidArgument, match=r"is off by 0.1 rad at time 0"):
        simulate(scene)


def test_a_screw_is_a_gear_within_a_cylindrical_joint_and_no_coordinate_is_geared_to_itself() -> None:
    """A nut of mass m and inertia I that falls along its thread: a = g / (1 + I / (m p^2)), p in m/rad."""
    scene = stark.Scene()
    nut = scene.add_box(0.1, mass=1.0)
    thread = scene.add_cylindrical(None, nut, anchor=(0, 0, 0), axis=(0, 0, 1))
    thread.add_gear(thread, ratio=0.05, coordinate="displacement", other_coordinate="angle")
    wheel = scene.add_hinge(
        None, scene.add_box(0.1, mass=1.0, position=(1, 0, 0)), anchor=(1, 0, 0), axis=(0, 0, 1)
    )
    for joint, names in (
        (wheel, {}),
        (wheel, {"coordinate": "angle"}),
        (thread, dict.fromkeys(("coordinate", "other_coordinate"), "angle")),
    ):
        with pytest.raises(stark.InvalidArgument, match="add_gear: both coordinates are the same one"):
            joint.add_gear(joint, ratio=2.0, **names)
    with pytest.raises(stark.InvalidArgument, match=r"actuator 'effort': target = 'x': must be a number"):
        wheel.add_effort("x")  # type: ignore[arg-type]
    sim = stark.Simulation(scene, time_step=0.002, time={"integrator": "bdf2"})
    sim.run_until(0.5)
    inertia = 0.1**2 / 6.0
    fall = 0.5 * 9.81 / (1.0 + inertia / 0.05**2) * 0.5**2
    assert thread.coordinates["displacement"] == pytest.approx(-fall, rel=2e-3)
    assert thread.coordinates["angle"] == pytest.approx(-fall / 0.05, rel=2e-3)  # several turns


def test_a_brake_holds_without_creep_and_gives_way_in_proportion() -> None:
    scene, _, hinge = machine()
    brake = hinge.add_brake(1.0, give=2e-3)
    push = hinge.add_effort(0.75)
    sim = simulate(scene)
    advance(sim, 100)
    assert hinge.angle == pytest.approx(0.75 * 2e-3, rel=1e-6)
    assert abs(hinge.rates["angle"]) < 1e-9  # friction would creep, at half of its stick rate
    assert brake.torque == pytest.approx(-0.75, rel=1e-6)
    push.target = 0.0
    advance(sim, 100)
    assert abs(hinge.angle) < 1e-9


def test_a_brake_slips_at_its_cap_and_holds_what_it_stopped() -> None:
    """1 kg at 1 m/s under 0.5 N against 2 N: 1.5 m/s^2, to rest in 2/3 s; then held where it stopped."""
    scene, _, slider = machine("slider", velocity=(0, 0, 1.0))
    brake = slider.add_brake(2.0, give=1e-5, engaged=0.0)
    slider.add_effort(0.5)
    sim = simulate(scene, time_step=1e-3)
    advance(sim, 200)
    speed = slider.rates["displacement"]
    assert speed == pytest.approx(1.0 + 0.5 * 0.2, rel=1e-6) and brake.force == 0.0
    start = slider.displacement
    brake.engaged = 1.0
    advance(sim, 100)
    assert brake.force == pytest.approx(-2.0, rel=1e-9)
    advance(sim, 1400)
    # Less half a step of the first speed, as implicit Euler has it; the rest is what it gives.
    assert slider.displacement - start == pytest.approx(speed**2 / 3.0 - 0.5e-3 * speed, abs=3e-5)
    assert abs(slider.rates["displacement"]) < 1e-9
    assert brake.force == pytest.approx(-0.5, rel=1e-6)


def test_a_brake_holds_where_it_is_engaged_and_rewinds() -> None:
    scene, body, slider = machine("slider", velocity=(0, 0, 0.5))
    brake = slider.add_brake(1e3, engaged=0.0)
    sim = simulate(scene)
    advance(sim, 10)
    where, state = slider.displacement, sim.state
    ends = []
    for _ in range(2):
        sim.state = state
        brake.engaged = 1.0
        advance(sim, 60)
        assert slider.displacement == pytest.approx(where, abs=1e-3)
        ends.append(body.position.copy())
        brake.engaged = 0.0
        advance(sim, 1)
        assert brake.force == 0.0
    np.testing.assert_array_equal(ends[0], ends[1])
    with pytest.raises(stark.InvalidArgument, match="engaged"):
        brake.engaged = 2.0
    with pytest.raises(stark.InvalidArgument, match="give"):
        slider.add_brake(1.0, give=0.0)


def test_limits_that_look_like_degrees_warn() -> None:
    scene = stark.Scene()
    arm = scene.add_box(0.1, mass=1.0)
    hinge = scene.add_hinge(None, arm, anchor=(0, 0, 0), axis="z")
    with pytest.warns(stark.StarkWarning, match=r"lower = -90 rad, upper = 90 rad.*90 \* stark\.deg"):
        hinge.add_limit(-90, 90)
    with pytest.raises(AttributeError, match="'hinge' has no attribute 'angel'; its coordinates: angle"):
        _ = hinge.angel
    with pytest.raises(AttributeError, match=r"no attribute 'add_motr'.*did you mean 'add_motor'"):
        hinge.add_motr(target=1.0, cap=1.0, delta=1.0)


def test_dry_friction_is_refused_where_nothing_has_a_rate() -> None:
    """It would hold nothing; dampers, and friction capped at zero, have nothing to do."""
    static = {"time.integrator": "quasistatic"}
    scene, _, hinge = machine()
    hinge.add_friction(cap=1.0)
    with pytest.raises(stark.InvalidArgument, match=r"joint_friction acts on a rate, .* or brake here"):
        simulate(scene, **static)

    scene, _, hinge = machine()
    damper = hinge.add_friction(cap=0.0, viscous=0.3)
    off = hinge.add_friction(cap=1.0, enabled=False)
    hinge.add_spring(stiffness=1.0)
    sim = simulate(scene, **static)
    advance(sim, 1)
    assert damper.torque == 0.0
    with pytest.raises(stark.InvalidArgument, match="acts on a rate"):
        damper.cap = 1.0
    with pytest.raises(stark.InvalidArgument, match="acts on a rate"):
        off.enabled = True
    damper.viscous = 0.5
    advance(sim, 1)


def test_a_second_servo_on_a_coordinate_warns() -> None:
    """Both would draw, each to its target."""
    _, _, hinge = machine()
    hinge.add_servo(0.5, stiffness=50.0, damping=5.0, cap=100.0, name="first")
    hinge.add_motor(1.0, cap=1.0, delta=0.1)
    hinge.add_spring(stiffness=1.0)
    hinge.add_spring(stiffness=2.0)  # springs side by side are common
    hinge.add_servo(0.0, stiffness=1.0, damping=0.1, cap=1.0, enabled=False)
    with pytest.warns(
        stark.StarkWarning, match=r"'first' is a servo .* add up; assign target, .*enabled=False"
    ):
        hinge.add_servo(0.7, stiffness=80.0, damping=5.0, cap=100.0)
    with pytest.warns(stark.StarkWarning, match="is a motor on its angle already"):
        hinge.add_motor(2.0, cap=1.0, delta=0.1)


def test_a_servo_follows_a_moving_target_with_its_rate() -> None:
    """Without it the damping brakes what should move: it lags by damping / stiffness times the speed."""
    behind = {}
    for knows_rate in (False, True):
        scene, _, hinge = machine()
        servo = hinge.add_servo(lambda t: 2.0 * t, stiffness=50.0, damping=5.0, cap=100.0)
        if knows_rate:
            servo.target_rate = 2.0
        sim = simulate(scene)
        sim.run_until(2.0)
        behind[knows_rate] = 4.0 - hinge.angle
    assert behind[False] == pytest.approx(2.0 * 5.0 / 50.0, rel=1e-3)
    assert abs(behind[True]) < 1e-3


def test_actuators_of_a_joint_are_found_without_a_look_at_all_others(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = stark.Scene()
    joints = []
    for k in range(30):
        bar = scene.add_box((0.1, 0.02, 0.02), mass=0.1, position=(0.2 * k, 0, 0))
        joints.append(scene.add_hinge(None, bar, anchor=(0.2 * k, 0, 0), axis="y"))
        joints[-1].add_motor(1.0, cap=1.0, delta=0.01)
    looks: list[Any] = []
    coordinates = Actuator.coordinates.fget
    monkeypatch.setattr(Actuator, "coordinates", property(lambda a: looks.append(a) or coordinates(a)))
    joints[0].add_friction(0.1)
    assert [a.kind for a in joints[0].actuators] == ["velocity_motor", "joint_friction"]
    assert len(looks) <= 3


def test_actuators_of_a_joint_when_others_were_taken_back() -> None:
    scene = stark.Scene()
    bars = [scene.add_box((0.1, 0.02, 0.02), mass=0.1, position=(0.3 * k, 0, 0)) for k in range(3)]
    at = {"anchor": (0.0, 0.0, 0.0)}
    first = scene.add_hinge(None, bars[0], axis="y", **at, limits=(-1.0, 1.0))
    assert len(first.actuators) == 1
    with pytest.raises(stark.InvalidArgument), scene._all_or_nothing():
        lost = scene.add_hinge(None, bars[1], axis="x", **at, limits=(-1.0, 1.0))
        assert len(lost.actuators) == 1
        scene.add_hinge(None, bars[1], axis="x", **at, limits=(1.0, 1.0))
    second = scene.add_hinge(None, bars[1], axis="z", **at)
    assert second.actuators == () and second._index == lost._index
    motor = second.add_motor(1.0, cap=1.0, delta=0.01)
    assert second.actuators == (motor,) and len(first.actuators) == 1
    geared = scene.add_hinge(None, bars[2], axis="x", **at)
    gear = second.add_gear(geared, ratio=2.0)
    assert second.actuators == (motor, gear) and geared.actuators == (gear,)
    sim = stark.Simulation(scene)
    late = second.add_friction(0.1)
    assert [a.name for a in sim.joints[1].actuators] == [motor.name, gear.name] and late in second.actuators
