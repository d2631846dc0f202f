"""Films of recordings as mp4, through the optional package imageio with its own ffmpeg."""

from __future__ import annotations

import math
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .._core import InvalidArgument
from ..arguments import given_path, real_number
from ..array_file import naming, refuse_special
from ..files import resolved
from ..recording.format import RecordingError
from ..recording.reader import Recording
from .camera import Camera, auto_camera, scene_bounds
from .picture import render

_MISSING = "films need the packages of the extra 'video': pip install 'stark-sim[video]'"


#: Files that H.264 can be written to.
SUFFIXES = (".mp4", ".mov", ".mkv")

#: Most pictures of a film.
MOST_PICTURES = 1_000_000


def write_video(
    recording: Recording,
    path: str | PathLike[str],
    *,
    width: int = 1280,
    height: int = 720,
    fps: float = 30.0,
    speed: float = 1.0,
    camera: Camera | str | None = None,
    quality: str = "draft",
    edges: bool = False,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> Path:
    """Writes an mp4 (or mov, mkv) of the whole recording: ``fps`` pictures a second, ``speed`` simulated
    seconds a second.

    Raises ``ImportError`` naming the extra to install when imageio or its ffmpeg is missing.
    ``progress(done, total)`` is called after each picture. ``options`` go to ``render``.
    """
    place = resolved(given_path(path, "write_video: path"))
    _require_film(place, fps, speed)
    try:
        import imageio.v2 as imageio
        import imageio_ffmpeg  # noqa: F401
    except ImportError as error:
        raise ImportError(_MISSING) from error
    if not len(recording):
        raise RecordingError(f"'{recording.folder}' has no frames; there is nothing to film")
    times = _times(recording, fps, speed)
    width, height = _even(width, "width"), _even(height, "height")
    sampled = [recording.frame(i) for i in np.linspace(0, len(recording) - 1, 9).astype(int)]
    bounds = scene_bounds(*sampled)
    if not isinstance(camera, Camera):
        camera = auto_camera(bounds, camera or "oblique", width / height)
    refuse_special(place)
    temporary = place.with_name(f".{place.stem}.part{place.suffix}")
    temporary.unlink(missing_ok=True)
    try:
        writer: Any
        with imageio.get_writer(temporary, fps=fps, macro_block_size=2, quality=8) as writer:
            shown, picture = -1, None
            for done, time in enumerate(times, start=1):
                index = recording.nearest(float(time))
                if index != shown:
                    picture = render(
                        recording.frame(index), width, height, camera=camera, quality=quality, edges=edges,
                        bounds=bounds, **options,
                    )  # fmt: skip
                    shown = index
                writer.append_data(picture)
                if progress:
                    progress(done, len(times))
        with naming(place):
            temporary.replace(place)
    finally:
        temporary.unlink(missing_ok=True)
    return place


def _require_film(path: Path, fps: float, speed: float) -> None:
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidArgument(f"write_video: path = '{path}': must end in one of {', '.join(SUFFIXES)}")
    for name, value, meaning in (
        ("fps", fps, "pictures a second"),
        ("speed", speed, "simulated seconds a second"),
    ):
        if not real_number(value, f"write_video: {name}") > 0.0 or not math.isfinite(value):
            raise InvalidArgument(f"write_video: {name} = {value}: must be > 0 and finite, {meaning}")


def _times(recording: Recording, fps: float, speed: float) -> np.ndarray:
    """Of the pictures [s]."""
    first, last, step = float(recording.times[0]), float(recording.times[-1]), speed / fps
    if not (last - first) <= MOST_PICTURES * step:
        raise InvalidArgument(
            f"write_video: fps = {fps:g} and speed = {speed:g} make more than {MOST_PICTURES} pictures of "
            f"{last - first:g} s: must be fewer; raise speed"
        )
    return np.arange(first, last + 0.5 * step, step)


def _even(pixels: int, name: str) -> int:
    """H.264 halves the colour resolution."""
    if not isinstance(pixels, (int, np.integer)) or pixels < 2:
        raise InvalidArgument(f"write_video: {name} = {pixels!r}: must be an integer >= 2, in pixels")
    return int(pixels - pixels % 2)
