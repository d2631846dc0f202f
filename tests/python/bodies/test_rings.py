"""A rod that a repeated point closes is open there, which a warning says; joined ends are left alone."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import stark


def ring(**options: object) -> tuple[stark.Scene, stark.Rod]:
    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    places = 0.1 * np.column_stack((np.cos(turn), np.sin(turn), 0.0 * turn))
    places[-1] = places[0]
    scene = stark.Scene()
    wire = stark.RodMaterial(density=1100.0, youngs_modulus=5e6, radius=0.002)
    return scene, scene.add_rod(places, wire, **{"pins": [12], "self_contact": False, **options})  # type: ignore[arg-type]


def gap(scene: stark.Scene, rod: stark.Rod) -> float:
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.2)
    return float(np.linalg.norm(rod.positions[-1] - rod.positions[0]))


def test_ends_at_the_same_place_are_not_joined() -> None:
    with pytest.warns(
        stark.StarkWarning, match="rod 'rod': its ends are at the same place, but nothing joins"
    ):
        assert gap(*ring()) > 0.01  # it hangs from the other side


def test_the_remedy_of_the_warning_closes_it() -> None:
    scene, rod = ring()
    scene.attach(rod.vertices[-1], rod.vertices[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert gap(scene, rod) < 1e-6


@pytest.mark.parametrize("held", ["pins", "carrier", "fixed"])
def test_ends_that_something_holds_are_as_meant(held: str) -> None:
    scene, rod = ring(**{"pins": [0, 24]} if held == "pins" else {})
    box = scene.add_box(0.01, motion="fixed", position=(0.2, 0.0, 0.0))
    if held == "carrier":
        scene.attach(rod.vertices[[0, 24]], box)
    if held == "fixed":
        scene.add_fixed(rod.frame(0), box)
        scene.add_ball(rod.frame(-1), box)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert gap(scene, rod) < 1e-5


def test_one_held_end_is_not_enough() -> None:
    scene, rod = ring()
    scene.attach(rod.vertices[[0]], scene.add_box(0.01, motion="fixed", position=(0.2, 0.0, 0.0)))
    with pytest.warns(stark.StarkWarning, match="nothing joins"):
        stark.Simulation(scene)
