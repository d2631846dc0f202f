"""grooved_ramp: boxes on a ramp of 30 degrees with grooves, five times as slippery along as across them.

Grooves that point downhill let the box run, grooves across hold it, and oblique ones lead it aside.

    python examples/grooved_ramp.py            simulates one second, checks itself, prints where the boxes go
"""

from __future__ import annotations

import numpy as np

import stark

ALONG, ACROSS = 0.13, 0.65
SLOPE, GRAVITY = 30 * stark.deg, 9.81
ANGLES = (0, 30, 60, 90)  # of the grooves against downhill [deg]


def main() -> None:
    scene = stark.Scene("grooved ramp")
    down = stark.rotation(axis="y", angle=SLOPE)
    boxes = []
    for k, angle in enumerate(ANGLES):
        lane = (0.0, 3.0 * k, 0.0)
        grid = stark.mesh.grid(6.0, 2.5, 1)
        ramp = scene.add_rigid(grid, motion="fixed", name=f"ramp_{angle}", rotation=down, position=lane)
        ramp.surface_direction = stark.rotation(axis="z", angle=angle * stark.deg)[:, 0]
        start = down @ (-2.0, -0.9, 0.0219) + lane  # beside the diagonal
        box = scene.add_box((0.1, 0.1, 0.04), mass=1.0, name=f"box_{angle}", rotation=down, position=start)
        scene.friction[box, ramp] = stark.Anisotropic(ALONG, ACROSS)
        boxes.append((box, start))
    sim = stark.Simulation(scene, time_step=0.005)
    sim.run_until(1.0)
    for angle, (box, start) in zip(ANGLES, boxes, strict=True):
        moved = ((box.position - start) @ down)[:2]
        expected = path(angle * stark.deg)
        print(f"grooves at {angle:2} degrees: {moved[0]:.3f} m downhill, {moved[1]:.3f} m aside")
        assert np.linalg.norm(moved - expected) < 0.01 * np.linalg.norm(expected) + 1e-4, (moved, expected)
    print("check: passed")


def path(angle: float) -> np.ndarray:
    """Where Coulomb's law with an ellipse of forces leads to in a second (downhill, aside) [m]."""
    axes = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    squares = axes @ np.diag([ALONG**2, ACROSS**2]) @ axes.T
    pull, weight = np.array([GRAVITY * np.sin(SLOPE), 0.0]), GRAVITY * np.cos(SLOPE)
    if np.linalg.norm(np.linalg.solve(axes * (ALONG, ACROSS), pull)) <= weight:
        return np.zeros(2)  # inside the ellipse: it stays
    v, h = 1e-9 * pull, 1e-4
    moved = np.zeros(2)
    for _ in range(10000):
        v = v + h * (pull - weight * (squares @ v) / np.sqrt(v @ squares @ v))
        moved = moved + h * v
    return moved


if __name__ == "__main__":
    main()
