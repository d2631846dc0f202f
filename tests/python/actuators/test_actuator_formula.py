"""``@stark.actuator``: the same as built-in actuators, memories, residuals, errors in the user's terms."""

from __future__ import annotations

import numpy as np
import pytest

import stark


@stark.actuator
def my_motor(
    c: stark.Coordinate,
    h: stark.TimeStep,
    target: float,
    cap: float = stark.parameter(unit="N m", min=0.0),
    delta: float = stark.parameter(1.0, unit="rad/s", above=0.0),
):
    """Motor of my own."""
    e = target - c.rate
    parabola, line = 0.5 * e * e, delta * (abs(e) - 0.5 * delta)
    return h * cap / delta * stark.where(abs(e) < delta, parabola, line)


def spin(add: object, steps: int = 40) -> tuple[stark.Joint, stark.Actuator, stark.Simulation]:
    scene = stark.Scene()
    wheel = scene.add_rigid(stark.mesh.box(0.1), inertia=(1.0, (0, 0, 0), 0.02 * np.eye(3)))
    hinge = scene.add_hinge(None, wheel, anchor=(0, 0, 0), axis=(0, 0, 1))
    actuator = add(hinge)  # type: ignore[operator]
    sim = stark.Simulation(
        scene, time_step=0.01, gravity=(0, 0, 0), **{"newton.acceleration_tolerance": 1e-6}
    )
    for _ in range(steps):
        assert not sim.step().failed
    return hinge, actuator, sim


def test_a_motor_of_ones_own_does_what_the_built_in_one_does() -> None:
    mine, motor, first = spin(lambda j: j.add_actuator(my_motor, target=3.0, cap=0.4))
    theirs, other, second = spin(lambda j: j.add_motor(3.0, cap=0.4, delta=1.0))
    np.testing.assert_allclose(mine.angle, theirs.angle, rtol=1e-9)
    assert first.time == second.time
    np.testing.assert_allclose(motor.torque, other.torque, rtol=1e-7)
    assert motor.parameters == {"target": 3.0, "cap": 0.4, "delta": 1.0}
    assert motor.units["cap"] == "N m"
    assert my_motor.doc == "Motor of my own." and my_motor.coordinate_count == 1
    assert "c.dq" in str(my_motor.graph())
    with pytest.raises(stark.InvalidArgument, match="delta = 0 rad/s: must be > 0"):
        motor.delta = 0.0


def test_memories_are_kept_from_step_to_step() -> None:
    @stark.actuator
    def counter(c: stark.Coordinate, steps: stark.Memory, push: float = 0.1):
        return stark.act(-push * steps * c.dq, remember={"steps": steps + 1.0})

    _, actuator, sim = spin(lambda j: j.add_actuator(counter), steps=5)
    assert actuator.effort == pytest.approx(0.1 * 4.0)
    before = sim.state.copy()
    sim.step()
    assert actuator.effort == pytest.approx(0.1 * 5.0)
    sim.state = before
    sim.step()
    assert actuator.effort == pytest.approx(0.1 * 5.0)


def test_residuals_hold_and_limit() -> None:
    @stark.actuator
    def schedule(c: stark.Coordinate, t: stark.Time, rate: float = 0.7):
        return stark.act(hold=c.q - rate * t)

    hinge, drive, sim = spin(lambda j: j.add_actuator(schedule))
    np.testing.assert_allclose(hinge.angle, 0.7 * sim.time, atol=1e-5)
    drive.rate = -0.7
    drive.enabled = False
    assert not sim.step().failed and drive.effort == 0.0

    @stark.actuator
    def ratchet(c: stark.Coordinate, furthest: stark.Memory):
        reached = stark.maximum(furthest, c.q_start)
        return stark.act(limit=reached - 0.5 - c.q, remember={"furthest": reached})

    def add(joint: stark.Joint) -> stark.Actuator:
        joint.add_actuator(ratchet)
        return joint.add_servo(2.0, stiffness=4.0, damping=0.6, cap=5.0)

    hinge, servo, sim = spin(add, steps=200)
    assert hinge.angle == pytest.approx(2.0, abs=1e-3)
    servo.target = 0.0
    for _ in range(200):
        assert not sim.step().failed
    assert hinge.angle == pytest.approx(2.0 - 0.5, abs=2e-3)


