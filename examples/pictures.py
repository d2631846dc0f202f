"""Pictures of examples: bodies of several moments side by side, robots, toothed wheels, points on curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import stark

OUT, WIDTH = Path("out"), 1280
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
    bodies: Iterable[SimpleNamespace],
    *,
    azimuth: float,
    elevation: float,
    height: int = 480,
    edges: bool = False,
) -> Path:
    """Draws bodies, seen from ``azimuth`` and ``elevation`` [degrees], and writes out/NAME.png."""
    bodies = list(bodies)
    points = np.concatenate([body.positions for body in bodies])
    camera = fitted_camera(points, azimuth * stark.deg, elevation * stark.deg, WIDTH / height)
    picture = stark.render.render(SimpleNamespace(bodies=bodies), WIDTH, height, camera=camera, edges=edges)
    OUT.mkdir(exist_ok=True)
    path = OUT / f"{name}.png"
    stark.render.write_png(path, picture)
    return path


def part(body: Any, *, shift: ArrayLike = (0.0, 0.0, 0.0), keep: ArrayLike | None = None) -> SimpleNamespace:
    """A body of a frame of a recording, moved by ``shift`` [m], with the triangles of the mask ``keep``."""
    return SimpleNamespace(
        name=body.name,
        kind=body.kind,
        motion=body.motion,
        color=body.color,
        positions=body.positions + np.asarray(shift, dtype=np.float64),
        triangles=body.triangles if keep is None else body.triangles[np.asarray(keep)],
    )


def visuals(
    robot: stark.robots.Robot, colors: Mapping[str, Sequence[float]], others: Sequence[float]
) -> list[SimpleNamespace]:
    """The links of a robot where they are now, with the surfaces that its file shows and the colour of the
    first word that is in their name."""
    return [
        SimpleNamespace(
            name=name,
            kind="rigid",
            motion="dynamic",
            color=next((color for word, color in colors.items() if word in name), others),
            positions=link.visual.vertices @ link.rotation.T + link.position,
            triangles=link.visual.triangles,
        )
        for name, link in robot.links.items()
        if link.visual is not None
    ]


def compose(
    path: Path, bodies: Sequence[SimpleNamespace], *, azimuth: float, elevation: float, height: int = 480
) -> Path:
    """Draws bodies on a common floor, seen from ``azimuth`` and ``elevation`` [degrees]; a body called floor
    need not be in the picture as a whole."""
    points = np.concatenate([body.positions for body in bodies if body.name != "floor"])
    camera = fitted_camera(points, azimuth * stark.deg, elevation * stark.deg, WIDTH / height)
    picture = stark.render.render(SimpleNamespace(bodies=list(bodies)), WIDTH, height, camera=camera)
    stark.render.write_png(path, picture)
    return path


def fitted_camera(
    points: np.ndarray, azimuth: float, elevation: float, aspect: float, fill: float = 0.86
) -> stark.render.Camera:
    """The camera from which the points (n, 3) fill this share of the picture and stand in its middle."""
    c, s = np.cos([azimuth, elevation]), np.sin([azimuth, elevation])
    back, right = np.array([c[1] * c[0], c[1] * s[0], s[1]]), np.array([-s[0], c[0], 0.0])
    axes = np.stack([right, np.cross(back, right)])
    half = np.tan(0.5 * stark.render.Camera.vertical_fov) * np.array([aspect, 1.0])
    target = 0.5 * (points.min(axis=0) + points.max(axis=0))
    distance = 0.0
    for _ in range(20):  # each time the middle of the picture comes closer to the middle of the points
        plane, depth = (points - target) @ axes.T / half, (points - target) @ back
        distance = float(np.max(np.abs(plane).max(axis=1) / fill + depth))
        seen = plane / (distance - depth)[:, None]
        target = target + 0.5 * (seen.min(axis=0) + seen.max(axis=0)) * half * distance @ axes
    return stark.render.Camera.looking(target, distance, azimuth, elevation)


def toothed_wheel(
    teeth: int, radius: float, thickness: float, gap_at_zero: bool = False
) -> stark.mesh.TriangleMesh:
    """A wheel about the z axis with a tooth, or a gap, at angle zero. Two wheels mesh where their pitch
    circles, of ``radius`` [m], touch and radius / teeth is the same."""
    # Corners of a tooth: (share of a pitch from its middle, height in radius / teeth), slim enough to clear.
    profile = np.array([(-0.30, -1.2), (-0.24, -0.6), (-0.10, 0.9), (0.10, 0.9), (0.24, -0.6), (0.30, -1.2)])
    k = np.repeat(np.arange(teeth), len(profile)) + 0.5 * gap_at_zero
    angle = 2 * np.pi / teeth * (k + np.tile(profile[:, 0], teeth))
    r = radius * (1 + np.tile(profile[:, 1], teeth) / teeth)
    rim = np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full(len(r), 0.5 * thickness)])
    n, up = len(rim), np.array([0, 0, 0.5 * thickness])
    vertices = np.concatenate([rim, rim * (1, 1, -1), [up, -up]])
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    faces = [(i, j, 2 * n + 0 * i), (n + j, n + i, 2 * n + 1 + 0 * i), (i, n + i, j), (j, n + i, n + j)]
    return stark.mesh.TriangleMesh(vertices, np.concatenate([np.column_stack(face) for face in faces]))


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
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 620 380"',
        '  font-family="sans-serif" font-size="14">',
        '<rect width="620" height="380" fill="white"/>',
        f'<path d="M{left:.0f},{bottom - height:.0f} v{height:.0f} h{width:.0f}"',
        '  fill="none" stroke="black"/>',
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
