"""Colours of numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._core import InvalidArgument
from ..arguments import real_array

#: Control points, evenly spaced, sRGB. viridis and magma: S. van der Walt and N. Smith, CC0; even steps of
#: lightness, also for eyes that tell red and green badly. coolwarm: K. Moreland, for values of both signs.
_POINTS = {
    "viridis": "440154 482878 3e4989 31688e 26828e 1f9e89 35b779 6ece58 b5de2b fde725",
    "magma": "000004 180f3d 440f76 721f81 9e2f7f cd4071 f1605d fd9668 feca8d fcfdbf",
    "coolwarm": "3b4cc0 8db0fe dddddd f49a7b b40426",
}
COLORMAPS = tuple(_POINTS)


class Colormap:
    """Colours between two limits."""

    def __init__(self, points: Any) -> None:
        """``points``: the name of a colour map, or its colours (k, 3), sRGB in [0, 1], evenly spaced from the
        lower limit to the upper one. Raises InvalidArgument for what is neither."""
        if isinstance(points, str):
            if points not in _POINTS:
                raise InvalidArgument(
                    f"colormap '{points}' is unknown; choose one of {', '.join(_POINTS)}, or give colours "
                    f"(k, 3) in [0, 1]"
                )
            rows = [[int(code[i : i + 2], 16) / 255.0 for i in (0, 2, 4)] for code in _POINTS[points].split()]
            self.points: np.ndarray = np.array(rows)
            return
        self.points = real_array(points, "colormap")
        shape = self.points.shape
        if len(shape) != 2 or shape[1] != 3 or shape[0] < 2 or not _in_unit_cube(self.points):
            raise InvalidArgument(
                f"colormap of shape {shape}: must be a name ({', '.join(_POINTS)}) or at least two colours "
                f"(k, 3), each number in [0, 1]"
            )

    def __call__(self, shares: Any) -> np.ndarray:
        """Colours (..., 3), sRGB in [0, 1], at shares (...) of the way from the lower limit to the upper one;
        what lies beyond has the colour of the limit."""
        at = np.clip(np.asarray(shares, dtype=np.float64), 0.0, 1.0)
        places = np.linspace(0.0, 1.0, len(self.points))
        return np.stack([np.interp(at, places, self.points[:, c]) for c in range(3)], axis=-1)


def _in_unit_cube(points: np.ndarray) -> bool:
    return bool((points >= 0.0).all() and (points <= 1.0).all())  # false for NaN


def linear(srgb: Any) -> np.ndarray:
    """Linear light of sRGB, both in [0, 1]."""
    c = np.asarray(srgb, dtype=np.float64)
    return np.where(c <= 0.04045, c / 12.92, ((np.maximum(c, 0.0) + 0.055) / 1.055) ** 2.4)


def srgb_bytes(light: Any) -> np.ndarray:
    """sRGB in 8 bits of linear light; what is beyond 1 is white."""
    c = np.clip(np.asarray(light, dtype=np.float64), 0.0, 1.0)
    s = np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1.0 / 2.4) - 0.055)
    return np.asarray(255.0 * s + 0.5).astype(np.uint8)
