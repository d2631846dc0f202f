"""conveyor: a belt, a curve and a belt back carry a box, a soft block and a towel.

The three fixed boxes do not move; their surfaces do.

    python examples/conveyor.py      simulates, checks itself, writes the picture out/conveyor.png
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import stark

SPEED, RADIUS, FRICTION = 0.5, 0.25, 0.6  # [m/s], [m] of the middle of the curve
LENGTH, WIDTH, DEPTH, GAP = 1.0, 0.36, 0.08, 0.002  # [m] of the belts
CARDBOARD, BELT = (0.78, 0.6, 0.38), (0.2, 0.22, 0.25)


def line() -> stark.Scene:
    scene = stark.Scene("conveyor")
    scene.default_friction = FRICTION
    for side, name in ((1, "there"), (-1, "back")):
        place = (-0.5 * LENGTH - GAP, side * RADIUS, -0.5 * DEPTH)
        size = (LENGTH, WIDTH, DEPTH)
        belt = scene.add_box(size, motion="fixed", position=place, name=name, color=BELT)
        belt.surface_velocity = (side * SPEED, 0, 0)
    reach = RADIUS + 0.5 * WIDTH
    middle = (0.5 * reach, 0, -0.5 * DEPTH)
    bend = (reach, 2 * reach, DEPTH)
    curve = scene.add_box(bend, motion="fixed", position=middle, name="curve", color=BELT)
    curve.surface_center = (-0.5 * reach, 0, 0)
    curve.surface_spin = (0, 0, -SPEED / RADIUS)
    scene.add_box((0.16, 0.12, 0.1), mass=0.5, position=(-0.2, RADIUS, 0.051), name="box", color=CARDBOARD)
    foam = stark.SolidMaterial(density=60.0, youngs_modulus=2e4)
    block = stark.mesh.tet_box((0.14, 0.14, 0.1), 3)
    scene.add_solid(block, foam, position=(-0.45, RADIUS, 0.051), name="block", color=(0.3, 0.55, 0.8))
    towel = stark.mesh.grid(0.3, 0.24, 10)
    scene.add_cloth(towel, stark.materials.cotton, position=(-0.75, RADIUS, 0.002), name="towel")
    return scene


def way(x: np.ndarray) -> float:
    """How far along the middle of the line a point is, from the end of the first belt [m]."""
    if x[0] < 0.0:
        return float(x[0]) if x[1] > 0.0 else float(np.pi * RADIUS - x[0])
    return float(RADIUS * (np.pi / 2 - np.arctan2(x[1], x[0])))


def main() -> None:
    sim = stark.Simulation(line(), time_step=0.01, contact_distance=1e-3)
    bodies = [sim[name] for name in ("box", "block", "towel")]
    start = [way(body.positions.mean(axis=0)) for body in bodies]
    work = sum(report.energy["belts"] for report in sim.run(until=2.2))
    Path("out").mkdir(exist_ok=True)
    view: dict[str, Any] = {"camera": (-0.9, -1.3, 1.0), "target": (-0.3, 0.02, 0.0), "field_of_view": 0.55}
    sim.picture("out/conveyor.png", size=(1280, 560), quality="best", **view)
    # All slide until they have the speed of the belt, for v / (mu g): half of that way is missing.
    expected = SPEED * sim.time - SPEED**2 / (2 * FRICTION * 9.81)
    for body, first in zip(bodies, start, strict=True):
        gone = way(body.positions.mean(axis=0)) - first
        print(f"{body.name}: {gone:.3f} m along the line, {expected:.3f} m expected")
        assert abs(gone - expected) < 0.04 * expected
    print(f"the drives did {work:.3f} J")
    print("check: passed")


if __name__ == "__main__":
    main()
