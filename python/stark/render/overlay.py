"""Lines, shapes and letters over a finished picture, with soft edges."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from .lettering import strokes

Color = tuple[float, float, float]
INK: Color = (0.12, 0.13, 0.15)
PAPER: Color = (1.0, 1.0, 1.0)


class Overlay:
    """What is drawn over a picture (height, width, 3) uint8; places are pixels (x, y) from the upper left
    corner, whose first pixel has its middle at (0.5, 0.5)."""

    def __init__(self, picture: np.ndarray) -> None:
        self._pixels = np.asarray(picture, dtype=np.float64)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self._pixels.shape[1], self._pixels.shape[0]

    @property
    def picture(self) -> np.ndarray:
        """With what was drawn."""
        return np.asarray(self._pixels + 0.5).astype(np.uint8)

    def lines(
        self, rows: Iterable[np.ndarray], width: float, color: Color = INK, *, halo: float = 0.0
    ) -> None:
        """Rows of points (n, 2), n >= 1, joined by lines with round ends; all of them cover what is below
        once. ``halo`` [px] is a rim of paper around them."""
        kept = [np.asarray(row, dtype=np.float64).reshape(-1, 2) for row in rows]
        kept = [row for row in kept if np.isfinite(row).all()]
        if not kept:
            return
        every = np.concatenate(kept)
        window = self._window(every.min(axis=0), every.max(axis=0), 0.5 * width + halo + 1.0)
        if window is None:
            return
        x, y = _middles(window)
        nearest = np.full(x.shape, np.inf)
        for row in kept:
            for a, b in zip(row, row[1:] if len(row) > 1 else row, strict=False):
                nearest = np.minimum(nearest, _distance(x, y, a, b))
        if halo > 0.0:
            self._blend(window, 0.75 * np.clip(0.5 * width + halo + 0.5 - nearest, 0.0, 1.0), PAPER)
        self._blend(window, np.clip(0.5 * width + 0.5 - nearest, 0.0, 1.0), color)

    def polygon(self, points: Sequence[ArrayLike], color: Color, opacity: float = 1.0) -> None:
        """Convex shape with these corners (n, 2)."""
        corners = np.asarray(points, dtype=np.float64)
        if not np.isfinite(corners).all():
            return
        window = self._window(corners.min(axis=0), corners.max(axis=0), 1.0)
        if window is None:
            return
        x, y = _middles(window)
        ends = np.roll(corners, -1, axis=0)
        turn = np.sign(float(np.sum(corners[:, 0] * ends[:, 1] - ends[:, 0] * corners[:, 1])))
        inside = np.full(x.shape, np.inf)
        for (ax, ay), (bx, by) in zip(corners, ends, strict=True):
            length = float(np.hypot(bx - ax, by - ay)) or 1.0
            inside = np.minimum(inside, turn * ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / length)
        self._blend(window, opacity * np.clip(inside + 0.5, 0.0, 1.0), color)

    def image(self, corner: tuple[int, int], colors: np.ndarray) -> None:
        """Colours (h, w, 3) in [0, 1], with their upper left corner there; what is outside is cut off."""
        x, y = corner
        width, height = self.size
        x0, y0, x1, y1 = (
            max(x, 0),
            max(y, 0),
            min(x + colors.shape[1], width),
            min(y + colors.shape[0], height),
        )
        if x0 < x1 and y0 < y1:
            self._pixels[y0:y1, x0:x1] = 255.0 * colors[y0 - y : y1 - y, x0 - x : x1 - x]

    def text(
        self, place: tuple[float, float], text: str, height: float, *, color: Color = INK, halo: float = 0.0
    ) -> float:
        """Writes from the left end of the baseline, capitals of this height [px]; returns the width [px]."""
        rows, width = strokes(text, height)
        self.lines([row + place for row in rows], max(1.0, 0.13 * height), color, halo=halo)
        return width

    def _window(self, low: np.ndarray, high: np.ndarray, margin: float) -> tuple[int, int, int, int] | None:
        """Columns and rows that are touched, None if there are none in the picture."""
        width, height = self.size
        x0, y0 = np.maximum(np.floor(low - margin), 0.0)
        x1, y1 = np.minimum(np.ceil(high + margin), [width, height])
        return (int(x0), int(x1), int(y0), int(y1)) if x0 < x1 and y0 < y1 else None

    def _blend(self, window: tuple[int, int, int, int], share: np.ndarray, color: Color) -> None:
        x0, x1, y0, y1 = window
        part = self._pixels[y0:y1, x0:x1]
        part += share[..., None] * (255.0 * np.asarray(color) - part)


def rectangle(left: float, top: float, right: float, bottom: float) -> list[tuple[float, float]]:
    """Corners, for ``polygon``."""
    return [(left, top), (right, top), (right, bottom), (left, bottom)]


def _middles(window: tuple[int, int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    x0, x1, y0, y1 = window
    x, y = np.meshgrid(np.arange(x0, x1) + 0.5, np.arange(y0, y1) + 0.5)
    return x, y


def _distance(x: np.ndarray, y: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """From points to a line from a to b."""
    along = b - a
    square = float(along @ along)
    share = (
        0.0 if square == 0.0 else np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / square, 0.0, 1.0)
    )
    return np.asarray(np.hypot(x - a[0] - share * along[0], y - a[1] - share * along[1]))
