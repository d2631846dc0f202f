"""Units mean nothing: scenes in other ones, their settings among them, go the same way. A constant that has a
unit of its own shows here."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import pytest
from _worlds import SCENES, Floats, World, farthest

import stark

Scene = Callable[[World, str], list[Floats]]

UNITS = {
    "lengths": {"length": 2.0**-6},
    "masses": {"mass": 2.0**10},
    "times": {"time": 2.0**5},
    "all": {"length": 2.0**10, "mass": 2.0**10, "time": 2.0**10},  # about mm, g, ms
}


@cache
def given(scene: Scene, integrator: str) -> list[Floats]:
    return scene(World(), integrator)


@pytest.mark.filterwarnings("ignore::stark.StarkWarning")
@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_in_other_units_goes_the_same_way(scene: Scene, units: str, integrator: str) -> None:
    other = scene(World(**UNITS[units]), integrator)
    # Powers of two round nothing. Matrices have forces beside torques, so that lengths change what a pivot
    # rounds, and joints go on to residuals of 0.01 m/s^2 h^2, whatever the units.
    assert farthest(given(scene, integrator), other) < (1e-5 if "length" in UNITS[units] else 1e-12)


def test_a_small_pendulum_finds_its_equilibrium() -> None:
    """With the steps of a sequence of equilibria; one of 0.3 m does."""
    scene = stark.Scene()
    bar = scene.add_box((0.006, 0.001, 0.001), density=1000.0, position=(0.003, 0, 0))
    scene.add_hinge(None, bar, (0, 0, 0), (0, 1, 0))
    sim = stark.Simulation(scene, settings={"time.integrator": "quasistatic"})
    report = sim.step()
    assert not report.failed, report.message
    assert bar.position[2] == pytest.approx(-0.003, rel=1e-3)
