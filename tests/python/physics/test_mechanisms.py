"""Rigid mechanisms against references of high accuracy: docs/validation.md has the numbers.

Implicit Euler is of first order and loses energy, so a motion is run with several time steps; the order is
looked at, and the extrapolation to time step zero is compared."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _mechanisms import (
    BDF2,
    TIGHT,
    Floats,
    Work,
    at,
    bar,
    crossings,
    extrapolate,
    observed_order,
    record,
    simulate,
    tip,
)
from _squeezer import squeezer
from _validation import validate

import stark

G = 9.81  # [m/s^2]
Z = (0, 0, 1)


def top(time_step: float, until: float, **settings: Any) -> tuple[Floats, Floats]:
    """Free block 0.10 x 0.06 x 0.02 m turning about its middle axis: angular velocity about that axis, in the
    body, and the angular momentum in the world over that at time 0."""
    scene = stark.Scene()
    body = scene.add_box((0.10, 0.06, 0.02), density=800.0, angular_velocity=(0.1, 10.0, 0.0))
    sim = simulate(scene, time_step, gravity=(0, 0, 0), **TIGHT, **settings)
    before = np.linalg.norm(body.inertia @ (0.1, 10.0, 0.0))

    def observe() -> Floats:
        spin = body.rotation.T @ body.angular_velocity
        return np.concatenate([spin[1:2], body.rotation @ body.inertia @ spin / before])

    return record(sim, until, observe)


def test_free_top_turns_over_when_it_should() -> None:
    runs = [top(h, 1.2) for h in (1e-3, 5e-4, 2.5e-4)]
    flips = [crossings((t, values[:, 0]))[:1] for t, values in runs]
    momenta = [np.linalg.norm(at(run, 0.9)[0, 1:]) for run in runs]
    validate("V14.flip", extrapolate(*flips))
    validate("V14.momentum", extrapolate(*momenta))
    validate("V14.step", [flips[0][0], flips[2][0] - flips[0][0]])


def test_free_top_with_bdf2() -> None:
    runs = [top(h, 1.2, **BDF2) for h in (1e-3, 5e-4, 2.5e-4)]
    flips = [crossings((t, values[:, 0]))[:1] for t, values in runs]
    momenta = [np.linalg.norm(at(run, 0.9)[0, 1:]) for run in runs]
    validate("V14.bdf2_flip", extrapolate(*flips, order=2))
    validate("V14.bdf2_momentum", extrapolate(*momenta, order=2))
    validate("V14.bdf2_step", [flips[0][0], flips[2][0] - flips[0][0]])


@pytest.mark.slow
def test_free_top_turns_over_three_times_with_bdf2() -> None:
    times, values = top(5e-4, 5.0, **BDF2)
    validate("V14.bdf2_flips", crossings((times, values[:, 0])))
    validate("V14.bdf2_momentum_5s", np.linalg.norm(values[-1, 1:]))


def pendulum(time_step: float, until: float, degrees: float) -> tuple[Floats, Floats]:
    """Point mass at 1 m on a hinge, released from an angle: its angle from the vertical [rad]."""
    scene = stark.Scene()
    start = np.radians(degrees)
    # An inertia of 1e-6 kg m^2 about its own centre lengthens the period by 5e-7 of it.
    bob = scene.add_box(
        0.01,
        inertia=(1.0, (0.0, 0.0, 0.0), 1e-6 * np.eye(3)),
        position=(np.sin(start), -np.cos(start), 0.0),
    )
    hinge = scene.add_hinge(None, bob, anchor=(0, 0, 0), axis=Z)
    sim = simulate(scene, time_step, gravity=(0, -G, 0), **TIGHT)
    return record(sim, until, lambda: start + (hinge.angle if sim.time else 0.0))


@pytest.mark.parametrize("degrees", [30, 90, 150])
def test_period_of_a_pendulum(degrees: int) -> None:
    """Four times the time from rest to the lowest point: later quarters have lost amplitude."""
    quarters = [crossings(pendulum(h, 1.0, degrees))[:1] for h in (4e-3, 2e-3, 1e-3)]
    validate(f"V15.period_{degrees}", 4.0 * extrapolate(*quarters))
    validate(f"V15.order_{degrees}", observed_order(*quarters))


def double_pendulum(time_step: float, until: float) -> tuple[Floats, Floats]:
    """Two bars of 1 m and 1 kg released from the horizontal: position of the tip [m]."""
    scene = stark.Scene()
    first, second = bar(scene, (0, 0, 0), (1, 0, 0)), bar(scene, (1, 0, 0), (2, 0, 0))
    scene.add_hinge(None, first, anchor=(0, 0, 0), axis=Z)
    scene.add_hinge(first, second, anchor=(1, 0, 0), axis=Z)
    sim = simulate(scene, time_step, gravity=(0, -G, 0), **TIGHT)
    return record(sim, until, lambda: tip(second, (0.5, 0, 0))[:2])


def test_double_pendulum() -> None:
    runs = [double_pendulum(h, 1.0) for h in (1e-3, 5e-4, 2.5e-4)]
    halves = [at(run, 0.5)[0] for run in runs]
    validate("V15.tip_1ms", halves[0])
    validate("V15.tip_500ms", extrapolate(*halves))
    validate("V15.tip_1000ms", extrapolate(*(at(run, 1.0)[0] for run in runs)))
    validate("V15.order_tip", observed_order(*halves))


def four_bar(
    time_step: float, until: float, work: Work, *, redundant: bool = True, **settings: Any
) -> tuple[Floats, Floats]:
    """IFToMM's two-loop four-bar mechanism: three cranks and two couplers of 1 m and 1 kg, started at 1 m/s.
    Seven hinges are 35 constraints on 30 degrees of freedom of which one is left: 6 are redundant, and one
    more where all bars are in line and the mechanism could branch. Angle of the first crank from the vertical
    [rad]."""
    scene = stark.Scene()
    cranks = [
        bar(scene, (x, 0, 0), (x, 1, 0), velocity=(0.5, 0, 0), angular_velocity=(0, 0, -1)) for x in range(3)
    ]
    couplers = [bar(scene, (x, 1, 0), (x + 1, 1, 0), velocity=(1, 0, 0)) for x in range(2)]
    supports = [scene.add_hinge(None, crank, anchor=(x, 0, 0), axis=Z) for x, crank in enumerate(cranks)]
    for x, (coupler, a, b) in enumerate(zip(couplers, cranks[:2], cranks[1:], strict=True)):
        scene.add_hinge(a, coupler, anchor=(x, 1, 0), axis=Z)
        if redundant:
            scene.add_hinge(coupler, b, anchor=(x + 1, 1, 0), axis=Z)
        else:
            scene.add_point_on_axis(coupler, b, anchor=(x + 1, 1, 0), axis=Z)
    sim = simulate(scene, time_step, gravity=(0, -G, 0), **settings)

    def observe() -> float:
        if sim.time == 0.0:
            return 0.0
        work.look_at(scene.joints)
        return supports[0].angle

    return record(sim, until, observe, work)


def on_circle(angle: float) -> Floats:
    return np.array([-np.sin(angle), np.cos(angle)])


def test_two_loop_four_bar_passes_its_singular_position() -> None:
    # In the singular position a residual of 1e-9 N is below rounding; 1e-4 N are 2e-6 of the forces.
    settings = {**TIGHT, "newton.residual_tolerance": 1e-4}
    work = Work()
    runs = [four_bar(h, 2.0, work, **settings) for h in (4e-3, 2e-3, 1e-3, 5e-4)]
    validate("V16.joint_1s", on_circle(extrapolate(*(at(run, 1.0)[0] for run in runs))))
    validate("V16.joint_2s", on_circle(extrapolate(*(at(run, 2.0)[0] for run in runs))))
    validate("V16.order", observed_order(*(at(run, 1.0) for run in runs[1:])))
    assert work.retried == 0


def test_two_loop_four_bar_with_bdf2() -> None:
    settings = {**TIGHT, "newton.residual_tolerance": 1e-4, **BDF2}
    runs = [at(four_bar(h, 1.0, Work(), **settings), 1.0)[0] for h in (4e-3, 2e-3, 1e-3)]
    validate("V16.bdf2_1s", on_circle(extrapolate(*runs, order=2)))
    validate("V16.bdf2_order", observed_order(*runs))


@pytest.mark.slow
def test_two_loop_four_bar_to_the_end_with_bdf2() -> None:
    """Ten times through the singular position."""
    work = Work()
    run = four_bar(1e-3, 10.0, work, **{**TIGHT, "newton.residual_tolerance": 1e-4, **BDF2})
    for seconds in (2, 4, 10):
        validate(f"V16.bdf2_1ms_{seconds}s", on_circle(at(run, seconds)[0]))
    assert work.retried == 0


@pytest.mark.parametrize("redundant", [True, False])
def test_two_loop_four_bar_at_default_settings(redundant: bool) -> None:
    kind = "redundant" if redundant else "minimal"
    work = Work()
    _, angles = four_bar(1e-2, 10.0, work, redundant=redundant)
    validate(f"V16.iterations_{kind}", work.mean_iterations)
    validate(f"V16.retried_{kind}", work.retried)
    assert work.worst_residual < 1e-5  # [rad], the larger of the two tolerances
    # Half a turn or more: the mechanism went through the singular position and did not stick there.
    assert np.ptp(angles) > np.pi


def test_four_bar_does_the_same_with_and_without_redundant_joints() -> None:
    ends = [four_bar(2e-3, 1.0, Work(), redundant=redundant)[1][-1] for redundant in (True, False)]
    # Joints are held within 1e-6 m; 1e-5 rad is what is left of that after 1 s.
    assert ends[0] == pytest.approx(ends[1], abs=1e-5)


def test_andrews_squeezer_for_12_ms() -> None:
    work = Work()
    ends = [squeezer(h, 0.012, work)[1][-1] for h in (2e-5, 1e-5, 5e-6)]
    validate("V17.angles_12ms", extrapolate(*ends))
    validate("V17.order", observed_order(*ends))
    validate("V17.iterations", work.mean_iterations)
    assert work.retried == 0


@pytest.mark.slow
def test_andrews_squeezer_for_30_ms() -> None:
    """To the end of the benchmark, after two and a half turns of the shaft."""
    ends = [squeezer(h, 0.03)[1][-1] for h in (1e-5, 5e-6, 2.5e-6, 1.25e-6)]
    validate("V17.angles_30ms", extrapolate(*ends))


def test_andrews_squeezer_with_bdf2() -> None:
    ends = [squeezer(h, 0.012, **BDF2)[1][-1] for h in (2e-5, 1e-5, 5e-6)]
    validate("V17.bdf2_12ms", extrapolate(*ends, order=2))
    validate("V17.bdf2_order", observed_order(*ends))


def test_andrews_squeezer_to_the_end_in_one_run_with_bdf2() -> None:
    work = Work()
    validate("V17.bdf2_10us_30ms", squeezer(1e-5, 0.03, work, **BDF2)[1][-1])
    assert work.retried == 0


@pytest.mark.slow
def test_andrews_squeezer_to_the_end_with_bdf2() -> None:
    ends = [squeezer(h, 0.03, **BDF2)[1][-1] for h in (1e-5, 5e-6, 2.5e-6)]
    validate("V17.bdf2_30ms", extrapolate(*ends, order=2))


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_reactions_of_a_slider_crank_in_short_steps(integrator: str) -> None:
    """At 0.5 ms, 1 um of a joint is 8 N of the 2 kg of the slider, which the rod has to move with 25 N; with
    bdf2 and the two hinges in line errors were up to 143 N."""
    radius, length, rate, mass, step = 0.1, 0.3, 10.0, 2.0, 5e-4
    scene = stark.Scene()
    crank = scene.add_box((radius, 0.01, 0.01), motion="scripted", position=(radius / 2, 0, 0))
    crank.follow(
        position=lambda t: (radius / 2 * np.cos(rate * t), radius / 2 * np.sin(rate * t), 0.0),
        rotation=lambda t: stark.rotation(axis="z", angle=rate * t),
    )
    rod = scene.add_box((length, 0.01, 0.01), mass=1e-4, position=(radius + length / 2, 0, 0))
    slider = scene.add_box(0.02, mass=mass, position=(radius + length, 0, 0))
    scene.add_hinge(crank, rod, anchor=(radius, 0, 0), axis=Z)
    pin = scene.add_hinge(rod, slider, anchor=(radius + length, 0, 0), axis=Z)
    scene.add_slider(None, slider, anchor=(radius + length, 0, 0), axis=(1, 0, 0))
    sim = simulate(scene, step, gravity=(0, 0, 0), **{"time.integrator": integrator})

    def place(t: float) -> float:
        height = radius * np.sin(rate * t)
        return radius * np.cos(rate * t) + np.sqrt(length**2 - height**2)

    worst = 0.0
    for report in sim.run(until=0.5):
        t, d = report.time, 1e-4
        acceleration = (place(t + d) - 2.0 * place(t) + place(t - d)) / d**2
        if t > 0.05:  # what starts at rest beside a crank that turns is pulled along first
            worst = max(worst, abs(pin.reaction.force[0] - mass * acceleration))
    # A step of jerk with implicit Euler, 0.25 N; bdf2 makes 0.2 m/s2 of the residuals of three steps.
    assert worst < (0.3 if integrator == "implicit_euler" else 0.5), worst
