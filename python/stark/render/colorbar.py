"""The scale of colours beside a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .colormaps import Colormap
from .lettering import strokes
from .overlay import PAPER, Overlay, rectangle

#: Prefixes of units by power of a thousand.
_PREFIXES = {-4: "p", -3: "n", -2: "u", -1: "m", 0: "", 1: "k", 2: "M", 3: "G", 4: "T"}
#: Units that get a prefix.
_PREFIXED = ("Pa", "N", "m/s")
#: At most so many parts between numbers, so at least two.
_PARTS = 5


def ticks(limits: tuple[float, float]) -> NDArray[np.float64]:
    """Round numbers between the limits, which may be the first and the last of them: the multiples of 1, 2 or
    5 times a power of ten, whichever gives the most of them in at most five parts."""
    low, high = limits
    least = high / _PARTS - low / _PARTS
    if least <= 1e-14 * max(map(abs, limits)):  # no number of double precision is between
        return np.array(limits)
    power = 10.0 ** math.floor(math.log10(least))
    step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= least * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    return np.clip(np.arange(first, last + 1) * step, low, high)


def numbers(limits: tuple[float, float], unit: str) -> tuple[list[str], str]:
    """Texts of the ticks, and the unit with the prefix that they are in: (0, 2100) Pa are 0, 0.5, 1, 1.5,
    2 kPa."""
    largest, power = max(map(abs, limits)), 0
    if unit in _PREFIXED and largest > 0.0:
        power = min(max(math.floor(math.log10(largest * (1 + 1e-12)) / 3.0), -4), 0 if unit == "m/s" else 4)
    values, digits = ticks(limits) / 1000.0**power, 3
    close = 0.01 * np.diff(values).min()
    while digits < 15 and any(abs(float(f"{value:.{digits}g}") - value) > close for value in values):
        digits += 1
    return [_short(float(value), digits) for value in values], f"{_PREFIXES[power]}{unit}"


def title(label: str, unit: str) -> str:
    """What is shown, and its unit."""
    return f"{label} [{unit}]" if unit else label


def draw_colorbar(
    overlay: Overlay, colormap: Colormap, limits: tuple[float, float], label: str, unit: str
) -> None:
    """At the right border of the picture: the colours, round numbers, a title."""
    width, height = overlay.size
    size = max(6.0, 0.017 * height)  # of capitals
    texts, shown = numbers(limits, unit)
    words = title(label, shown)
    bar, tall = round(1.6 * size), round(0.5 * height)
    beside = max(strokes(text, size)[1] for text in texts)
    column = max(bar + 1.1 * size + beside, strokes(words, size)[1])
    left, top = round(width - column - 1.6 * size), round(0.25 * height)
    right = left + column + 0.8 * size
    panel = rectangle(left - 0.8 * size, top - 3.4 * size, right, top + tall + 1.2 * size)
    overlay.polygon(panel, PAPER, 0.72)
    overlay.image((left, top), _ramp(colormap, bar, tall))
    frame = np.array([(0, 0), (bar, 0), (bar, tall), (0, tall), (0, 0)]) + np.array([left, top])
    overlay.lines([frame], 1.0)
    shares = (ticks(limits) - limits[0]) / (limits[1] - limits[0])
    for text, share in zip(texts, shares, strict=True):
        y = top + tall * (1.0 - float(share))
        overlay.lines([np.array([(left + bar, y), (left + bar + 0.4 * size, y)])], 1.0)
        overlay.text((left + bar + 0.9 * size, y + 0.5 * size), text, size)
    overlay.text((left, top - 1.5 * size), words, size)


def _ramp(colormap: Colormap, width: int, height: int) -> np.ndarray:
    shares = 1.0 - (np.arange(height) + 0.5) / height
    return np.repeat(colormap(shares)[:, None], width, axis=1)


def _short(value: float, digits: int) -> str:
    text = f"{value:.{digits}g}"
    return "0" if float(text) == 0.0 else text.replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def limits_of(values: Sequence[np.ndarray]) -> tuple[float, float]:
    """Limits when none are given: the least and the largest value, or 0 instead of a least one that is below
    half of the largest one, but not negative."""
    every = np.concatenate([np.zeros(0), *values])
    low, high = (float(every.min()), float(every.max())) if len(every) else (0.0, 0.0)
    low = 0.0 if 0.0 <= low < 0.5 * high else low
    return (low, high) if high > low else (low, low + 1.0)
