"""Cameras, and the choice of one that shows a whole scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._core import InvalidArgument
from ..arguments import shown_value
from ..recording.format import drawn, surface

#: Azimuth and elevation [rad] of the named views; the same as in the replay page.
VIEWS = {
    "oblique": (-0.9, 0.42),
    "front": (-math.pi / 2, 0.08),
    "side": (0.0, 0.08),
    "top": (-math.pi / 2, 1.5),
}
#: Where gravity does not say otherwise.
UP = (0.0, 0.0, 1.0)
#: A fixed body this many times larger than what moves is scenery: a floor, a wall.
_SCENERY = 2.5
#: Share of the picture that the box around the scene may fill.
_FILL = 0.80


@dataclass(frozen=True)
class Camera:
    """Perspective camera: ``eye`` and ``target`` [m], ``up``, full vertical field of view [rad]."""

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = UP
    vertical_fov: float = 0.61

    def axes(self) -> np.ndarray:
        """Unit vectors to the right, upwards and forwards, as rows (3, 3)."""
        forward = np.subtract(self.target, self.eye)
        forward = forward / np.linalg.norm(forward)
        for up in (self.up, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):  # another one where it looks along up
            right = np.cross(forward, up)
            if right @ right >= 1e-12:
                break
        right = right / np.linalg.norm(right)
        return np.array([right, np.cross(right, forward), forward])

    def project(self, points: Any, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """Where points (n, 3) [m] are in a picture of ``size`` (width, height): (n, 2) pixels from its upper
        left corner, whose first pixel has its middle at (0.5, 0.5); and depths (n,) [m] along the view, which
        are negative behind the camera."""
        arms = (np.asarray(points, dtype=np.float64).reshape(-1, 3) - self.eye) @ self.axes().T
        width, height = size
        scale = 0.5 * height / math.tan(0.5 * self.vertical_fov)
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = (
                0.5 * width + scale * arms[:, 0] / arms[:, 2],
                0.5 * height - scale * arms[:, 1] / arms[:, 2],
            )
        return np.stack([x, y], axis=1), arms[:, 2]

    def pixels(self, points: np.ndarray, height: int) -> np.ndarray:
        """Size [m] of a pixel at points (n, 3) [m], in a picture of ``height`` pixels; zero behind the
        camera."""
        depths = (points - self.eye) @ self.axes()[2]
        sizes: np.ndarray = np.maximum(depths, 0.0) * (2.0 * math.tan(0.5 * self.vertical_fov) / height)
        return sizes

    @classmethod
    def looking(
        cls,
        target: Sequence[float],
        distance: float,
        azimuth: float = VIEWS["oblique"][0],
        elevation: float = VIEWS["oblique"][1],
        vertical_fov: float = 0.61,
    ) -> Camera:
        """Camera at ``distance`` [m] from ``target``, seen under ``azimuth`` and ``elevation`` [rad]."""
        x, y, z = (float(c) for c in target)
        flat = distance * math.cos(elevation)
        eye = (x + flat * math.cos(azimuth), y + flat * math.sin(azimuth), z + distance * math.sin(elevation))
        return cls(eye=eye, target=(x, y, z), vertical_fov=vertical_fov)


@dataclass(frozen=True)
class Bounds:
    """Sphere around what a picture is about, the ground below it, and which bodies are mere scenery."""

    center: tuple[float, float, float]
    radius: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    ground: float
    has_floor: bool
    scenery: tuple[bool, ...]
    up: tuple[float, float, float] = UP


def _word(value: Any) -> str:
    return str(getattr(value, "name", value)).lower()


def _box(points: Any) -> tuple[np.ndarray, np.ndarray]:
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    return points.min(axis=0), points.max(axis=0)


def _size(box: tuple[np.ndarray, np.ndarray]) -> float:
    return float(np.linalg.norm(box[1] - box[0]))


def _join(boxes: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    return np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)


def _triple(values: Any) -> tuple[float, float, float]:
    return (float(values[0]), float(values[1]), float(values[2]))


def up_of(source: Any) -> tuple[float, float, float]:
    """Against gravity of a simulation, a recording or a frame of one where it is along x or y, else z."""
    recording = getattr(source, "recorded", None)
    settings = getattr(source, "settings", None) if recording is None else recording.settings
    gravity = settings.get("gravity") if isinstance(settings, dict) else getattr(settings, "gravity", None)
    pull = np.zeros(3) if gravity is None else np.asarray(gravity, dtype=np.float64)
    for axis in (0, 1):
        if pull[axis] != 0.0 and abs(pull[axis]) == np.linalg.norm(pull):
            return _triple(-np.sign(pull[axis]) * np.eye(3)[axis])
    return UP


def upright(up: tuple[float, float, float]) -> np.ndarray:
    """The rotation (3, 3) that takes ``up``, an axis of the world, to z."""
    z = np.array(up)
    x = np.array([0.0, up[0], 0.0]) if up[0] else np.array([1.0, 0.0, 0.0])
    return np.array([x, np.cross(z, x), z])


def scene_bounds(*frames: Any) -> Bounds:
    """Bounds over one or more frames (anything with ``.bodies``): all that moves, and fixed bodies unless
    much larger. Up is against gravity of the first one, where that is along an axis."""
    if not frames:
        raise InvalidArgument("scene_bounds: got no frames: must be at least one frame or simulation")
    return bounds_of([drawn(frame) for frame in frames], up_of(frames[0]))


def bounds_of(frames: Sequence[Sequence[Any]], up: tuple[float, float, float] = UP) -> Bounds:
    """``scene_bounds`` of the bodies of each frame; ``scenery`` has an entry for each body."""
    first = frames[0]
    fixed = [_word(getattr(b, "motion", "")) == "fixed" for b in first]
    filled = [i for i, b in enumerate(first) if len(surface(b)[0])]
    if not filled:
        return Bounds(
            (0.0, 0.0, 0.0),
            1.0,
            (-1.0, -1.0, 0.0),
            (1.0, 1.0, 1.0),
            0.0,
            False,
            tuple(False for _ in first),
            up,
        )
    still = {i: _box(surface(first[i])[0]) for i in filled if fixed[i]}
    moving = [_box(surface(f[i])[0]) for f in frames for i in filled if not fixed[i]]
    core = _join(moving or list(still.values()))
    scenery = {i for i, box in still.items() if moving and _size(box) >= _SCENERY * _size(core)}
    core = _join([core, *(box for i, box in still.items() if i not in scenery)])
    radius = 0.5 * _size(core) or 1.0
    bottom = min(point @ np.array(up) for point in core)
    tops = [max(point @ np.array(up) for point in still[i]) for i in scenery]
    floors = [top for top in tops if top <= bottom + 0.1 * radius]
    ground = float(max(floors)) if floors else float(bottom) - 1e-3 * radius
    return Bounds(
        center=_triple(0.5 * (core[0] + core[1])),
        radius=float(radius),
        low=_triple(core[0]),
        high=_triple(core[1]),
        ground=ground,
        has_floor=bool(floors),
        scenery=tuple(i in scenery for i in range(len(first))),
        up=up,
    )


def auto_camera(
    bounds: Bounds,
    view: str = "oblique",
    aspect: float = 16.0 / 9.0,
    vertical_fov: float = Camera.vertical_fov,
) -> Camera:
    """A camera that shows the whole box of ``bounds`` from a named view: oblique, front, side, top."""
    if not isinstance(bounds, Bounds):
        raise InvalidArgument(f"bounds = {shown_value(bounds)}: must be those of scene_bounds(sim)")
    if not isinstance(view, str) or view not in VIEWS:
        raise InvalidArgument(f"view {shown_value(view)} is unknown; choose one of {', '.join(VIEWS)}")
    azimuth, elevation = VIEWS[view]
    fov = vertical_fov
    back = np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        ]
    )
    right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    back, right = back @ upright(bounds.up), right @ upright(bounds.up)
    up = np.cross(back, right)
    half_height = _FILL * math.tan(0.5 * fov)
    box = np.array([bounds.low, bounds.high])
    corners = np.array([[box[i, 0], box[j, 1], box[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    arms = corners - np.array(bounds.center)
    wide = np.maximum(np.abs(arms @ right) / (half_height * aspect), np.abs(arms @ up) / half_height)
    distance = max(float(np.max(wide + arms @ back)), 0.1 * bounds.radius)
    if bounds.up == UP:
        return Camera.looking(bounds.center, distance, azimuth, elevation, fov)
    eye = np.array(bounds.center) + distance * back
    return Camera(eye=_triple(eye), target=bounds.center, up=bounds.up, vertical_fov=fov)
