"""Pictures of the tutorials: bodies of several moments side by side, and plots of points on curves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike

import stark

OUT = Path("out")
RED, BLUE, GREEN, YELLOW = (0.87, 0.44, 0.34), (0.33, 0.45, 0.66), (0.20, 0.64, 0.60), (0.94, 0.68, 0.26)


def snapshot(
    body: stark.Body, *, shift: ArrayLike = (0.0, 0.0, 0.0), color: Sequence[float] | None = None
) -> SimpleNamespace:
    """Where a body is now, moved by ``shift`` [m]: something that ``stark.render`` draws."""
    return SimpleNamespace(
        name=body.name,
        kind=body.kind,
        motion="dynamic",
        color=color or body.color,
        positions=body.surface_positions + np.asarray(shift, dtype=np.float64),
        triangles=body.surface_triangles,
    )


def save(
    name: str,
    bodies: Sequence[SimpleNamespace],
    *,
    azimuth: float,
    elevation: float,
    zoom: float = 1.0,
    height: int = 480,
    edges: bool = False,
) -> Path:
    """Draws bodies, seen from ``azimuth`` and ``elevation`` [degrees], and writes out/NAME.png. At ``zoom`` 1
    the ball around all of them fills the height."""
    scene = SimpleNamespace(bodies=list(bodies))
    bounds = stark.render.scene_bounds(scene)
    distance = bounds.radius / np.sin(0.5 * stark.render.Camera.vertical_fov) / zoom
    camera = stark.render.Camera.looking(
        bounds.center, distance, azimuth * stark.deg, elevation * stark.deg
    )
    picture = stark.render.render(scene, 1280, height, camera=camera, bounds=bounds, edges=edges)
    OUT.mkdir(exist_ok=True)
    path = OUT / f"{name}.png"
    stark.render.write_png(path, picture)
    return path


def plot(name: str, curve: ArrayLike, points: ArrayLike, x_label: str, y_label: str) -> Path:
    """Writes a line through ``curve`` (n, 2) and dots at ``points`` (m, 2) as out/NAME.svg."""
    curve, points = np.asarray(curve, dtype=np.float64), np.asarray(points, dtype=np.float64)
    low, high = curve.min(axis=0), curve.max(axis=0)
    left, bottom, width, height = 80.0, 320.0, 520.0, 300.0

    def pixels(rows: np.ndarray) -> np.ndarray:
        return (left, bottom) + (rows - low) / (high - low) * (width, -height)

    def text(x: float, y: float, words: str, turned: str = "") -> str:
        return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="middle"{turned}>{words}</text>'

    lines = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 620 380" font-family="sans-serif" font-size="14">',
        '<rect width="620" height="380" fill="white"/>',
        f'<path d="M{left:.0f},{bottom - height:.0f} v{height:.0f} h{width:.0f}" fill="none" stroke="black"/>',
    ]
    for u in np.linspace(0.0, 1.0, 6):
        x, y = low + u * (high - low)
        lines.append(text(left + u * width, bottom + 20, f"{x:.3g}"))
        lines.append(text(left - 26, bottom - u * height + 5, f"{y:.3g}"))
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in pixels(curve))
    lines.append(f'<polyline points="{path}" fill="none" stroke="#3366aa" stroke-width="2"/>')
    lines += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="#dd6644"/>' for x, y in pixels(points)]
    lines.append(text(left + width / 2, bottom + 48, x_label))
    lines.append(text(18, bottom - height / 2, y_label, ' transform="rotate(-90 18 170)"'))
    OUT.mkdir(exist_ok=True)
    file = OUT / f"{name}.svg"
    file.write_text("\n".join([*lines, "</svg>\n"]))
    return file
