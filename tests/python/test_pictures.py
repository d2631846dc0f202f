"""Pictures of a simulation at once: files, cameras, bodies that are shown, errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark

SMALL = {"size": (160, 90), "quality": "draft"}


@pytest.fixture(scope="module")
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box((0.4, 0.4, 0.02), name="table", motion="fixed")
    scene.add_sphere(0.05, name="ball 1", mass=0.1, position=(-0.1, 0, 0.061), color=(0.9, 0.1, 0.1))
    scene.add_sphere(0.05, name="ball 2", mass=0.1, position=(0.1, 0, 0.061), color=(0.1, 0.1, 0.9))
    return stark.Simulation(scene, time_step=0.01)


def red(picture: np.ndarray) -> float:
    colors = picture.astype(int)
    return float((colors[..., 0] > colors[..., 2] + 80).mean())


def blue(picture: np.ndarray) -> float:
    return red(picture[..., ::-1])


def test_a_picture_is_an_array_and_a_file(sim, tmp_path: Path) -> None:
    picture = sim.picture(tmp_path / "now.png", **SMALL)
    assert picture.shape == (90, 160, 3) and picture.dtype == np.uint8
    assert np.array_equal(stark.render.read_png(tmp_path / "now.png"), picture)
    assert isinstance(picture, stark.render.Picture)
    assert np.array_equal(sim.picture(**SMALL), stark.render.render(sim, 160, 90, quality="draft"))


def test_it_shows_the_state_of_now(sim) -> None:
    before, state = sim.picture(camera="front", **SMALL), sim.state
    sim["ball 1"].position = (-0.1, 0, 0.2)
    after = sim.picture(camera="front", **SMALL)
    sim.state = state
    assert np.array_equal(sim.picture(camera="front", **SMALL), before)
    rows = [np.nonzero(p[..., 0].astype(int) > p[..., 2].astype(int) + 80)[0].mean() for p in (before, after)]
    assert rows[1] < rows[0] - 5.0


def test_bodies_that_are_shown(sim) -> None:
    whole = sim.picture(**SMALL)
    assert red(whole) > 0.005 and blue(whole) > 0.005
    assert blue(sim.picture(bodies="ball 1", **SMALL)) == 0.0
    assert blue(sim.picture(hide=[sim["ball 2"]], **SMALL)) == 0.0 < red(sim.picture(hide="ball 2", **SMALL))
    assert red(sim.picture(bodies="ball*", hide="* 1", **SMALL)) == 0.0
    assert red(sim.picture(opacity={"ball 1": 0.0}, **SMALL)) == 0.0


def test_a_clip_plane_takes_a_side_away(sim) -> None:
    picture = sim.picture(clip=((0, 0, 0), (1, 0, 0)), **SMALL)
    assert blue(picture) == 0.0 < red(picture)
    picture = sim.picture(clip=((0, 0, 0), (1, 0, 0), "ball 1"), **SMALL)
    assert blue(picture) > 0.005


def test_a_camera_follows_a_body(sim) -> None:
    picture = sim.picture(target="ball 2", **SMALL)
    assert blue(picture) > 5.0 * blue(sim.picture(**SMALL))
    picture = sim.picture(camera=(0.1, -1.0, 0.3), target=sim["ball 2"], field_of_view=0.2, **SMALL)
    assert picture[45, 80, 2] > picture[45, 80, 0] + 40  # in the middle


def test_fields_and_contacts_go_to_the_renderer(sim) -> None:
    values = {"ball 1": sim["ball 1"].positions[:, 2]}
    own = {"field": values, "limits": (0.0, 0.2), "colormap": "magma", "label": "height [m]"}
    picture = sim.picture(**own, **SMALL)
    assert np.array_equal(picture, stark.render.render(sim, 160, 90, quality="draft", **own))
    assert not np.array_equal(picture, sim.picture(**own | {"label": "h"}, **SMALL))
    assert np.array_equal(sim.picture(contacts=True, **SMALL), sim.picture(**SMALL))  # before the first step


def test_show_replays_what_was_recorded_or_is_a_picture(sim, tmp_path: Path) -> None:
    shown = sim.show(height=90)
    assert isinstance(shown, stark.render.Picture) and shown.shape == (90, 160, 3)
    with stark.recording.Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
        page = sim.show(height=300)
        assert isinstance(page, stark.replay.InlinePage) and page.height == 300
        assert "1 frames of" in repr(page)
    assert "ball 2" in sim.show().html


def test_notebooks_show_simulations(sim, tmp_path: Path) -> None:
    (tmp_path / "sim.png").write_bytes(sim._repr_png_())
    picture = stark.render.read_png(tmp_path / "sim.png")
    assert np.array_equal(picture, sim.picture(size=(640, 360), quality="draft"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": 100}, r"picture: size = 100: must be \(width, height\) in pixels"),
        ({"size": (10.5, 20)}, r"size = \(10.5, 20\): must be"),
        ({"size": (0, 20)}, r"size 0 x 20 px: each must be in \[1, 16384\]"),
        ({"path": ""}, "picture: path = '': must be a path"),
        ({"quality": "fine"}, "quality 'fine' is unknown"),
        ({"bodies": "bal"}, "bodies = 'bal': no body has such a name; "),
        ({"hide": "cup"}, "hide = 'cup': no body has such a name; there are 'table', 'ball 1', 'ball 2'"),
        ({"opacity": {"ball 1": -1}}, r"opacity of 'ball 1' = -1: must be in \[0, 1\]"),
        ({"clip": (0, 0, 1, 2)}, r"clip = \(0, 0, 1, 2\): must be \(point \[m\], normal\)"),
        ({"clip": ((0, 0, 0), "up")}, "clip: normal = 'up': must be three numbers"),
        ({"clip": ((0, 0, 0), (0, 0, 1), "cup")}, "clip: body = 'cup': no body has such a name"),
        ({"edges": "all"}, "edges = 'all': must be True or False"),
    ],
)
def test_options_that_are_wrong(sim, options, message: str) -> None:
    with pytest.raises(stark.InvalidArgument, match=message):
        sim.picture(**options)
