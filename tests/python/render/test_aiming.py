"""Cameras by argument: what they look at, and where known points are in the picture."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from fake_simulation import box

from stark.render import Camera, render

SIZE = (320, 200)


def dot_at(point: tuple[float, float, float], size: float = 0.02) -> SimpleNamespace:
    """A red cube in an empty world."""
    positions, triangles = box((size, size, size))
    body = SimpleNamespace(name="dot", kind="rigid", motion="dynamic", color=(1.0, 0.0, 0.0))
    body.positions, body.triangles = positions + point, triangles
    return SimpleNamespace(bodies=[body])


def red_pixels(picture: np.ndarray) -> np.ndarray:
    """Mean place (x, y) of what is red, in pixels from the upper left corner."""
    rows, columns = np.nonzero(picture[..., 0].astype(int) > picture[..., 1].astype(int) + 60)
    return np.array([columns.mean() + 0.5, rows.mean() + 0.5])


def test_a_known_point_is_at_a_known_pixel() -> None:
    """From 2 m along y with 90 degrees of view: 0.5 m to the right and down is a quarter of half the
    height."""
    eye, target = (0.0, -2.0, 1.0), (0.0, 0.0, 1.0)
    picture = render(dot_at((0.5, 0, 0.5), 0.1), *SIZE, camera=eye, target=target, field_of_view=math.pi / 2)
    expected = (160.0 + 100.0 * 0.25, 100.0 + 100.0 * 0.25)
    assert red_pixels(picture) == pytest.approx(expected, abs=0.6)
    camera = Camera(eye=eye, target=target, vertical_fov=math.pi / 2)
    pixels, depth = camera.project([(0.5, 0.0, 0.5), (0.0, -3.0, 0.0)], SIZE)
    assert pixels[0] == pytest.approx(expected) and depth == pytest.approx([2.0, -1.0])


@pytest.mark.parametrize("up", [(0.0, 0.0, 1.0), (0.3, -0.2, 0.8)])
@pytest.mark.parametrize("eye", [(1.3, -0.7, 0.9), (-0.2, 0.1, 1.5), (0.0, 0.0, 1.6), (0.0, -1.0, -0.4)])
def test_projection_is_that_of_the_pictures(eye, up) -> None:
    camera, point = Camera(eye=eye, target=(0.0, 0.0, 0.0), up=up), (0.11, 0.06, -0.05)
    expected, _ = camera.project([point], SIZE)
    picture = render(dot_at(point), *SIZE, camera=camera, quality="draft", grid=False)
    assert red_pixels(picture) == pytest.approx(expected[0], abs=1.0)


@pytest.mark.parametrize("target", ["dot", "d*", (2.0, 1.0, 0.5)])
def test_a_target_is_in_the_middle(target) -> None:
    picture = render(dot_at((2.0, 1.0, 0.5)), *SIZE, camera=(0.0, 0.0, 1.0), target=target, quality="draft")
    assert red_pixels(picture) == pytest.approx((160.0, 100.0), abs=1.0)


def test_a_view_of_a_body_shows_it_large() -> None:
    both = SimpleNamespace(bodies=[*dot_at((0.0, 0.0, 0.0)).bodies, *dot_at((0.4, 0.3, 0.0)).bodies])
    both.bodies[1].name, both.bodies[1].color = "other", (0.0, 0.0, 1.0)
    whole, near = (render(both, *SIZE, target=target, quality="draft") for target in (None, "dot"))
    red = [
        (picture[..., 0].astype(int) > picture[..., 1].astype(int) + 60).mean() for picture in (whole, near)
    ]
    assert red[1] > 50.0 * red[0] > 0.0
    assert red_pixels(near) == pytest.approx((160.0, 100.0), abs=12.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"camera": "left"}, r"view 'left' is unknown; choose one of oblique.*or a place \(x, y, z\)"),
        ({"camera": (0, 1)}, r"camera = \(0, 1\): must be three numbers"),
        ({"camera": (0, 1, math.nan)}, "camera = .*must be finite"),
        ({"camera": (0, 0, 1), "target": (0, 0, 1)}, r"both at \(0.0, 0.0, 1.0\) m: must be apart"),
        ({"target": "cup"}, "target = 'cup': no body has such a name; there are 'dot'"),
        ({"target": "dott"}, "did you mean 'dot'"),
        ({"target": (0, 1)}, "target = .*must be three numbers"),
        (
            {"field_of_view": 35},
            r"field_of_view = 35 rad: must be in \(0, 3\]; 35 degrees are 35 \* stark.deg",
        ),
        ({"field_of_view": "wide"}, "field_of_view = 'wide': must be a number"),
    ],
)
def test_cameras_that_are_wrong(options, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        render(dot_at((0, 0, 0)), 16, 16, **options)
