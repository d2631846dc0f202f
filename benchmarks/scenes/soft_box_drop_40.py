"""A soft rubber cube of 40 x 40 x 40 cells, 398,763 unknowns, hits a fixed floor; three steps.

It is soft_box_drop_20 at twice the resolution, from where it is about to touch.

    stark bench benchmarks/scenes/soft_box_drop_40.py [--option cells=6]
"""

from __future__ import annotations

from typing import Any

import stark
from stark.scenes._common import BENCH_STEP, bench_settings, heights

until: float = 3 * BENCH_STEP  # [s]
options: dict[str, Any] = {"cells": 40}
SIZE, GAP, SPEED = 0.2, 0.005, 0.7  # [m], [m], downwards at the start [m/s]


def settings() -> dict[str, object]:
    return bench_settings(contact_distance=0.0005)


def build() -> stark.Scene:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_solid(
        stark.mesh.tet_box(SIZE, cells=options["cells"]),
        stark.materials.soft_rubber,
        name="cube",
        position=(0.0, 0.0, 0.5 * SIZE + GAP),
        velocity=(0.0, 0.0, -SPEED),
    )
    scene.add_box((4.0, 4.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    return scene


def observables(sim: Any) -> dict[str, float]:
    """Heights of the nodes, how wide the cube is at its foot, what the floor carries and the weight [N]."""
    cube = sim["cube"]
    points = cube.positions
    return {
        **heights(points),
        "width": float(points[:, 0].max() - points[:, 0].min()),
        "floor_force": float(sim.contacts.of("cube", "floor").forces.sum(axis=0)[2]),
        "weight": 9.81 * float(cube.mass),
    }
