"""Cameras: the automatic one shows the whole scene, others are used as they are."""

from __future__ import annotations

import numpy as np
import pytest
from fake_simulation import FakeSimulation, box

import stark
from stark.render import Camera, auto_camera, render, scene_bounds


@pytest.mark.parametrize("view", ["oblique", "front", "side", "top"])
@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_automatic_camera_shows_the_whole_scene(view: str, aspect: float) -> None:
    """Projects all vertices that matter with an independent pinhole model."""
    sim = FakeSimulation()
    camera = auto_camera(scene_bounds(sim), view, aspect)
    eye, target = np.array(camera.eye), np.array(camera.target)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    points = np.concatenate([sim.bodies[0].positions, sim.bodies[1].positions]) - eye
    half = np.tan(0.5 * camera.vertical_fov)
    x, y = points @ right / (points @ forward) / (half * aspect), points @ up / (points @ forward) / half
    largest = max(np.abs(x).max(), np.abs(y).max())
    assert 0.4 < largest < 0.9  # inside, and not lost in the middle


def test_large_fixed_bodies_are_scenery() -> None:
    sim = FakeSimulation()
    bounds = scene_bounds(sim)
    assert bounds.scenery == (False, False, True)
    assert bounds.radius < 0.5
    assert bounds.ground == pytest.approx(-0.3)  # the top of the floor
    sim.bodies[2].positions = box((0.1, 0.1, 0.1))[0]
    assert scene_bounds(sim).scenery == (False, False, False)


def test_own_camera_is_used() -> None:
    sim = FakeSimulation()
    away = Camera(eye=(0.0, 0.0, 5.0), target=(0.0, 0.0, 10.0), up=(0.0, 1.0, 0.0))
    picture = render(sim, 64, 64, camera=away, quality="draft").astype(int)
    assert (picture[..., 0] - picture[..., 1]).max() < 20  # looks at the sky


@pytest.mark.parametrize("up", [(0, 1, 0), (0, -1, 0), (1, 0, 0), (-1, 0, 0)])
@pytest.mark.parametrize("with_floor", [True, False])
def test_a_scene_stands_upright_whatever_gravity_is(up: tuple[int, int, int], with_floor: bool) -> None:
    """The picture is that of the scene which is turned to z up: on its own ground, on a floor, by a camera
    at a place. The turn is written here again, column by column."""
    sideways = (1, 0, 0) if up[0] == 0 else (0, up[0], 0)
    turn = np.column_stack([sideways, np.cross(up, sideways), up])  # from z up to this one
    pictures = []
    for rotation in (np.eye(3), turn):
        scene = stark.Scene()
        if with_floor:
            scene.add_floor(5.0, rotation=rotation)
        scene.add_box((0.1, 0.2, 0.3), mass=1.0, position=rotation @ (0.1, 0.0, 0.2), rotation=rotation)
        scene.add_sphere(0.05, mass=1.0, position=rotation @ (-0.1, 0.1, 0.1), rotation=rotation)
        sim = stark.Simulation(scene, gravity=rotation @ (0.0, 0.0, -9.81))
        place = tuple(rotation @ (0.5, -0.6, 0.4))
        pictures += [
            sim.picture(size=(160, 90), quality="draft", camera=c) for c in ("oblique", "side", place)
        ]
    for expected, picture in zip(pictures[:3], pictures[3:], strict=True):
        off = np.abs(expected.astype(int) - picture.astype(int)).max(axis=2)
        assert (off > 8).mean() < 0.01  # samples that rounding gives to another side of an edge
        assert expected.std() > 10  # there is something to see


def test_up_is_z_without_gravity_and_where_it_is_oblique() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    for gravity in ((0, 0, 0), (0, 0, -9.81), (0, 0, 9.81), (1, 0, -9.81)):
        assert scene_bounds(stark.Simulation(scene, gravity=gravity)).up == (0.0, 0.0, 1.0)
