"""Plots of measured curves and of what a law predicts, as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

from stark.array_file import naming, refuse_special
from stark.curves import Curve, Floats

_LEFT, _WIDTH, _HEIGHT, _PITCH, _TOP = 86.0, 560.0, 220.0, 290.0, 34.0  # of a panel, in pixels
_COLORS = ("#3366aa", "#dd6644")
_IMPOSED = {
    "shear": "shear",
    "volumetric": "volume / volume at rest",
    "bending": "curvature [1/m]",
    "torsion": "twist [rad/m]",
}


@dataclass(frozen=True)
class Panel:
    """A measured curve and its prediction (n, q)."""

    curve: Curve
    predicted: Floats

    @property
    def abscissa(self) -> tuple[str, Floats]:
        """Label and values (n,): of curves at a constant value the time."""
        curve = self.curve
        if curve.ramp is not None and curve.times is not None:
            return "time [s]", curve.times
        return _IMPOSED.get(curve.kind, "stretch"), curve.imposed[:, 0]


def written(path: Path, panels: Sequence[Panel]) -> Path:
    """Writes one panel for each curve, below each other: circles are measured, lines predicted.
    Raises WriteError."""
    width, height = _LEFT + _WIDTH + 24, _PITCH * len(panels) + 10
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}"',
        '  font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for k, panel in enumerate(panels):
        lines += _panel(_TOP + _PITCH * k, panel)
    with naming(path):
        refuse_special(path)
        path.write_text("\n".join([*lines, "</svg>\n"]), encoding="utf-8")
    return path


def _panel(top: float, panel: Panel) -> list[str]:
    label, across = panel.abscissa
    measured = panel.curve.measured
    ticks_x = _ticks(across.min(), across.max(), 8)
    both = np.concatenate([measured, panel.predicted])
    ticks_y = _ticks(both.min(), both.max(), 5)

    def x(value: Floats) -> Floats:
        return np.asarray(_LEFT + _WIDTH * (value - ticks_x[0]) / (ticks_x[-1] - ticks_x[0]))

    def y(value: Floats) -> Floats:
        return np.asarray(top + _HEIGHT * (ticks_y[-1] - value) / (ticks_y[-1] - ticks_y[0]))

    lines = [
        f'<rect x="{_LEFT:.0f}" y="{top:.0f}" width="{_WIDTH:.0f}" height="{_HEIGHT:.0f}" fill="#f7f7f5"/>'
    ]
    lines += _axes(top, ticks_x, ticks_y, x(ticks_x), y(ticks_y))
    lines.append(_text(_LEFT, top - 10, f"{panel.curve.name}: measured (circles), predicted (line)", "start"))
    lines.append(_text(_LEFT + 0.5 * _WIDTH, top + _HEIGHT + 36, label))
    turn = f' transform="rotate(-90 18 {top + 0.5 * _HEIGHT:.0f})"'
    lines.append(_text(18, top + 0.5 * _HEIGHT, _measured(panel.curve), "middle", turn))
    for q in range(measured.shape[1]):
        color = _COLORS[q % len(_COLORS)]
        places = " ".join(
            f"{a:.1f},{b:.1f}" for a, b in zip(x(across), y(panel.predicted[:, q]), strict=True)
        )
        lines.append(f'<polyline points="{places}" fill="none" stroke="{color}" stroke-width="1.8"/>')
        for a, b in zip(x(across), y(measured[:, q]), strict=True):
            lines.append(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3.2" fill="none" stroke="{color}"/>')
    return lines


def _axes(top: float, ticks_x: Floats, ticks_y: Floats, x: Floats, y: Floats) -> list[str]:
    lines = []
    for value, place in zip(ticks_y, y, strict=True):
        lines.append(f'<path d="M{_LEFT:.0f},{place:.1f} h{_WIDTH:.0f}" stroke="#dddddd"/>')
        lines.append(_text(_LEFT - 6, place + 4, f"{value:.4g}", "end"))
    for value, place in zip(ticks_x, x, strict=True):
        lines.append(f'<path d="M{place:.1f},{top:.0f} v{_HEIGHT:.0f}" stroke="#dddddd"/>')
        lines.append(_text(place, top + _HEIGHT + 17, f"{value:.4g}"))
    return lines


def _measured(curve: Curve) -> str:
    return {"bending": "moment", "torsion": "torque [N m]", "volumetric": "pressure [Pa]"}.get(
        curve.kind, "stress [Pa]"
    )


def _ticks(low: float, high: float, count: int) -> Floats:
    """Round numbers around a range, about ``count`` steps of 1, 2 or 5 times a power of ten."""
    rough = max(high - low, 1e-3 * max(abs(high), abs(low)), 1e-300) / count
    power = 10.0 ** np.floor(np.log10(rough))
    step = power * next(m for m in (1.0, 2.0, 5.0, 10.0) if m * power >= rough * (1.0 - 1e-9))
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    return np.asarray(step * np.arange(first, max(last, first + 1.0) + 1.0))


def _text(x: float, y: float, words: str, anchor: str = "middle", more: str = "") -> str:
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}"{more}>{escape(words)}</text>'
