"""Plots of what a run measured: panels of curves over time, one above the other, as SVG."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

COLORS = ("#3366aa", "#dd6644", "#339966", "#e0a030")
LEFT, WIDTH, HEIGHT, PITCH, TOP = 76.0, 600.0, 120.0, 158.0, 20.0  # of a panel, in pixels


def write(path: Path, time: ArrayLike, panels: Mapping[str, Mapping[str, ArrayLike]]) -> Path:
    """Writes curves over ``time`` [s] as ``path``. ``panels``: axis label to curves by name, each with a
    value for every time."""
    time = np.asarray(time, dtype=np.float64)
    height = TOP + PITCH * len(panels) + 20
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {LEFT + WIDTH + 24:.0f} {height:.0f}"',
        '  font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for k, (label, curves) in enumerate(panels.items()):
        lines += _panel(TOP + PITCH * k, label, time, {name: np.asarray(c) for name, c in curves.items()})
    lines.append(_text(LEFT + 0.5 * WIDTH, height - 8, "time [s]"))
    path.write_text("\n".join([*lines, "</svg>\n"]))
    return path


def _panel(top: float, label: str, time: np.ndarray, curves: Mapping[str, np.ndarray]) -> list[str]:
    values = np.concatenate(list(curves.values()))
    heights, ticks = _ticks(values.min(), values.max()), _ticks(time[0], time[-1], 8)
    start, end, low, high = time[0], time[-1], heights[0], heights[-1]

    def x(t: ArrayLike) -> Any:
        return LEFT + WIDTH * (np.asarray(t) - start) / (end - start)

    def y(value: ArrayLike) -> Any:
        return top + HEIGHT * (high - np.asarray(value)) / (high - low)

    lines = [
        f'<rect x="{LEFT:.0f}" y="{top:.0f}" width="{WIDTH:.0f}" height="{HEIGHT:.0f}" fill="#f7f7f5"/>',
        _text(16, top + 0.5 * HEIGHT, label, f' transform="rotate(-90 16 {top + 0.5 * HEIGHT:.0f})"'),
    ]
    for value in heights:
        lines.append(f'<path d="M{LEFT:.0f},{y(value):.1f} h{WIDTH:.0f}" stroke="#dddddd"/>')
        lines.append(_text(LEFT - 6, y(value) + 4, f"{value:.5g}", anchor="end"))
    for t in ticks[(ticks > start - 1e-9) & (ticks < end + 1e-9)]:
        lines.append(_text(x(t), top + HEIGHT + 16, f"{t:.5g}"))
    for k, (name, curve) in enumerate(curves.items()):
        color = COLORS[k % len(COLORS)]
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x(time), y(curve), strict=True))
        dash = ' stroke-dasharray="6 4"' if k % 2 else ""
        lines.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.8"{dash}/>')
        place = LEFT + WIDTH - 8 - 90 * (len(curves) - 1 - k)
        lines.append(_text(place, top - 5, name, f' fill="{color}"', anchor="end"))
    return lines


def _ticks(low: float, high: float, count: int = 3) -> np.ndarray:
    """Round numbers around a range, about ``count`` steps of 1, 2 or 5 times a power of ten."""
    rough = max(high - low, 1e-3 * abs(high), 1e-9) / count
    power = 10.0 ** np.floor(np.log10(rough))
    step = power * next(m for m in (1.0, 2.0, 5.0, 10.0) if m * power >= rough * (1 - 1e-9))
    return step * np.arange(np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9) + 1)


def _text(x: float, y: float, words: str, more: str = "", anchor: str = "middle") -> str:
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}"{more}>{words}</text>'
