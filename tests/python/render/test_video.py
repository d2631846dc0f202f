"""Films: they need their extra, and say so."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest
from fake_simulation import record

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
