"""Films of recordings as mp4, through the optional package imageio with its own ffmpeg."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import given_path
from ..array_file import naming, refuse_special
from ..files import resolved
from ..recording.format import RecordingError
from ..recording.reader import Recording
from .camera import Camera, auto_camera, scene_bounds
from .picture import render

_MISSING = "films need the packages of the extra 'video': pip install 'stark-sim[video]'"


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
    """Writes an mp4 of the whole recording: ``fps`` pictures a second, ``speed`` simulated seconds a second.

    Raises ``ImportError`` naming the extra to install when imageio or its ffmpeg is missing.
    ``progress(done, total)`` is called after each picture. ``options`` go to ``render``.
    """
    try:
        import imageio.v2 as imageio
        import imageio_ffmpeg  # noqa: F401
    except ImportError as error:
        raise ImportError(_MISSING) from error
    if not len(recording):
        raise RecordingError(f"'{recording.folder}' has no frames; there is nothing to film")
    width, height = width - width % 2, height - height % 2  # H.264 halves the colour resolution
    sampled = [recording.frame(i) for i in np.linspace(0, len(recording) - 1, 9).astype(int)]
    bounds = scene_bounds(*sampled)
    if not isinstance(camera, Camera):
        camera = auto_camera(bounds, camera or "oblique", width / height)
    times = np.arange(recording.times[0], recording.times[-1] + 0.5 * speed / fps, speed / fps)
    path = resolved(given_path(path, "write_video: path"))
    refuse_special(path)
    temporary = path.with_name(f".{path.stem}.part{path.suffix}")
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
        with naming(path):
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path
