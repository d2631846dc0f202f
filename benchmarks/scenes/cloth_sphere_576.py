"""A cotton cloth of 576 x 576 cells, 998,787 unknowns, falls on a fixed sphere; two steps.

It is cloth_sphere_floor_60 at ten times the resolution along each side, from where it is about to touch.

    stark bench benchmarks/scenes/cloth_sphere_576.py [--option cells=24]
"""

from __future__ import annotations

from typing import Any

import numpy as np

import stark
from stark.scenes._common import BENCH_STEP, bench_cotton, bench_settings, heights

until: float = 2 * BENCH_STEP  # [s]
options: dict[str, Any] = {"cells": 576}
SIDE, RADIUS, GAP, SPEED = 1.0, 0.25, 0.003, 0.2  # [m], [m], [m], downwards at the start [m/s]


def settings() -> dict[str, object]:
    # A quarter of a cell, but no more than a tenth of the sphere's radius.
    return bench_settings(contact_distance=0.25 * SIDE / options["cells"])


def build() -> stark.Scene:
    scene = stark.Scene()
    mesh = stark.mesh.grid(SIDE, SIDE, cells=options["cells"])
    cloth = scene.add_cloth(
        mesh, bench_cotton(), name="cloth", position=(0.01, 0.02, RADIUS + GAP), velocity=(0.0, 0.0, -SPEED)
    )
    sphere = scene.add_sphere(RADIUS, subdivisions=4, name="sphere", motion="fixed")
    scene.friction[cloth, sphere] = 0.3
    scene.friction[cloth, cloth] = 0.0
    return scene


def observables(sim: Any) -> dict[str, float]:
    """Heights of the vertices and of a corner, least distance of a vertex from the sphere's centre, force on
    the sphere."""
    points = sim["cloth"].positions
    return {
        **heights(points),
        "z_corner": float(points[0, 2]),
        "radius_min": float(np.linalg.norm(points, axis=1).min()),
        "sphere_force": abs(float(sim.contacts.of("cloth", "sphere").forces.sum(axis=0)[2])),
    }
