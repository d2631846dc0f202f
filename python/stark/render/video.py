"""Films of recordings as mp4, through the optional package imageio with its own ffmpeg."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .._core import InvalidArgument
from ..arguments import given_path, real_number
from ..array_file import WriteError, naming, refuse_special
from ..files import resolved
from ..recording.format import RecordingError
from ..recording.reader import Recording, given_recording
from .camera import scene_bounds
from .colorbar import limits_of
from .fields import field_of
from .picture import kept_of, render

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
    camera: Any = None,
    quality: str = "draft",
    edges: bool = False,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> Path:
    """Writes an mp4 (or mov, mkv) of the whole recording: ``fps`` pictures a second, ``speed`` simulated
    seconds a second.

    ``camera`` and ``options`` are those of ``render``. Without ``limits``, colours of a ``field`` have one
    scale in the whole film. ``progress(done, total)`` is called after each picture.

    Raises ``ImportError`` naming the extra to install when imageio or its ffmpeg is missing.
    """
    given_recording(recording, "write_video")
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
    indices = [recording.nearest(float(time)) for time in times]
    if options.get("field") is not None and options.get("limits") is None:
        options["limits"] = _limits(recording, sorted(set(indices)), options)
    refuse_special(place)
    temporary = place.with_name(f".{place.stem}.part{place.suffix}")
    with naming(place):
        temporary.unlink(missing_ok=True)
        temporary.touch()
    try:
        writer: Any
        with (
            _saying_why(temporary, place),
            imageio.get_writer(temporary, fps=fps, macro_block_size=2, quality=8) as writer,
        ):
            shown, picture = -1, None
            for done, index in enumerate(indices, start=1):
                if index != shown:
                    picture = render(
                        recording.frame(index), width, height, camera=camera, quality=quality, edges=edges,
                        bounds=bounds, **options,
                    )  # fmt: skip
                    shown = index
                writer.append_data(picture)
                if progress:
                    progress(done, len(indices))
        _require_whole(temporary, place, len(indices))
        with naming(place):
            temporary.replace(place)
    finally:
        temporary.unlink(missing_ok=True)
    return place


@contextmanager
def _saying_why(temporary: Path, place: Path) -> Iterator[None]:
    """Names the film where ffmpeg has ended, which imageio tells as a broken pipe."""
    try:
        yield
    except WriteError:
        raise
    except OSError as error:
        raise _unfinished(temporary, place, "ffmpeg gave up") from error


def _require_whole(temporary: Path, place: Path, count: int) -> None:
    """Whether all pictures are there: ffmpeg writes the last of a film when it ends, and nobody looks at what
    it returns."""
    import imageio_ffmpeg

    try:
        found, _ = imageio_ffmpeg.count_frames_and_secs(str(temporary))
    except (OSError, RuntimeError):
        found = 0
    if found != count:
        raise _unfinished(temporary, place, f"ffmpeg left {found} of {count} pictures")


def _unfinished(temporary: Path, place: Path, what: str) -> Exception:
    """The error of the disk, if it takes nothing more, else ``what``."""
    try:
        with naming(place), temporary.open("ab") as file:
            file.write(bytes(1 << 16))
    except WriteError as error:
        return error
    return WriteError(f"'{place}' cannot be written: {what}; make room, or choose another place")


def _require_film(path: Path, fps: float, speed: float) -> None:
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidArgument(f"write_video: path = '{path}': must end in one of {', '.join(SUFFIXES)}")
    for name, value, meaning in (
        ("fps", fps, "pictures a second"),
        ("speed", speed, "simulated seconds a second"),
    ):
        if not real_number(value, f"write_video: {name}") > 0.0 or not math.isfinite(value):
            raise InvalidArgument(f"write_video: {name} = {value}: must be > 0 and finite, {meaning}")


def _limits(recording: Recording, frames: Sequence[int], options: Mapping[str, Any]) -> tuple[float, float]:
    """Of the colours of all frames of a film."""
    bodies = recording.frame(0).bodies
    kept = kept_of([body.name for body in bodies], options.get("bodies"), options.get("hide", ()))
    shown = {bodies[i].name for i in kept}
    ends: list[np.ndarray] = []
    for frame in frames:
        for values in field_of(recording.frame(frame), options["field"], shown).values.values():
            known = values[np.isfinite(values)]
            if len(known):
                ends.append(np.array([known.min(), known.max()], dtype=np.float64))
    return limits_of(ends)


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
