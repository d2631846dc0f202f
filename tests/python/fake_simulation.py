"""A simulation without physics that speaks the protocol of recordings: a waving cloth, a turning box, a
floor."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from stark.recording import Recorder, Recording


def grid(cells: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of a flat square about the origin."""
    ticks = np.linspace(-0.5 * size, 0.5 * size, cells + 1)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    right, far = corner + cells + 1, corner + cells + 2
    triangles = np.concatenate([np.stack([corner, right, far], 1), np.stack([corner, far, corner + 1], 1)])
    return points, triangles.astype(np.int32)


def box(sizes: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Closed box about the origin, triangles counter-clockwise seen from outside."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return 0.5 * corners * sizes, np.array(triangles, dtype=np.int32)


def report(time: float, **changes: object) -> SimpleNamespace:
    values = {
        "status": "accepted",
        "time": time,
        "time_step": 1.0 / 30.0,
        "newton_iterations": 5 + int(10 * time) % 3,
        "linear_iterations": 0,
        "factorizations": 5,
        "contact_count": int(100 * time),
        "min_distance": math.inf if time < 0.2 else 1e-3 + 1e-4 * time,
        "residual": 1e-7 * (1.0 + time),
        "energy": {"kinetic": time * time, "elastic": 0.5 * time, "gravity": -time},
        "line_search_backtracks": 1,
        "rejected_steps": 0,
        "phases": {"assemble": 0.01, "solve": 0.02},
        "message": "",
    }
    return SimpleNamespace(**{**values, **changes})


class FakeSimulation:
    """Steps of 1/30 s; the box turns by 90 deg/s about z."""

    def __init__(self, cells: int = 6) -> None:
        self.time, self.time_step = 0.0, 1.0 / 30.0
        self._cloth, cloth_triangles = grid(cells, 0.4)
        self._box, box_triangles = box((0.08, 0.08, 0.08))
        floor, floor_triangles = box((4.0, 4.0, 0.1))
        body = SimpleNamespace
        self.bodies = [
            body(
                name="cloth", kind="cloth", motion="dynamic", triangles=cloth_triangles, color=(0.8, 0.3, 0.2)
            ),
            body(
                name="</script>box & 'Ω'",
                kind="rigid",
                motion="scripted",
                triangles=box_triangles,
                color=None,
            ),
            body(name="floor", kind="rigid", motion="fixed", triangles=floor_triangles, color=None),
        ]
        self.bodies[2].positions = floor - np.array([0.0, 0.0, 0.35])
        self._place()

    def _place(self) -> None:
        x, y = self._cloth[:, 0], self._cloth[:, 1]
        z = 0.05 * np.sin(8.0 * x + 3.0 * self.time) * np.cos(5.0 * y)
        self.bodies[0].positions = np.stack([x, y, z], axis=1)
        angle = 0.5 * math.pi * self.time
        c, s = math.cos(angle), math.sin(angle)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        self.bodies[1].positions = self._box @ turn.T + [0.0, 0.0, -0.15]

    def step(self) -> SimpleNamespace:
        self.time += self.time_step
        self._place()
        return report(self.time)


def record(folder: Path, steps: int, cells: int = 6, **options: object) -> Recording:
    """A complete recording with ``steps`` + 1 frames."""
    sim = FakeSimulation(cells)
    with Recorder(folder, sim, scene="fake", settings={"time_step": sim.time_step}, **options) as recorder:
        recorder.record(sim)
        for _ in range(steps):
            recorder.report(sim.step(), wall=0.02)
            recorder.record(sim)
    return Recording(folder)
