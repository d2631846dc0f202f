"""What exports hold of one time: surfaces, colours, fields at vertices, poses of rigid bodies."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import is_iterable
from stark.palette import Color, body_colors
from stark.recording.format import Frame, FrameBody, drawn, surface
from stark.render.camera import UP, up_of
from stark.render.fields import FIELDS, field_values
from stark.render.pieces import at_surface

Array = NDArray[Any]

#: Fields that positions alone give, vectors at vertices, and their units.
MOTION = {"displacement": "m", "velocity": "m/s"}


class Pose(NamedTuple):
    """Of a rigid body: vertices (n, 3) in its frame are at position + rotation @ vertex."""

    position: Array
    rotation: Array


@dataclass(frozen=True)
class Shot:
    """All bodies at one time [s], with ``fields`` by name and then by body: numbers (n,) or vectors (n, 3) at
    the vertices of the drawn surface. Bodies without a field are not in it."""

    time: float
    bodies: tuple[FrameBody, ...]
    colors: tuple[Color, ...]
    fields: Mapping[str, Mapping[str, Array]]
    index: int = 0
    """Number of the frame, or of the record."""
    up: tuple[float, float, float] = UP
    """Against gravity where that is along x or y."""

    @property
    def point_data(self) -> dict[str, Array]:
        """Fields of all bodies in a row, (n,) or (n, 3) float32; NaN where a body has none."""
        merged = {}
        for name, values in self.fields.items():
            width = (3,) if name in MOTION else ()
            missing = {b.name: np.full((len(b.positions), *width), np.nan) for b in self.bodies}
            rows = [values.get(b.name, missing[b.name]) for b in self.bodies]
            merged[name] = np.concatenate(rows).astype(np.float32)
        return merged


def check_fields(names: Sequence[str], *, live: bool, recorded: Sequence[str] = ()) -> tuple[str, ...]:
    """Raises InvalidArgument for fields that are unknown, and for those that need a simulation and are not
    ``recorded``."""
    if isinstance(names, str):
        raise InvalidArgument(f"export: fields = '{names}': must be several names: ('{names}',)")
    chosen: tuple[Any, ...] = tuple(names) if is_iterable(names) else (names,)
    if not all(isinstance(name, str) for name in chosen):
        raise InvalidArgument(f"export: fields = {names!r}: must be several names, such as ('speed',)")
    for name in chosen:
        if name in recorded:
            continue
        if name in FIELDS and not live:
            raise InvalidArgument(
                f"export: field '{name}': needs a simulation; a recording has positions only: "
                f"{_words(MOTION)}, and what was recorded with them: {_words(recorded) or 'nothing'}; run it "
                f"with --fields {name}, or export with stark.exports.Exporter while the simulation runs"
            )
        if name not in FIELDS and name not in MOTION:
            raise InvalidArgument(f"export: field '{name}': must be one of {_words([*MOTION, *FIELDS])}")
    return tuple(dict.fromkeys(chosen))


class Camera:
    """Takes shots of a simulation or of frames: it knows the first one and the one before."""

    def __init__(self, fields: Sequence[str]) -> None:
        self._names = tuple(fields)
        self._first: Shot | None = None
        self._before: Shot | None = None

    def take(self, source: Any, time: float, index: int) -> Shot:
        """Of ``source`` as it is now, at a ``time`` [s]."""
        parts = drawn(source)
        colors = tuple(body_colors(parts)) if self._first is None else self._first.colors
        shot = Shot(time, tuple(map(_body, parts)), colors, {}, up=up_of(source))
        fields: dict[str, dict[str, Array]] = {}
        for name in self._names:
            moved = name in MOTION
            fields[_plain(name)] = self._moved(name, shot) if moved else _computed(source, parts, name)
        shot = replace(shot, fields=fields, index=index)
        self._first = shot if self._first is None else self._first
        self._before = shot
        return shot

    def _moved(self, name: str, shot: Shot) -> dict[str, Array]:
        """Displacements since the first shot, or mean velocities since the one before."""
        past = self._first if name == "displacement" else self._before
        if past is None:
            return {body.name: np.zeros_like(body.positions) for body in shot.bodies}
        duration = 1.0 if name == "displacement" else shot.time - past.time
        return {
            now.name: (now.positions - then.positions) / duration if duration > 0.0 else 0.0 * now.positions
            for now, then in zip(shot.bodies, past.bodies, strict=True)
        }


def frames_of(recording: Any, indices: Sequence[int], fields: Sequence[str]) -> Iterator[Shot]:
    """Shots of frames of a recording."""
    camera = Camera(fields)
    for index in indices:
        frame: Frame = recording.frame(index)
        yield camera.take(frame, frame.time, index)


def pose_between(start: Array, now: Array) -> Pose:
    """The rigid motion that takes points (n, 3) to others best, in the sense of least squares. [Kabsch 1976,
    "A solution for the best rotation to relate two sets of vectors"]"""
    a, b = np.asarray(start, dtype=np.float64), np.asarray(now, dtype=np.float64)
    middle_a, middle_b = a.mean(axis=0), b.mean(axis=0)
    u, _, vt = np.linalg.svd((a - middle_a).T @ (b - middle_b))
    sign = np.sign(np.linalg.det(u @ vt)) or 1.0
    rotation = vt.T @ np.diag([1.0, 1.0, sign]) @ u.T
    return Pose(middle_b - rotation @ middle_a, rotation)


def _computed(source: Any, parts: Sequence[Any], name: str) -> dict[str, Array]:
    """A field of the house, or one that was recorded, at the drawn vertices."""
    recording = getattr(source, "recorded", None)
    if recording is not None:
        return dict(recording.field(name, source.index))
    every = field_values(source, name)
    return {b.name: np.asarray(at_surface(b, every[b.name])) for b in parts if b.name in every}


def _body(part: Any) -> FrameBody:
    positions, triangles = surface(part)
    motion = _word(getattr(part, "motion", None) or "dynamic")
    return FrameBody(
        str(part.name), _word(part.kind), motion, positions.astype(np.float32), triangles.astype(np.int32)
    )


def _plain(name: str) -> str:
    """A name that all formats take: that of ``height [m]`` is ``height_m``."""
    return re.sub(r"\W+", "_", name).strip("_") or "field"


def _word(value: Any) -> str:
    return str(getattr(value, "name", value)).lower()


def _words(names: Any) -> str:
    return ", ".join(names)
