"""Pictures: PNG files are what other programs read, the camera shows the scene, films need their extra."""

from __future__ import annotations

import importlib.util
import struct
import sys
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fake_simulation import FakeSimulation, box, record

from stark.render import Camera, auto_camera, read_png, render, scene_bounds, write_png, write_video


def test_png_roundtrip_and_structure(tmp_path: Path) -> None:
    picture = np.random.default_rng(1).integers(0, 256, (31, 17, 3), dtype=np.uint8)
    write_png(tmp_path / "p.png", picture)
    assert np.array_equal(read_png(tmp_path / "p.png"), picture)
    data = (tmp_path / "p.png").read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack_from(">II", data, 16) == (17, 31)
    assert data[-12:] == struct.pack(">I", 0) + b"IEND" + struct.pack(">I", zlib.crc32(b"IEND"))


def test_damaged_png(tmp_path: Path) -> None:
    write_png(tmp_path / "p.png", np.zeros((4, 4, 3), dtype=np.uint8))
    data = bytearray((tmp_path / "p.png").read_bytes())
    data[20] ^= 1
    (tmp_path / "p.png").write_bytes(bytes(data))
    with pytest.raises(ValueError, match="block IHDR is damaged"):
        read_png(tmp_path / "p.png")


@pytest.mark.parametrize("shape", [(4, 4), (4, 4, 4), (0, 4, 3)])
def test_arrays_that_are_no_pictures(tmp_path: Path, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"must be \(h, w, 3\) uint8"):
        write_png(tmp_path / "p.png", np.zeros(shape, dtype=np.uint8))
    assert not list(tmp_path.iterdir())


def test_render_shows_the_cloth_in_its_colour() -> None:
    picture = render(FakeSimulation(), 320, 200, quality="draft")
    assert picture.shape == (200, 320, 3) and picture.dtype == np.uint8
    red, green = picture[..., 0].astype(int), picture[..., 1].astype(int)
    assert 0.05 < (red > green + 40).mean() < 0.6


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


def test_nothing_to_draw() -> None:
    picture = render(SimpleNamespace(bodies=[]), 32, 20, quality="draft")
    assert picture.shape == (20, 32, 3)


def test_own_camera_is_used() -> None:
    sim = FakeSimulation()
    away = Camera(eye=(0.0, 0.0, 5.0), target=(0.0, 0.0, 10.0), up=(0.0, 1.0, 0.0))
    picture = render(sim, 64, 64, camera=away, quality="draft").astype(int)
    assert (picture[..., 0] - picture[..., 1]).max() < 20  # looks at the sky


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"quality": "fine"}, "quality 'fine' is unknown; choose one of draft, good, best"),
        ({"camera": "left"}, "view 'left' is unknown; choose one of oblique"),
        ({"width": 0}, r"must be in \[1, 16384\]"),
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


def test_still_of_a_recording(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 6)
    early, late = (run.still(t, width=80, height=60, quality="draft") for t in (0.0, 0.2))
    assert early.shape == (60, 80, 3)
    assert not np.array_equal(early, late)


def test_films_name_the_extra_when_packages_are_missing(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ImportError, match=r"pip install 'stark-sim\[video\]'"):
        write_video(record(tmp_path / "run", 2), tmp_path / "run.mp4")
    assert not (tmp_path / "run.mp4").exists()


@pytest.mark.skipif(importlib.util.find_spec("imageio_ffmpeg") is None, reason="needs the extra 'video'")
def test_film(tmp_path: Path) -> None:
    import imageio.v2 as imageio

    path = write_video(record(tmp_path / "run", 15), tmp_path / "run.mp4", width=160, height=90, fps=20.0)
    frames = list(imageio.get_reader(path))
    assert len(frames) == 11
    assert frames[0].shape == (90, 160, 3)
