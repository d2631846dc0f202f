"""One picture of a simulation or of a frame of a recording."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._core import Canvas, InvalidArgument
from ..palette import body_colors
from ..recording.format import drawn, surface
from .camera import Bounds, Camera, auto_camera, scene_bounds

#: Samples of the key light, samples of the sky, samples per pixel and axis.
QUALITIES = {"draft": (4, 12, 1), "good": (12, 40, 2), "best": (32, 128, 3)}


def grid_spacing(radius: float) -> float:
    """Distance of the ground's lines [m]: the power of ten between 0.08 and 0.8 of the scene's radius."""
    return 10.0 ** math.floor(math.log10(0.8 * radius))


def render(
    source: Any,
    width: int = 1280,
    height: int = 720,
    *,
    camera: Camera | str | None = None,
    quality: str = "good",
    edges: bool = False,
    grid: bool = True,
    bounds: Bounds | None = None,
    threads: int = 0,
) -> np.ndarray:
    """Picture of ``source`` as a (height, width, 3) uint8 sRGB array.

    ``source`` is a simulation, a frame of a recording, or anything with ``.bodies`` that have ``positions``
    (n, 3) [m], ``triangles`` (m, 3), ``kind``, ``motion`` and ``color``. ``camera`` is a ``Camera``, the
    name of a view (oblique, front, side, top), or None for the oblique view of the whole scene. ``quality``
    is draft, good or best. ``bounds`` keeps camera and light still over the frames of a film. ``threads`` =
    0 uses all cores; the picture does not depend on it.
    """
    if quality not in QUALITIES:
        raise InvalidArgument(f"quality '{quality}' is unknown; choose one of {', '.join(QUALITIES)}")
    if not (1 <= width <= 16384 and 1 <= height <= 16384):
        raise InvalidArgument(f"size {width} x {height} px: each must be in [1, 16384]")
    bodies = drawn(source)
    for body in bodies:
        bad = np.flatnonzero(~np.isfinite(surface(body)[0]).all(axis=1))
        if len(bad):
            raise InvalidArgument(
                f"body '{body.name}': vertex {bad[0]} is not finite; only finite positions can be drawn"
            )
    if bounds is None:
        bounds = scene_bounds(source)
    if not isinstance(camera, Camera):
        camera = auto_camera(bounds, camera or "oblique", width / height)
    canvas = Canvas()
    canvas.width, canvas.height, canvas.threads = int(width), int(height), int(threads)
    canvas.key_lights, canvas.sky_lights, canvas.samples = QUALITIES[quality]
    canvas.eye, canvas.target, canvas.up = camera.eye, camera.target, camera.up
    canvas.vertical_fov = camera.vertical_fov
    canvas.scene_center, canvas.scene_radius = bounds.center, bounds.radius
    canvas.ground, canvas.ground_height = not bounds.has_floor, bounds.ground
    canvas.grid_spacing = grid_spacing(bounds.radius) if grid else 0.0
    canvas.edges = edges
    for body, color, scenery in zip(bodies, body_colors(bodies), bounds.scenery, strict=True):
        cloth = str(getattr(body.kind, "name", body.kind)).lower() == "cloth"
        positions, triangles = surface(body)
        canvas.add_mesh(
            positions.astype(np.float64),
            triangles.astype(np.int32),
            color=color,
            crease_angle=math.pi if cloth else 0.65,
            pale_back=cloth,
            fades_out=scenery,
        )
    return canvas.draw()
