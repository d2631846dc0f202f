"""Bodies that fall past the edge of a floor without size=: a warning says so, once."""

from __future__ import annotations

import warnings

import pytest

import stark


def steps(scene: stark.Scene, count: int, **options: object) -> list[str]:
    """What is said of them."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always", stark.StarkWarning)
        sim = stark.Simulation(scene, time_step=1 / 60, **options)
        for _ in range(count):
            sim.step()
    return [str(warning.message) for warning in found]


def test_a_row_of_boxes_that_is_longer_than_the_floor() -> None:
    scene = stark.Scene()
    scene.add_floor()
    for k in range(4):
        scene.add_box(0.1, mass=1.0, position=(1.0 + 0.5 * k, 0.0, 0.1), name=f"box_{k}")
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=1), position=(0.0, 2.5, 0.1), name="rag")
    assert steps(scene, 96) == [
        "'box_3' and 1 more fell past the edge of 'floor' before 0.267 s: without size= a floor is 4 m along "
        "x and y; give scene.add_floor(size) the size you need"
    ]


def test_a_ball_that_rolls_over_the_edge_and_one_that_stays() -> None:
    scene = stark.Scene()
    scene.add_floor(friction=0.5)
    scene.add_sphere(0.05, mass=1.0, position=(1.9, 0.0, 0.051), velocity=(2.0, 0.0, 0.0), name="ball")
    scene.add_sphere(0.05, mass=1.0, position=(0.0, 0.0, 0.051), name="other")
    (said,) = steps(scene, 48)
    assert said.startswith("'ball' fell past the edge of 'floor'")


@pytest.mark.parametrize("case", ["size", "scripted", "below", "weightless"])
def test_nothing_is_said_of_what_is_meant(case: str) -> None:
    scene = stark.Scene()
    scene.add_floor(**({"size": 4.0} if case == "size" else {}))
    height = -1.0 if case == "below" else 0.1
    start = {"motion": "scripted"} if case == "scripted" else {"velocity": (0.0, 0.0, -3.0)}
    box = scene.add_box(0.1, mass=1.0, position=(3.0, 0.0, height), **start)
    if case == "scripted":
        box.follow(position=lambda time: (3.0, 0.0, height - 3.0 * time))
    assert steps(scene, 32, gravity=(0, 0, 0.0 if case == "weightless" else -9.81)) == []


def test_nothing_is_said_of_what_is_below_a_slope() -> None:
    scene = stark.Scene()
    scene.add_floor(rotation=stark.rotation(axis=(1, 0, 0), angle=-0.4))
    scene.add_sphere(0.05, mass=1.0, position=(0.0, 1.0, 1.2), velocity=(0.0, 1.0, -6.0))
    assert steps(scene, 32) == []


def test_nothing_is_said_of_what_rides_down_on_a_lift() -> None:
    scene = stark.Scene()
    lift = scene.add_floor(motion="scripted")
    lift.follow(position=lambda time: (0.0, 0.0, -1.0 * time))
    scene.add_box(0.1, mass=1.0, position=(0.0, 0.0, 0.06))
    assert steps(scene, 32) == []


def test_nothing_is_said_of_what_falls_through() -> None:
    scene = stark.Scene()
    floor = scene.add_floor()
    box = scene.add_box(0.1, mass=1.0, position=(0.0, 0.0, 0.06))
    scene.disable_contact(floor, box)
    assert steps(scene, 32) == []
