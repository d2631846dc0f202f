"""A towel of 57 x 101 vertices, folded three times, is closed and squeezed by a press: eight layers.

It starts folded twice, in four layers, which are bent over for the third fold on an arc; a plate comes down,
closes the arc and presses the layers together. All lengths at the start are those of the flat towel but for
the arc, where layers inside and outside of its middle are up to a tenth shorter and longer.

    stark bench benchmarks/scenes/towel_press.py [--option cells=24]
"""

from __future__ import annotations

from typing import Any

import numpy as np

import stark
from stark.scenes._common import bench_settings, heights

until: float = 0.45  # [s]
options: dict[str, Any] = {"cells": 100}  # along the towel; 57 x 101 vertices
LENGTH, WIDTH, MASS, LAYERS = 1.35, 0.75, 0.484, 4  # [m], [m], [kg]
THICKNESS = stark.surfaces.terry_towel.thickness  # contact distance of the towel [m]
PITCH, BEND = 1.02 * 2.0 * THICKNESS, 0.07  # of layers and radius of the middle of the bend [m]
#: Underside of the plate at the start, over the bend, and at the end, eight layers [m]; its speed [m/s].
TOP, PRESSED, SPEED = 2.0 * BEND + 5.0 * PITCH + 0.004, 8.0 * PITCH, 0.4
PLATE = 0.02  # its thickness [m]


def settings() -> dict[str, object]:
    return bench_settings(
        contact_distance=THICKNESS, **{"time_step": 0.01, "newton.residual_tolerance": 1e-4}
    )


def mesh() -> stark.TriangleMesh:
    """The flat towel, its length along y."""
    cells = options["cells"]
    return stark.mesh.grid(WIDTH, LENGTH, cells=(round(cells * WIDTH / LENGTH), cells))


def folded_twice() -> np.ndarray:
    """Vertices (n, 3) in four layers: rows are on a zigzag, each crease a step of the height of one pitch."""
    flat = mesh().vertices
    cells = options["cells"]
    row = np.rint((flat[:, 1] / LENGTH + 0.5) * cells).astype(int)
    layer = np.minimum(np.arange(cells + 1) * LAYERS // cells, LAYERS - 1)
    height = (layer + 0.5) * PITCH
    rise = np.diff(height)
    along = np.sqrt((LENGTH / cells) ** 2 - rise**2) * np.where(layer[1:] % 2 == 0, 1.0, -1.0)
    y = np.concatenate([[0.0], np.cumsum(along)])
    return np.column_stack([flat[:, 0], y[row] - 0.5 * np.ptp(y), height[row]])


def bent_over() -> np.ndarray:
    """The four layers bent over to themselves about a line along y; the lower half lies on the floor."""
    x, y, z = folded_twice().T
    middle, arc = 0.5 * LAYERS * PITCH, np.pi * BEND
    start = -0.5 * arc  # where the bend begins, in the middle of the width
    angle = np.clip((x - start) / BEND, 0.0, np.pi)
    over = np.clip(x - start - arc, 0.0, None)  # along the upper half
    radius = BEND + middle - z
    return np.column_stack(
        [
            np.minimum(x, start) + radius * np.sin(angle) - over,
            y,
            BEND + middle - radius * np.cos(angle) + 1.02 * THICKNESS,
        ]
    )


def build() -> stark.Scene:
    scene = stark.Scene()
    floor = scene.add_box((2.0, 2.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    towel = scene.add_cloth(
        mesh(), stark.materials.towel, name="towel", mass=MASS, initial_positions=bent_over(),
        surface=stark.surfaces.terry_towel, friction=0.4,
    )  # fmt: skip
    place = (0.0, 0.0, TOP + 0.5 * PLATE)
    press = scene.add_box((0.8, 0.8, PLATE), name="press", position=place, motion="scripted")
    scene.friction[towel, floor] = 1.0
    scene.friction[towel, press] = 0.4
    return scene


def drive(sim: Any) -> None:
    under = max(PRESSED, TOP - SPEED * (sim.time + sim.time_step))
    sim["press"].position = (0.0, 0.0, under + 0.5 * PLATE)


def observables(sim: Any) -> dict[str, float]:
    """Heights of the vertices, size seen from above [m], forces of press and floor, weight [N]."""
    towel = sim["towel"]
    points = towel.positions
    return {
        **heights(points),
        "length": float(np.ptp(points[:, 0])),
        "width": float(np.ptp(points[:, 1])),
        "press_force": -float(sim.contacts.of("towel", "press").forces.sum(axis=0)[2]),
        "floor_force": float(sim.contacts.of("towel", "floor").forces.sum(axis=0)[2]),
        "weight": 9.81 * float(towel.mass),
        "press_height": float(sim["press"].position[2]) - 0.5 * PLATE,
    }
