"""Gears and stops that are switched on in the middle of a run: they take what they find, or are refused."""

from __future__ import annotations

import pytest

import stark


def two_wheels() -> tuple[stark.Simulation, stark.Joint, stark.Joint, stark.Actuator]:
    scene = stark.Scene()
    wheels = [
        scene.add_cylinder(0.05, 0.02, mass=1.0, position=(x, 0, 0), angular_velocity=(0, 0, spin))
        for x, spin in ((0.0, 5.0), (0.3, 0.0))
    ]
    shaft, wheel = (scene.add_hinge(None, body, body.position, "z") for body in wheels)
    gear = wheel.add_gear(shaft, ratio=-1.0, name="clutch")
    sim = stark.Simulation(scene, time_step=0.005, gravity=(0, 0, 0))
    gear.enabled = False
    sim.run_until(0.5)
    return sim, shaft, wheel, gear


def test_a_gear_out_of_phase_is_refused() -> None:
    sim, shaft, wheel, gear = two_wheels()
    before = sim.state
    with pytest.raises(
        stark.InvalidArgument, match=r"actuator 'clutch' is off by 2\.5 rad now: must be held"
    ):
        gear.enabled = True
    assert not gear.enabled and sim.state == before
    assert sim.step().energy["kinetic"] == pytest.approx(0.5 * 0.5 * 0.05**2 * 25, rel=0.01)
    with sim.placing():
        wheel.angle = -shaft.angle
        gear.enabled = True
    assert gear.enabled and not sim.step().failed


def test_a_clutch_that_takes_the_angles_it_finds_shares_the_spin() -> None:
    """Opposite wheels of the same inertia come to half of the rate: half of the energy is lost."""
    sim, shaft, wheel, gear = two_wheels()
    gear.offset = wheel.angle + shaft.angle
    gear.enabled = True
    report = sim.step()
    assert not report.failed, report.message
    sim.run_until(1.0)
    assert shaft.rates["angle"] == pytest.approx(2.5, rel=1e-3)
    assert wheel.rates["angle"] == pytest.approx(-2.5, rel=1e-3)


def test_a_stop_that_is_passed_is_refused() -> None:
    scene = stark.Scene()
    body = scene.add_cylinder(0.05, 0.02, mass=1.0, angular_velocity=(0, 0, 5))
    hinge = scene.add_hinge(None, body, (0, 0, 0), "z")
    stop = hinge.add_limit(-1.0, 1.0, name="stop")
    sim = stark.Simulation(scene, time_step=0.005, gravity=(0, 0, 0))
    stop.enabled = False
    sim.run_until(0.1)
    stop.enabled = True  # within its range
    stop.enabled = False
    sim.run_until(0.5)
    with pytest.raises(stark.InvalidArgument, match=r"actuator 'stop' is off by 1\.5 rad now"):
        stop.enabled = True
    stop.upper = 3.0
    stop.enabled = True
    sim.run_until(1.0)
    assert hinge.angle <= 3.0 + 1e-5


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize("held", [1, 3, 20])
def test_wheels_that_a_clutch_lets_go_turn_on_as_they_turn(integrator: str, held: int) -> None:
    """With bdf2 what a gear had given in its last step went on, and wheels turned back."""
    scene = stark.Scene()
    wheels = [
        scene.add_cylinder(0.05, 0.02, mass=1.0, position=(x, 0, 0), angular_velocity=(0, 0, spin))
        for x, spin in ((0.0, 3.0), (0.3, 0.0))
    ]
    shaft, wheel = (scene.add_hinge(None, body, body.position, "z") for body in wheels)
    gear = wheel.add_gear(shaft, ratio=2.0, enabled=False)
    sim = stark.Simulation(scene, time_step=0.005, gravity=(0, 0, 0), time={"integrator": integrator})
    sim.run_until(0.1)
    gear.offset = wheel.angle - 2.0 * shaft.angle
    gear.enabled = True
    for _ in range(held):
        assert not sim.step().failed
    gear.enabled = False
    for _ in range(20):
        assert not sim.step().failed
    # Of equal wheels with a ratio of two, J (w1, w2) loses what is along (2, -1): 3 (1/5, 2/5).
    rates = [body.angular_velocity[2] for body in wheels]
    assert rates == pytest.approx([0.6, 1.2], rel=1e-3)
