"""Velocities at the start that joints do not allow: a warning names the joint and the remedy."""

from __future__ import annotations

import warnings

import pytest

import stark

SPIN = (0.0, 0.0, 1.0)


def bar(kind: str = "hinge", **options: object) -> tuple[stark.Scene, stark.RigidBody, stark.Joint]:
    """On a joint at its end."""
    scene = stark.Scene()
    body = scene.add_box((0.4, 0.04, 0.04), mass=1.0, position=(0.2, 0.0, 0.0), name="bar", **options)
    axis = {"axis": "z"} if kind == "hinge" else {}
    return scene, body, getattr(scene, f"add_{kind}")(None, body, anchor=(0.0, 0.0, 0.0), **axis)


def first_step(scene: stark.Scene, **options: object) -> stark.Simulation:
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **options)
    sim.step()
    return sim


@pytest.mark.parametrize("kind", ["hinge", "ball"])
def test_a_bar_that_spins_about_its_end_without_a_velocity_of_its_centre(kind: str) -> None:
    """It turned at a quarter of its angular velocity, without a word."""
    scene, body, _ = bar(kind, angular_velocity=SPIN)
    with pytest.warns(stark.StarkWarning, match=rf"joint '{kind}': at 0 s 'bar' moves at 0.2 m/s .* impact"):
        sim = first_step(scene)
    assert sim[body].angular_velocity[2] == pytest.approx(0.25, abs=0.01)  # m l^2/12 over m l^2/3


def test_it_is_said_of_what_is_assigned_before_the_first_step_and_of_that_alone() -> None:
    scene, body, hinge = bar()
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    body.angular_velocity = SPIN
    with pytest.warns(stark.StarkWarning, match=r"assign hinge.rates"):
        sim.step()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        body.velocity = (0.0, 1.0, 0.0)  # a push in the run
        sim.step()
    assert hinge.rates["angle"] > 1.0


def test_two_welded_bodies_of_which_one_moves() -> None:
    scene, body, _ = bar("fixed")
    other = scene.add_box(0.1, mass=1.0, position=(0.5, 0.0, 0.0), velocity=(0, 1, 0), name="other")
    scene.add_fixed(body, other, anchor=(0.45, 0.0, 0.0))
    with pytest.warns(
        stark.StarkWarning, match=r"'fixed_2': at 0 s 'other' moves at 1 m/s relative to 'bar'"
    ):
        first_step(scene)


def test_what_fits_is_silent() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene, _, _ = bar(angular_velocity=SPIN, velocity=(0.0, 0.2, 0.0))
        sim = first_step(scene)
        assert sim.joints[0].rates["angle"] == pytest.approx(1.0, abs=1e-3)
        scene, _, hinge = bar()
        sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
        hinge.rates = {"angle": 1.0}
        sim.step()
        scene, _, hinge = bar(angular_velocity=SPIN)
        sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
        hinge.enabled = False  # what is released moves as it likes
        sim.step()
