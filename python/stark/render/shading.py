"""Drawing pieces: the rasteriser of the core draws light and shadow of plain colours, and what it cannot do
is composed of several of its pictures. Colours of values are multiplied into the light that a grey surface
sends back; what is transparent is blended from pictures with and without it."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import _core
from .camera import Bounds, Camera, upright
from .colormaps import Colormap, linear, srgb_bytes
from .item_buffer import values_seen
from .pieces import Piece, crease_angle

#: Samples of the key light, samples of the sky, samples per pixel and axis.
QUALITIES = {"draft": (4, 12, 1), "good": (12, 40, 2), "best": (32, 128, 3)}
#: Samples that are looked at at once; bounds the memory.
_BAND = 2_000_000
#: Exponent of the light on values: below 1, so that colours can be told in the shade.
_CONTRAST = 0.6
#: Linear grey whose light, highlights included, stays below white.
_GREY = 0.6


@dataclass(frozen=True)
class Style:
    """How a picture is drawn."""

    size: tuple[int, int]  #: width, height [px]
    camera: Camera
    bounds: Bounds
    quality: str
    edges: bool
    grid: bool
    threads: int
    colormap: Colormap
    limits: tuple[float, float]


def grid_spacing(radius: float) -> float:
    """Distance of the ground's lines [m]: the power of ten between 0.08 and 0.8 of the scene's radius."""
    return 10.0 ** math.floor(math.log10(0.8 * radius))


def draw(pieces: Sequence[Piece], style: Style) -> np.ndarray:
    """The picture, (height, width, 3) uint8. With n different opacities below 1 it is the mean of n + 1
    pictures, of the bodies that are more opaque than a level that passes from 0 to 1: what is transparent
    hides what is as transparent behind it."""
    levels = sorted({0.0, 1.0, *(piece.opacity for piece in pieces)})
    if len(levels) == 2:
        return _draw_opaque([piece for piece in pieces if piece.opacity > 0.0], style)
    light = np.zeros((style.size[1], style.size[0], 3))
    for low, high in itertools.pairwise(levels):
        light += (high - low) * linear(_draw_opaque([p for p in pieces if p.opacity >= high], style) / 255.0)
    return srgb_bytes(light)


def _draw_opaque(pieces: Sequence[Piece], style: Style) -> np.ndarray:
    if all(piece.values is None for piece in pieces):
        return _rasterised(pieces, style)
    grey = float(srgb_bytes(_GREY)) / 255.0
    lit, dark = (
        linear(_rasterised([_painted(piece, (shade,) * 3) for piece in pieces], style) / 255.0)
        for shade in (grey, 0.0)
    )
    colors, share = _colors_seen(pieces, style)
    # The core shows t(albedo * light + highlight). Where values are black it leaves all the rest.
    part = np.maximum(lit - dark, 0.0) / share[..., None]
    received = _untoned(part) / float(linear(grey))
    return srgb_bytes(dark + share[..., None] * _toned(linear(colors) * received**_CONTRAST))


def _painted(piece: Piece, color: tuple[float, ...]) -> Piece:
    if piece.values is None:
        return piece
    red, green, blue = color
    return dataclasses.replace(piece, color=(red, green, blue))


def _colors_seen(pieces: Sequence[Piece], style: Style) -> tuple[np.ndarray, np.ndarray]:
    """Colour of the values in each pixel (height, width, 3), sRGB, and the share of the pixel that they take
    (height, width). Around them the colour is that of the next pixel and the share 1, for samples that
    rounding gives to another triangle than in the core."""
    samples = QUALITIES[style.quality][2]
    width, height = style.size
    rows = [np.column_stack([p.positions, p.values]) for p in pieces if p.values is not None]
    starts = np.cumsum([0, *map(len, rows)])
    faces = [p.triangles for p in pieces if p.values is not None]
    triangles = np.concatenate([f + start for f, start in zip(faces, starts, strict=False)])
    data, near, fine = np.concatenate(rows), 1e-3 * style.bounds.radius, (samples * width, samples * height)
    total, count = np.zeros((height, width, 3)), np.zeros((height, width), dtype=np.int64)
    band = max(1, _BAND // (fine[0] * samples))  # rows of pixels at once
    for top in range(0, height, band):
        end = min(top + band, height)
        values = values_seen(data, triangles, style.camera, fine, near, (samples * top, samples * end))
        seen, (low, high) = np.isfinite(values), style.limits
        colors = style.colormap(np.where(seen, (values - low) / (high - low), 0.0)) * seen[..., None]
        blocks = (end - top, samples, width, samples)
        total[top:end] = colors.reshape(*blocks, 3).sum(axis=(1, 3))
        count[top:end] = seen.reshape(blocks).sum(axis=(1, 3))
    share = np.where(count > 0, count / samples**2, 1.0)
    total, count = _spread(total, count)
    return total / np.maximum(count, 1)[..., None], share


def _spread(total: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Empty pixels get the mean of their neighbours."""
    wide, wide_count = np.pad(total, ((1, 1), (1, 1), (0, 0))), np.pad(count, 1)
    height, width = count.shape
    windows = [(slice(i, i + height), slice(j, j + width)) for i in range(3) for j in range(3)]
    around, number = sum(wide[w] for w in windows), sum(wide_count[w] for w in windows)
    empty = count == 0
    return np.where(empty[..., None], around, total), np.where(empty, number, count)


def _toned(light: np.ndarray) -> np.ndarray:
    """Tone curve of io/raster.cpp."""
    return 1.18 * light / (1.0 + 0.22 * light)


def _untoned(shown: np.ndarray) -> np.ndarray:
    return shown / (1.18 - 0.22 * shown)


def _rasterised(pieces: Sequence[Piece], style: Style) -> np.ndarray:
    camera, bounds = style.camera, style.bounds
    turn = upright(bounds.up).T  # the core has z up
    eye, target, up, center = (
        np.array([camera.eye, camera.target, camera.up, bounds.center]) @ turn
    ).tolist()
    width, height = style.size
    key_lights, sky_lights, samples = QUALITIES[style.quality]
    settings = {
        "width": width,
        "height": height,
        "samples": samples,
        "key_lights": key_lights,
        "sky_lights": sky_lights,
        "scene_center": center,
        "scene_radius": bounds.radius,
        "ground": not bounds.has_floor,
        "ground_height": bounds.ground,
        "grid_spacing": grid_spacing(bounds.radius) if style.grid else 0.0,
        "edges": style.edges,
        "threads": style.threads,
    }
    meshes = [
        {
            "positions": piece.positions @ turn,
            "triangles": piece.triangles,
            "color": piece.color,
            "crease_angle": crease_angle(piece),
            "pale_back": piece.smooth and piece.values is None,
            "fades_out": piece.scenery,
            "outlined": piece.outlined,
        }
        for piece in pieces
    ]
    view = {"eye": eye, "target": target, "up": up, "vertical_fov": camera.vertical_fov}
    return np.asarray(_core.draw(meshes, view, settings))
