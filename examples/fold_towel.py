"""fold_towel: folds the towel of the robot experiments a third time, by simulation.

What it shows: pins on a motion of their own, layers of cloth with friction, the end of one scene as the start
of the next. The towel lies folded twice, in four layers; one of its sides is led over to the other on half a
circle, let go, and the eight layers come to rest. The creases cross, so no curve in a plane gives this shape.
The result is ``towel_three_folds_CELLS.npz`` beside this file, which ``towel.placed`` reads.

    python examples/fold_towel.py 52        on 30 x 53 vertices; two minutes of CPU time
"""

from __future__ import annotations

import sys

import numpy as np
import towel

import stark

STEP = 0.01  # [s]
FOLD, HOLD, SETTLE = 1.5, 0.2, 1.0  # [s]
#: How far the side that is led over comes to lie behind the other [m]: outer layers have a longer way.
SLACK = 0.045
LIFT = 1.2e-3 + stark.surfaces.terry_towel.thickness  # of the lowest layer above the floor [m]


def scene_of(points: np.ndarray, cells: int, pins: np.ndarray | None = None) -> stark.Scene:
    """The towel with its vertices at ``points`` on a floor."""
    scene = stark.Scene()
    floor = scene.add_box((2.0, 2.0, 0.1), motion="fixed", position=(0.0, 0.0, -0.05), name="floor")
    cloth = scene.add_cloth(
        towel.mesh(cells), stark.materials.towel, name="towel", mass=towel.MASS, initial_positions=points,
        surface=stark.surfaces.terry_towel, friction=0.4, pins=pins,
    )  # fmt: skip
    scene.friction[cloth, floor] = 1.0
    return scene


def led_over(rows: np.ndarray, height: float, share: float) -> np.ndarray:
    """Where the pinned vertices are after a share of the way: turned about the middle of the towel at the
    ``height`` [m] where the halves meet, on a circle that gets smaller by ``SLACK``."""
    eased = share * share * (3.0 - 2.0 * share)
    angle = np.pi * eased
    along, up = rows[:, 0] - SLACK * eased, rows[:, 2] - height
    turned = rows.copy()
    turned[:, 0] = along * np.cos(angle) - up * np.sin(angle)
    turned[:, 2] = along * np.sin(angle) + up * np.cos(angle) + height
    return turned


def fold(cells: int) -> np.ndarray:
    """Vertices (n, 3) of the towel folded three times; the third crease is at its largest x [m]."""
    points = towel.placed(cells, "two_folds") + np.array([0.0, 0.0, LIFT])
    pins = np.flatnonzero(points[:, 0] > points[:, 0].max() - 1e-9)
    height = LIFT + 3.5 * towel.PITCH
    sim = stark.Simulation(scene_of(points, cells, pins), time_step=STEP)
    while sim.time < FOLD + HOLD - 0.5 * STEP:
        share = min(1.0, (sim.time + STEP) / FOLD)
        sim["towel"].pin_targets = led_over(points[pins], height, share)
        sim.step()
    free = stark.Simulation(scene_of(sim["towel"].positions, cells), time_step=STEP)
    free.run_until(SETTLE)
    return free["towel"].positions


def main() -> None:
    cells = int(sys.argv[1]) if len(sys.argv) > 1 else 52
    points = fold(cells)
    path = towel.folded_file(cells)
    np.savez_compressed(path, positions=points.astype(np.float32), made_by=towel.recipe())
    print(f"{path}: {points[:, 2].max() * 1e3:.0f} mm high")


if __name__ == "__main__":
    main()
