"""Rings of rods whose welded ends touch each other brake themselves: that is said, and what helps."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import stark


def spinning_ring(segments: int, rate: float, **how: Any) -> stark.Scene:
    """A ring of 0.1 m and a thickness of 6 mm that turns about its axis, as docs/rods.md makes it."""
    turn = np.arange(segments) * 2 * np.pi / segments
    places = 0.1 * np.column_stack((np.cos(turn), np.sin(turn), 0 * turn))
    scene = stark.Scene()
    rubber = stark.RodMaterial(youngs_modulus=1e7, radius=0.003)
    ring = scene.add_rod(places, rubber, name="ring", angular_velocity=(0, 0, rate), **how)
    last, first = ring.frames[-1], ring.frames[0]
    gap = last.T @ (places[0] - places[-1])
    scene.add_fixed(
        ring.frame(-1, position=gap, rotation=last.T @ first), ring.frame(0), name="weld", contact=False
    )
    return scene


def said(scene: stark.Scene, **settings: Any) -> list[str]:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        stark.Simulation(scene, **settings)
    return [str(each.message) for each in told if "brakes the rod" in str(each.message)]


@pytest.mark.parametrize("segments", [120, 240])
def test_ends_that_rub_on_each_other_are_said(segments: int) -> None:
    (text,) = said(spinning_ring(segments, 0.0))
    assert f"joint 'weld': it holds the nodes 0 and {segments - 1} of rod 'ring'" in text
    assert "twice its contact distance, 0.006 m" in text


@pytest.mark.parametrize(
    ("segments", "how", "settings"),
    [
        (60, {}, {}),
        (240, {"self_contact": False}, {}),
        (240, {"contact_distance": 1e-3}, {}),
        (240, {}, {"contact": {"enabled": False}}),
        (240, {}, {"contact": {"self_contact": False}}),
        (240, {}, {"contact": {"friction": False}}),
    ],
)
def test_ends_that_do_not_are_not(segments: int, how: dict[str, Any], settings: dict[str, Any]) -> None:
    scene = spinning_ring(segments, 0.0, **how)
    assert said(scene, **settings) == []


def test_nodes_that_are_near_along_the_rod_are_not_said() -> None:
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.1, 0, 0), 100), stark.RodMaterial(radius=0.003))
    brace = rod.frames[0].T @ (rod.positions[3] - rod.positions[0])
    scene.add_ball(rod.frame(0, position=brace), rod.frame(3))
    assert said(scene) == []


@pytest.mark.parametrize(("segments", "how"), [(60, {}), (240, {"contact_distance": 1e-3})])
def test_a_ring_whose_ends_are_apart_keeps_its_spin(segments: int, how: dict[str, Any]) -> None:
    """With 240 segments of 2.6 mm it lost a third in 0.5 s, and from 1 rad/s it came back the other way."""
    sim = stark.Simulation(spinning_ring(segments, 50.0, **how), time_step=0.002, gravity=(0, 0, 0))
    spins = [report.angular_momentum[2] for report in sim.run(until=0.5)]
    assert spins[-1] == pytest.approx(spins[0], rel=1e-4)
