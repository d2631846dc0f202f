"""Letters as strokes, for numbers and names in pictures: no font has to be there.

A stroke is a row of points, two digits each: x in [0, 4], y with the baseline at 2, small letters up to 6,
capitals up to 8. ~ rounds its corners."""

from __future__ import annotations

import functools

import numpy as np

#: Between letters, in units of the grid of the strokes.
_GAP, _SPACE = 1.6, 2.4
#: Height of capitals.
CAP = 6.0

_GLYPHS = {
    "0": "~12 04 06 18 38 46 44 32 12",
    "1": "06 28 22",
    "2": "~06 07 18 38 47 46 45 02|02 42",
    "3": "~07 18 38 47 46 35 15|~15 35 44 43 32 12 03",
    "4": "32 38 04 44",
    "5": "48 08 05|~05 16 36 45 43 32 12 03",
    "6": "~47 38 18 06 04 12 32 43 44 35 15 04",
    "7": "08 48 12",
    "8": "~15 06 07 18 38 47 46 35 15|~15 04 03 12 32 43 44 35 15",
    "9": "~03 12 32 44 46 38 18 07 06 15 35 46",
    "A": "02 28 42|14 34",
    "B": "02 08 28|~28 38 47 46 35 25|05 25|~25 35 44 43 32 22|02 22",
    "C": "~47 38 18 06 04 12 32 43",
    "D": "02 08 18|~18 38 46 44 32 12|02 12",
    "E": "48 08 02 42|05 35",
    "F": "48 08 02|05 35",
    "G": "~47 38 18 06 04 12 32 43|43 45 25",
    "H": "02 08|42 48|05 45",
    "I": "08 28|18 12|02 22",
    "J": "38 34|~34 33 22 12 03",
    "K": "02 08|48 04|15 42",
    "L": "08 02 42",
    "M": "02 08 24 48 42",
    "N": "02 08 42 48",
    "O": "~12 04 06 18 38 46 44 32 12",
    "P": "02 08 28|~28 38 47 46 35 25|05 25",
    "Q": "~12 04 06 18 38 46 44 32 12|24 42",
    "R": "02 08 28|~28 38 47 46 35 25|05 25|25 42",
    "S": "~47 38 18 07 06 15 35 44 43 32 12 03",
    "T": "08 48|28 22",
    "U": "08 04|~04 03 12 32 43 44|44 48",
    "V": "08 22 48",
    "W": "08 12 26 32 48",
    "X": "02 48|08 42",
    "Y": "08 25 48|25 22",
    "Z": "08 48 02 42",
    "a": "36 32|~35 26 16 05 03 12 22 33",
    "b": "08 02|~05 16 26 35 33 22 12 03",
    "c": "~35 26 16 05 03 12 22 33",
    "d": "38 32|~35 26 16 05 03 12 22 33",
    "e": "04 34|~34 35 26 16 05 03 12 22 33",
    "f": "~28 18 17 16|16 12|06 26",
    "g": "36 31|~31 20 10 01|~35 26 16 05 03 12 22 33",
    "h": "08 02|~05 16 26 35 34|34 32",
    "i": "02 06|08 08",
    "j": "16 11|~11 10 00|18 18",
    "k": "08 02|36 04|15 32",
    "l": "02 08",
    "m": "02 06|~05 16 25 24|24 22|~25 36 45 44|44 42",
    "n": "02 06|~05 16 26 35 34|34 32",
    "o": "~16 05 03 12 22 33 35 26 16",
    "p": "06 00|~05 16 26 35 33 22 12 03",
    "q": "36 30|~35 26 16 05 03 12 22 33",
    "r": "02 06|~04 15 26",
    "s": "~35 26 16 05 14 24 33 22 12 03",
    "t": "18 13|~13 12 22|06 26",
    "u": "06 04|~04 03 12 22 33|36 32",
    "v": "06 22 46",
    "w": "06 12 25 32 46",
    "x": "02 36|06 32",
    "y": "06 22|46 10",
    "z": "06 36 02 32",
    ".": "02 02",
    ",": "12 00",
    ":": "02 02|05 05",
    "-": "05 35",
    "+": "05 45|23 27",
    "=": "04 44|06 46",
    "/": "01 39",
    "(": "~28 06 03 21",
    ")": "~08 26 23 01",
    "[": "19 09 01 11",
    "]": "09 19 11 01",
    "%": "02 48|~08 18 16 06 08|~34 44 42 32 34",
    "*": "14 38|34 18|06 46",
    "_": "01 41",
    "^": "06 28 46",
    "'": "08 06",
    "<": "47 05 43",
    ">": "07 45 03",
    "!": "08 04|02 02",
    "?": "~06 07 18 38 47 46 24|22 22",
    "|": "09 01",
    "#": "12 18|32 38|04 44|06 46",
}


def strokes(text: str, height: float) -> tuple[list[np.ndarray], float]:
    """Rows of points (n, 2) [px], x to the right from 0, y downwards from the baseline, of a text whose
    capitals have this height [px]; and the width of the text [px]. Characters without a glyph are ?."""
    scale, x, result = height / CAP, 0.0, []
    for character in text:
        if character == " ":
            x += _SPACE
            continue
        parts, width = _glyph(character if character in _GLYPHS else "?")
        result += [scale * (part * (1.0, -1.0) + (x, 0.0)) for part in parts]
        x += width + _GAP
    return result, scale * max(x - _GAP, 0.0)


@functools.cache
def _glyph(character: str) -> tuple[list[np.ndarray], float]:
    """Strokes above the baseline in units of the grid, and the width."""
    parts = []
    for text in _GLYPHS[character].split("|"):
        points = np.array([(int(p[0]), int(p[1]) - 2) for p in text.lstrip("~").split()], dtype=np.float64)
        parts.append(_rounded(points) if text.startswith("~") else points)
    return parts, float(max(part[:, 0].max() for part in parts))


def _rounded(points: np.ndarray) -> np.ndarray:
    """Corners cut twice [Chaikin 1974]; the ends of open rows stay."""
    for _ in range(2):
        a, b = points[:-1], points[1:]
        cut = np.stack([0.75 * a + 0.25 * b, 0.25 * a + 0.75 * b], axis=1).reshape(-1, 2)
        closed = np.array_equal(points[0], points[-1])
        points = np.concatenate([cut, cut[:1]] if closed else [points[:1], cut, points[-1:]])
    return points
