"""Pictures: colours, options, bodies that cannot be drawn."""

from __future__ import annotations

import signal
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record

import stark
from stark.render import Camera, render


def test_render_shows_the_cloth_in_its_colour() -> None:
    picture = render(FakeSimulation(), 320, 200, quality="draft")
    assert picture.shape == (200, 320, 3) and picture.dtype == np.uint8
    red, green = picture[..., 0].astype(int), picture[..., 1].astype(int)
    assert 0.05 < (red > green + 40).mean() < 0.6


def test_nothing_to_draw() -> None:
    picture = render(SimpleNamespace(bodies=[]), 32, 20, quality="draft")
    assert picture.shape == (20, 32, 3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"quality": "fine"}, "quality 'fine' is unknown; choose one of draft, good, best"),
        ({"camera": "left"}, "view 'left' is unknown; choose one of oblique"),
        ({"width": 0}, r"must be in \[1, 16384\]"),
        ({"hide": "*"}, r"picture: hide = '\*' leaves none of the . bodies to draw: name at least one"),
        ({"bodies": []}, r"picture: bodies = \[\] leaves none of the . bodies to draw"),
        ({"bodies": "cloth", "hide": ["cloth"]}, r"bodies = 'cloth', hide = \['cloth'\] leaves none"),
    ],
)
def test_bad_options(options, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        render(FakeSimulation(), **{"width": 16, "height": 16, **options})


def test_vertices_that_are_not_finite_are_named() -> None:
    sim = FakeSimulation()
    sim.bodies[0].positions[5, 1] = np.nan
    with pytest.raises(ValueError, match="body 'cloth': vertex 5 is not finite"):
        render(sim, 16, 16)


def test_ctrl_c_ends_it_at_once() -> None:
    """The best picture of this size takes seconds; what the handler raises comes out of it."""
    stop = signal.signal(signal.SIGALRM, signal.default_int_handler)
    begin = time.process_time()
    try:
        with pytest.raises(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            render(FakeSimulation(), 4000, 3000, quality="best")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, stop)
    assert time.process_time() - begin < 5.0
    assert render(FakeSimulation(), 32, 20, quality="draft").shape == (20, 32, 3)


def test_still_of_a_recording(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 6)
    early, late = (run.still(t, width=80, height=60, quality="draft") for t in (0.0, 0.2))
    assert early.shape == (60, 80, 3)
    assert not np.array_equal(early, late)


@pytest.mark.parametrize("radius", [2e-5, 2e-4])
def test_hairs_are_lines_without_gaps(radius: float) -> None:
    """A hundredth or a tenth of a pixel is drawn as a pixel, in every row that the hair crosses."""
    scene = stark.Scene()
    hair = stark.RodMaterial(density=1300.0, youngs_modulus=4e9, radius=radius)
    scene.add_rod(stark.mesh.polyline((0, 0, 0.0), (0.03, 0, 0.3), 10), hair, color=(0, 0, 0))
    camera = Camera(eye=(0.0, -1.0, 0.15), target=(0.0, 0.0, 0.15), vertical_fov=0.4)
    picture = render(stark.Simulation(scene), 160, 120, quality="draft", camera=camera, grid=False)
    ends, _ = camera.project([(0.0, 0.0, 0.0), (0.03, 0.0, 0.3)], (160, 120))
    rows = picture[int(ends[1, 1]) + 2 : int(ends[0, 1]) - 2].astype(int).sum(axis=2)
    darker = rows.min(axis=1) < 0.8 * np.median(rows, axis=1)
    assert len(rows) > 60 and darker.all()


@pytest.mark.parametrize("threads", ["a", None, 1.5, -5, 10**30, float("nan")])
def test_threads_are_a_number_of_them(threads: object) -> None:
    with pytest.raises(stark.InvalidArgument, match=r"threads = .*: must be in \[0, 1024\], and whole"):
        render(FakeSimulation(), 32, 20, threads=threads)


def test_bounds_are_of_the_bodies_of_the_picture() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    alone = stark.render.scene_bounds(stark.Simulation(scene))
    scene.add_box(0.1, mass=1.0, position=(1.0, 0.0, 0.0))
    for bounds in (alone, ((0, 0, 0), (1, 1, 1)), 0):
        with pytest.raises(stark.InvalidArgument, match=r"bounds = .*scene_bounds\(...\) of the same 2 bo"):
            render(stark.Simulation(scene), 32, 20, bounds=bounds)
