"""fold_towel: folds the towel of the robot experiments a third time, by simulation.

What it shows: an attachment to a bar that moves by a script, let go in mid-run; layers of cloth with
friction. The towel lies folded twice, in four layers; one of its sides is led over to the other on half a
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
MIDDLE = LIFT + 3.5 * towel.PITCH  # height at which the halves meet [m]


def scene_of(points: np.ndarray, cells: int) -> stark.Scene:
    """The towel with its vertices at ``points`` on a floor; a bar that touches nothing holds one side."""
    scene = stark.Scene()
    floor = scene.add_box((2.0, 2.0, 0.1), motion="fixed", position=(0.0, 0.0, -0.05), name="floor")
    cloth = scene.add_cloth(
        towel.mesh(cells), stark.materials.towel, name="towel", mass=towel.MASS, initial_positions=points,
        surface=stark.surfaces.terry_towel, friction=0.4,
    )  # fmt: skip
    scene.friction[cloth, floor] = 1.0
    side = np.flatnonzero(points[:, 0] > points[:, 0].max() - 1e-9)
    place = led_over(points[side][0, 0], 0.0)[0]
    bar = scene.add_box(0.01, motion="scripted", position=place, name="bar")
    for other in (cloth, floor):
        scene.disable_contact(bar, other)
    scene.attach(cloth.vertices[side], bar)
    return scene


def led_over(start: float, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Position and rotation of the bar after a share of its way, from x = ``start`` [m]: turned about the
    middle of the towel at the height where the halves meet, on a circle that gets smaller by ``SLACK``."""
    eased = share * share * (3.0 - 2.0 * share)
    angle, along = np.pi * eased, start - SLACK * eased
    place = np.array([along * np.cos(angle), 0.0, along * np.sin(angle) + MIDDLE])
    return place, stark.rotation(axis=(0.0, -1.0, 0.0), angle=angle)


def fold(cells: int) -> np.ndarray:
    """Vertices (n, 3) of the towel folded three times; the third crease is at its largest x [m]."""
    points = towel.placed(cells, "two_folds") + np.array([0.0, 0.0, LIFT])
    sim = stark.Simulation(scene_of(points, cells), time_step=STEP)
    while sim.time < FOLD + HOLD - 0.5 * STEP:
        share = min(1.0, (sim.time + STEP) / FOLD)
        sim["bar"].position, sim["bar"].rotation = led_over(points[:, 0].max(), share)
        sim.step()
    # In the same simulation: layers that a new one found pressed together would stay so, as thin as they are.
    sim.attachments[0].enabled = False
    sim.run_until(sim.time + SETTLE)
    return sim["towel"].positions


def main() -> None:
    cells = int(sys.argv[1]) if len(sys.argv) > 1 else 52
    points = fold(cells)
    path = towel.folded_file(cells)
    np.savez_compressed(path, positions=points.astype(np.float32), made_by=towel.recipe())
    print(f"{path}: {points[:, 2].max() * 1e3:.0f} mm high")


if __name__ == "__main__":
    main()
