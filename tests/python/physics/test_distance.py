"""Distances of bodies between steps."""

from __future__ import annotations

import numpy as np
import pytest

import stark


def test_distances_are_those_of_the_surfaces() -> None:
    scene = stark.Scene()
    scene.add_floor(1.0)
    ball = scene.add_sphere(0.1, mass=1.0, position=(0, 0, 0.5), name="ball")
    scene.add_box(0.1, mass=1.0, position=(0.4, 0, 0.5), name="box")
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 4), position=(0, 0, 0.9), name="cloth")
    sim = stark.Simulation(scene, time_step=0.01)
    assert sim.distance("ball", "floor") == pytest.approx(0.4, abs=1e-12)
    distance, on_ball, on_box = sim.closest_points(ball, "box")
    assert distance == pytest.approx(0.25, abs=1e-4)
    np.testing.assert_allclose(on_box, on_ball + np.array([distance, 0, 0]), atol=1e-3)
    turned = sim.closest_points("box", ball)
    np.testing.assert_array_equal(turned.point_a, on_box)
    assert sim.distance(cloth, ball) == pytest.approx(0.3, abs=1e-9)
    ball.position = (0.0, 0.0, 0.7)
    assert sim.distance(cloth, ball) == pytest.approx(0.1, abs=1e-9)


def test_the_gap_of_a_contact_is_its_distance() -> None:
    scene = stark.Scene()
    scene.add_floor(1.0)
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.0505), name="box")
    sim = stark.Simulation(scene, time_step=0.01)
    report = None
    for _ in range(10):
        report = sim.step()
    assert report is not None and sim.distance(box, "floor") == pytest.approx(report.min_distance, rel=1e-9)


def test_bodies_that_intersect_have_none_and_contact_may_be_off() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="a")
    scene.add_box(0.1, mass=1.0, position=(0.05, 0.03, 0.02), name="b")
    scene.add_box(0.1, mass=1.0, position=(0.5, 0.0, 0.0), name="c")
    sim = stark.Simulation(scene, **{"contact.enabled": False})
    distance, first, second = sim.closest_points("a", "b")
    assert distance == 0.0 and np.abs(first).max() <= 0.05 + 1e-12
    np.testing.assert_array_equal(first, second)
    assert sim.distance("a", "c") == pytest.approx(0.4)


def test_what_has_no_distance_is_refused() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="a")
    sim = stark.Simulation(scene)
    with pytest.raises(stark.InvalidArgument, match="'a' from itself: give two bodies"):
        sim.distance("a", "a")
    with pytest.raises(stark.InvalidArgument, match="unknown body 'b'"):
        sim.distance("a", "b")


def test_asking_changes_nothing() -> None:
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.add_box(0.1, mass=1.0, position=(0, 0, 0.06), name="box")
    hashes = []
    for asks in (False, True):
        sim = stark.Simulation(scene, time_step=0.01)
        for _ in range(10):
            if asks:
                sim.distance("box", "floor")
            sim.step()
        hashes.append(sim.state.hash)
    assert hashes[0] == hashes[1]
