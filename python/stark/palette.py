"""Colours of bodies in pictures and replays, sRGB in [0, 1]: a small palette that stays apart in print."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

FIXED = (0.80, 0.81, 0.83)
_BY_KIND: dict[str, tuple[tuple[float, float, float], ...]] = {
    "cloth": ((0.87, 0.44, 0.34), (0.36, 0.56, 0.86), (0.94, 0.68, 0.26), (0.62, 0.45, 0.80)),
    "solid": ((0.20, 0.64, 0.60), (0.93, 0.60, 0.28), (0.84, 0.40, 0.52), (0.46, 0.66, 0.32)),
    "fibres": ((0.22, 0.23, 0.26), (0.72, 0.28, 0.24), (0.30, 0.42, 0.62)),
    "rigid": (
        (0.33, 0.45, 0.66), (0.91, 0.66, 0.33), (0.47, 0.63, 0.50), (0.80, 0.45, 0.38), (0.55, 0.49, 0.70),
        (0.36, 0.62, 0.70),
    ),
}  # fmt: skip


def body_colors(bodies: Sequence[Any]) -> list[tuple[float, float, float]]:
    """One colour a body: its own when it has one, light grey when it is fixed, else the next of its kind's
    palette."""
    used: dict[str, int] = {}
    colors = []
    for body in bodies:
        color = getattr(body, "color", None)
        kind = str(getattr(body.kind, "name", body.kind)).lower()
        motion = getattr(body, "motion", "")
        motion = str(getattr(motion, "name", motion)).lower()
        if color is not None:
            red, green, blue = (float(c) for c in tuple(color)[:3])
            colors.append((red, green, blue))
        elif motion == "fixed":
            colors.append(FIXED)
        else:
            palette = _BY_KIND.get(kind, _BY_KIND["rigid"])
            colors.append(palette[used.get(kind, 0) % len(palette)])
            used[kind] = used.get(kind, 0) + 1
    return colors
