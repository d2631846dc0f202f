"""Comparison: a soft rubber cube of 20 x 20 x 20 cells falls on a fixed floor."""

from typing import Any

import stark

from ._common import bench_settings, heights

until: float = 0.5  # [s]


def settings() -> dict[str, object]:
    return bench_settings(contact_distance=0.001)


def build() -> stark.Scene:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_solid(
        stark.mesh.tet_box(0.2, cells=20), stark.materials.soft_rubber, name="cube", position=(0.0, 0.0, 0.13)
    )
    scene.add_box((4.0, 4.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    return scene


def observables(sim: Any) -> dict[str, float]:
    return heights(sim["cube"].positions)
