"""Values as colours in the light of the scene; transparency as blending."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from fake_simulation import box

from stark.render import Camera, scene_bounds, shading
from stark.render.colormaps import Colormap, linear
from stark.render.pieces import Piece, pieces_of
from stark.render.shading import Style, draw, grid_spacing


def scene() -> tuple[list[Piece], Style]:
    bodies = []
    for name, x, size in (("left", -0.2, 0.3), ("right", 0.2, 0.3), ("front", 0.0, 0.1)):
        positions, triangles = box((size, size, size))
        body = SimpleNamespace(name=name, kind="rigid", motion="dynamic", color=(0.2, 0.7, 0.4))
        body.positions = positions + np.array([x, 0.0 if size > 0.2 else -0.5, 0.0])
        body.triangles = triangles
        bodies.append(body)
    bounds = scene_bounds(SimpleNamespace(bodies=bodies))
    style = Style(
        size=(240, 160),
        camera=Camera(eye=(0.3, -2.0, 0.5), target=(0.0, 0.0, 0.0)),
        bounds=bounds,
        quality="good",
        edges=False,
        grid=True,
        threads=1,
        colormap=Colormap([(0.1, 0.1, 0.9), (0.9, 0.2, 0.1)]),
        limits=(0.0, 2.0),
    )
    return pieces_of(bodies, [(0.2, 0.7, 0.4)] * 3, [False] * 3, [1.0] * 3, {}, [None] * 3), style


@pytest.mark.parametrize("value", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("quality", ["draft", "good", "best"])
def test_a_constant_value_looks_like_a_body_of_that_colour(value: float, quality: str, monkeypatch) -> None:
    """The oracle is the rasteriser of the core with the colour of the value; light as it is."""
    monkeypatch.setattr(shading, "_CONTRAST", 1.0)
    pieces, style = scene()
    style = dataclasses.replace(style, quality=quality)
    color = style.colormap(value / 2.0)
    valued = [dataclasses.replace(pieces[0], values=np.full(8, value)), *pieces[1:]]
    painted = [dataclasses.replace(pieces[0], color=tuple(color)), *pieces[1:]]
    difference = np.abs(draw(valued, style).astype(int) - draw(painted, style))
    assert np.percentile(difference, 99.5) <= 3  # 8 bits, highlights
    assert difference.max() <= 20  # pixels that show an edge
    assert np.abs(draw(valued, style).astype(int) - draw(pieces, style)).max() > 100


def test_bands_do_not_show(monkeypatch) -> None:
    pieces, style = scene()
    valued = [dataclasses.replace(pieces[0], values=pieces[0].positions[:, 2]), *pieces[1:]]
    whole = draw(valued, style)
    monkeypatch.setattr(shading, "_BAND", 7 * 240 * 4)
    assert np.array_equal(draw(valued, style), whole)


def test_colours_can_be_told_in_the_shade() -> None:
    """The front of the left box is in the shade: darker than its colour, but lighter than a painted one, in
    the same tone."""
    pieces, style = scene()
    color = style.colormap(0.5)
    (x, y), *_ = style.camera.project([(-0.25, -0.15, 0.0)], style.size)[0].astype(int)
    valued = linear(draw([dataclasses.replace(pieces[0], values=np.ones(8))], style)[y, x] / 255.0)
    painted = linear(draw([dataclasses.replace(pieces[0], color=tuple(color))], style)[y, x] / 255.0)
    assert (1.05 * painted < valued).all() and (valued < 1.02 * linear(color)).all()
    assert valued / valued.sum() == pytest.approx(painted / painted.sum(), abs=0.03)


def test_values_vary_over_a_body_and_are_hidden_by_others() -> None:
    pieces, style = scene()
    left = dataclasses.replace(pieces[0], values=2.0 * (pieces[0].positions[:, 2] + 0.15) / 0.3)
    picture = draw([left, *pieces[1:]], style).astype(int)
    corners = np.array([(-0.3, -0.15, 0.12), (-0.3, -0.15, -0.12)])
    (top, bottom), _ = style.camera.project(corners, style.size)
    above, below = picture[int(top[1]), int(top[0])], picture[int(bottom[1]), int(bottom[0])]
    assert above[0] > above[2] + 60 and below[2] > below[0] + 60  # red above, blue below
    (middle,), _ = style.camera.project([(0.0, -0.55, 0.0)], style.size)
    front = picture[int(middle[1]), int(middle[0])]
    assert front[1] > max(front[0], front[2]) + 30  # green as it was


def test_a_transparent_body_is_the_mean_of_with_and_without() -> None:
    pieces, style = scene()
    part = [dataclasses.replace(pieces[0], opacity=0.3), *pieces[1:]]
    mean = 0.3 * linear(draw(pieces, style) / 255.0) + 0.7 * linear(draw(pieces[1:], style) / 255.0)
    assert linear(draw(part, style) / 255.0) == pytest.approx(mean, abs=0.01)
    gone = [dataclasses.replace(pieces[0], opacity=0.0), *pieces[1:]]
    assert np.array_equal(draw(gone, style), draw(pieces[1:], style))


def test_lines_of_the_ground_are_powers_of_ten() -> None:
    assert grid_spacing(1.0) == pytest.approx(0.1) and grid_spacing(2.0) == pytest.approx(1.0)
