"""Films: they need their extra, and say so."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import record

import stark
from stark import cli
from stark.recording import Recorder, Recording
from stark.render import render, write_video


def test_films_name_the_extra_when_packages_are_missing(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ImportError, match=r"pip install 'stark-sim\[video\]'"):
        write_video(record(tmp_path / "run", 2), tmp_path / "run.mp4")
    assert not (tmp_path / "run.mp4").exists()


@pytest.mark.skipif(importlib.util.find_spec("imageio_ffmpeg") is None, reason="needs the extra 'video'")
def test_film(tmp_path: Path) -> None:
    import imageio.v2 as imageio

    path = write_video(record(tmp_path / "run", 15), tmp_path / "run.mp4", width=160, height=90, fps=20.0)
    frames = imageio.mimread(path, memtest=False)
    assert len(frames) == 11
    assert frames[0].shape == (90, 160, 3)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.mp4", {"speed": 0.0}, "speed = 0.0: must be > 0 and finite, simulated seconds"),
        ("a.mp4", {"speed": -1}, "speed = -1: must be > 0"),
        ("a.mp4", {"speed": float("nan")}, "speed = nan: must be > 0"),
        ("a.mp4", {"speed": float("inf")}, "speed = inf: must be > 0"),
        ("a.mp4", {"speed": "1"}, "speed = '1': must be a number"),
        ("a.mp4", {"fps": 0.0}, "fps = 0.0: must be > 0"),
        ("a.mp4", {"speed": 1e-12}, "make more than 1000000 pictures of .*: must be fewer"),
        ("a.xyz", {}, r"must end in one of \.mp4, \.mov, \.mkv"),
        ("a", {}, "must end in one of"),
        ("a.mp4", {"width": 1}, "width = 1: must be an integer >= 2"),
        ("a.mp4", {"height": 90.5}, "height = 90.5: must be an integer >= 2"),
    ],
)
def test_what_makes_no_film_is_refused(
    tmp_path: Path, name: str, options: dict[str, Any], message: str
) -> None:
    pytest.importorskip("imageio_ffmpeg")
    run = record(tmp_path / "run", 2)
    with pytest.raises(stark.InvalidArgument, match=message):
        write_video(run, tmp_path / name, **options)
    with pytest.raises(
        stark.Error, match=r"write_video: recording = .*must be a stark\.recording\.Recording"
    ):
        write_video(tmp_path / "run", tmp_path / "a.mp4")  # type: ignore[arg-type]
    assert not list(tmp_path.glob("*a*.*"))


@pytest.mark.parametrize("suffix", [".mov", ".mkv", ".MP4"])
def test_other_films(tmp_path: Path, suffix: str) -> None:
    pytest.importorskip("imageio_ffmpeg")
    path = write_video(record(tmp_path / "run", 2), tmp_path / f"run{suffix}", width=64, height=48)
    assert path.suffix == suffix and path.stat().st_size > 500


FULL_DISK = """
import resource, sys
from stark.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, resource.RLIM_INFINITY))
sys.exit(main(sys.argv[1:]))
"""


def test_films_that_were_not_written_whole_are_refused(tmp_path: Path) -> None:
    """ffmpeg ends without its last part where a disk is full, and nobody looked: no player opens such films,
    which have no index."""
    pytest.importorskip("imageio_ffmpeg")
    record(tmp_path / "run", 2)
    film = tmp_path / "film.mp4"
    command = ["video", str(tmp_path / "run"), "--out", str(film), "--size", "64x48"]
    ended = subprocess.run([sys.executable, "-c", FULL_DISK, *command], capture_output=True, text=True)
    assert ended.returncode == 1
    assert ended.stderr.splitlines()[-1].startswith(f"stark: '{film}' cannot be written: ")
    assert not list(tmp_path.glob("*film*"))


def test_films_in_folders_that_take_no_files_are_refused(tmp_path: Path) -> None:
    """ffmpeg said so in pages of its own."""
    pytest.importorskip("imageio_ffmpeg")
    film = tmp_path / "none" / "film.mp4"
    with pytest.raises(stark.Error, match=r"none/film\.mp4' cannot be written: No such file or directory"):
        write_video(record(tmp_path / "run", 2), film, width=64, height=48)


def timed(folder: Path) -> Recording:
    """Two bodies, whose field is the time: 0 to 0.05 s, and 1 s more."""
    scene = stark.Scene()
    scene.add_sphere(0.1, mass=1.0, name="ball", subdivisions=1)
    scene.add_box(0.1, mass=1.0, name="box", position=(0.5, 0, 0))
    sim = stark.Simulation(scene, time_step=0.01)

    def ages(sim: Any) -> dict[str, Any]:
        return {b.name: sim.time + k + np.zeros(len(b.mesh.vertices)) for k, b in enumerate(scene.bodies)}

    with Recorder(folder, sim, arrays={"age [s]": ages}) as recorder:
        recorder.record(sim)
        for _ in range(5):
            sim.step()
            recorder.record(sim)
    return Recording(folder)


@pytest.mark.parametrize(
    ("options", "limits"),
    [
        ({}, (0.0, 1.05)),
        ({"hide": "box"}, (0.0, 0.05)),
        ({"bodies": "box"}, (1.0, 1.05)),
        ({"limits": (-1.0, 2.0)}, (-1.0, 2.0)),
    ],
)
def test_colours_have_one_scale_in_a_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: dict[str, Any], limits: tuple[float, float]
) -> None:
    pytest.importorskip("imageio_ffmpeg")
    run, drawn = timed(tmp_path / "run"), []

    def spy(frame: Any, *size: int, **given: Any) -> Any:
        drawn.append(given)
        return render(frame, *size, **given)

    monkeypatch.setattr(stark.render.video, "render", spy)
    write_video(run, tmp_path / "a.mp4", width=64, height=48, field="age [s]", fps=100.0, **options)
    assert len(drawn) == 6
    assert all(given["limits"] == pytest.approx(limits, abs=1e-7) for given in drawn)


def test_cameras_of_films_are_those_of_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("imageio_ffmpeg")
    run, drawn = timed(tmp_path / "run"), []
    view = {"camera": (0.2, -1.0, 0.3), "target": "ball", "field_of_view": 0.4}

    def spy(frame: Any, *size: int, **given: Any) -> Any:
        drawn.append(render(frame, *size, **given))
        return drawn[-1]

    monkeypatch.setattr(stark.render.video, "render", spy)
    write_video(run, tmp_path / "a.mp4", width=64, height=48, fps=100.0, grid=False, **view)
    for k, picture in enumerate(drawn):
        # The light of a film stands still, so compare where bodies are, not how bright.
        still = render(run.frame(k), 64, 48, quality="draft", grid=False, **view)
        assert np.mean((picture != picture[0, 0]).any(axis=2) != (still != still[0, 0]).any(axis=2)) < 0.02
    words = ["--camera=0.2,-1,0.3", "--target", "ball", "--fov", "30", "--field", "age [s]", "--hide", "box"]
    words += ["--size", "64x48", "--out", str(tmp_path / "b.mp4")]
    assert cli.main(["video", str(tmp_path / "run"), *words]) == 0
    assert (tmp_path / "b.mp4").stat().st_size > 500
