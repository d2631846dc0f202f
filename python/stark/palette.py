"""Colours of bodies in pictures and replays, sRGB in [0, 1]: a small palette that stays apart in print, then
colours as far as can be from those that are taken."""

from __future__ import annotations

import colorsys
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from stark.body_kinds import KINDS
from stark.body_kinds import Color as Color

FIXED: Color = (0.80, 0.81, 0.83)
_BY_KIND = {name: kind.colors for name, kind in KINDS.items() if kind.colors}


def body_colors(bodies: Sequence[Any]) -> list[Color]:
    """One colour a body: its own when it has one, light grey when it is fixed, else the next of its kind's
    palette that no body before has; where there is none, the one that differs most from all of them. So the
    first few hundred bodies differ, and a body keeps its colour when others are added behind it."""
    free: dict[str, list[Color]] = {}
    distances: np.ndarray | None = None  # of the candidates to the nearest colour that is taken
    colors: list[Color] = []
    taken: set[Color] = set()
    for body in bodies:
        own, motion = getattr(body, "color", None), _word(getattr(body, "motion", ""))
        if own is not None:
            red, green, blue = (float(c) for c in tuple(own)[:3])
            colors.append((red, green, blue))
        elif motion == "fixed":
            colors.append(FIXED)
        else:
            kind = _word(body.kind)
            left = free.setdefault(kind, list(_BY_KIND.get(kind, _BY_KIND["rigid"])))
            while left and left[0] in taken:
                left.pop(0)
            if left:
                colors.append(left.pop(0))
            else:
                if distances is None:
                    distances = _distances([FIXED, *(c for p in _BY_KIND.values() for c in p), *colors])
                colors.append(_candidates()[int(distances.argmax())])
        taken.add(colors[-1])
        if distances is not None:
            distances = np.minimum(distances, _distances(colors[-1:]))
    return colors


def _word(value: Any) -> str:
    return str(getattr(value, "name", value)).lower()


@functools.cache
def _candidates() -> list[Color]:
    """Neither pale nor dark nor grey."""
    return [
        colorsys.hsv_to_rgb(hue / 36.0, saturation, value)
        for saturation in (0.45, 0.6, 0.3)
        for value in (0.75, 0.9, 0.6, 0.45)
        for hue in range(36)
    ]


@functools.cache
def _seen_candidates() -> np.ndarray:
    return _oklab(_candidates())


def _distances(colors: Sequence[Color]) -> np.ndarray:
    """From each candidate to the nearest of some colours, as seen."""
    apart = _seen_candidates()[:, None] - _oklab(colors)[None]
    return np.asarray(np.linalg.norm(apart, axis=2).min(axis=1))


def _oklab(colors: Sequence[Color]) -> np.ndarray:
    """(n, 3), in which equal distances look about equally different. [Ottosson 2020, "A perceptual color
    space for image processing"]"""
    c = np.asarray(colors, dtype=np.float64)
    light = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    cones = light @ np.array(
        [
            [0.4122214708, 0.2119034982, 0.0883024619],
            [0.5363325363, 0.6806995451, 0.2817188376],
            [0.0514459929, 0.1073969566, 0.6299787005],
        ]
    )
    return np.asarray(
        np.cbrt(cones)
        @ np.array(
            [
                [0.2104542553, 1.9779984951, 0.0259040371],
                [0.7936177850, -2.4285922050, 0.7827717662],
                [-0.0040720468, 0.4505937099, -0.8086757660],
            ]
        )
    )