def test_an_energy_of_two_coordinates_couples_two_joints() -> None:
    @stark.actuator
    def belt(a: stark.Coordinate, b: stark.Coordinate, stiffness: float = 50.0):
        return 0.5 * stiffness * (a.q - b.q) ** 2

    scene = stark.Scene()
    hinges = []
    for x in (0.0, 1.0):
        wheel = scene.add_rigid(
            stark.mesh.box(0.1), inertia=(1.0, (0, 0, 0), 0.02 * np.eye(3)), position=(x, 0, 0)
        )
        hinges.append(scene.add_hinge(None, wheel, anchor=(x, 0, 0), axis=(0, 0, 1)))
    scene.add_actuator(belt, hinges)
    hinges[0].add_spring(1.0, damping=0.5, rest=0.4)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    for _ in range(800):
        assert not sim.step().failed
    assert hinges[1].angle == pytest.approx(0.4, abs=1e-3)


@pytest.mark.parametrize("newton", [{}, {"newton.projection": "always"}])
def test_a_differential_of_three_joints_shares_torque_evenly(newton: dict[str, str]) -> None:
    """Its shaft turns at the mean of both sides, which carry the same torque: the side with dry friction of
    0.6 N m gives it to the other, whose friction of 0.2 N m leaves 0.4 N m for a damper of 0.1 N m s, so that
    they turn at 8 and 4 rad/s, and the shaft takes 1.2 N m."""

    @stark.actuator
    def differential(shaft: stark.Coordinate, left: stark.Coordinate, right: stark.Coordinate):
        return stark.act(hold=shaft.q - 0.5 * (left.q + right.q))

    scene = stark.Scene()
    wheels = [scene.add_cylinder(0.05, 0.02, mass=1.0, position=(0.5 * k, 0, 0)) for k in range(3)]
    shaft, left, right = (scene.add_hinge(None, w, anchor=w.position, axis="z") for w in wheels)
    scene.add_actuator(differential, [shaft, left, right])
    motor = shaft.add_motor(6.0, cap=50.0, delta=1e-3)
    left.add_friction(cap=0.6)
    right.add_friction(cap=0.2, viscous=0.1)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **newton)
    sim.run_until(1.0)
    rates = [joint.rates["angle"] for joint in (shaft, left, right)]
    np.testing.assert_allclose(rates, [6.0, 8.0, 4.0], rtol=1e-4)
    assert motor.torque == pytest.approx(1.2, rel=1e-4)  # the residual of the step


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        (lambda c, m, k: None, "returns None"),
        (lambda c, m, k: k * c.q, "'m' is a stark.Memory and never changes"),
        (lambda c, m, k: stark.act(k * m, remember={"m": c.q}), "nothing depends on the motion of 'c'"),
        (lambda c, m, k: stark.act(c.q, remember={"m": m}), "nothing depends on 'k'"),
        (lambda c, m, k: stark.act(k * c.q, remember={"m": m, "n": m}), "remember 'n': no argument"),
        (lambda c, m, k: stark.act(k * c.q if c.q > 0 else m, remember={"m": m}), "stark.where"),
        (
            lambda c, m, k: stark.act(k * c.q, hold=c.q > 0, remember={"m": m}),
            "hold: got .* must be a number",
        ),
    ],
)
def test_formulas_that_are_no_actuators(formula: object, message: str) -> None:
    def bad(c: stark.Coordinate, m: stark.Memory, k: float = 1.0):
        return formula(c, m, k)  # type: ignore[operator]

    with pytest.raises(stark.TraceError, match=message):
        stark.actuator(bad)


def test_arguments_that_do_not_fit() -> None:
    with pytest.raises(stark.TraceError, match="0 arguments annotated"):

        @stark.actuator
        def none(k: float = 1.0):
            return k

    with pytest.raises(stark.TraceError, match="must not be called 'torque'"):

        @stark.actuator
        def taken(c: stark.Coordinate, torque: float = 1.0):
            return torque * c.q

    with pytest.raises(stark.TraceError, match="must be a number"):

        @stark.actuator
        def wide(c: stark.Coordinate, k: stark.Vec3):
            return k[0] * c.q
