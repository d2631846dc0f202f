"""Films: they need their extra, and say so."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import pytest
from fake_simulation import record

import stark
from stark.render import write_video


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
    assert not list(tmp_path.glob("*a*.*"))


@pytest.mark.parametrize("suffix", [".mov", ".mkv", ".MP4"])
def test_other_films(tmp_path: Path, suffix: str) -> None:
    pytest.importorskip("imageio_ffmpeg")
    path = write_video(record(tmp_path / "run", 2), tmp_path / f"run{suffix}", width=64, height=48)
    assert path.suffix == suffix and path.stat().st_size > 500
