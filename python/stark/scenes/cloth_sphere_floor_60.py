"""Comparison: a cotton cloth of 60 x 60 cells falls over a fixed sphere and a floor."""

from typing import Any

import stark

from ._common import bench_cotton, bench_settings, heights

until: float = 0.5  # [s]


def settings() -> dict[str, object]:
    return bench_settings(contact_distance=0.002)


def build() -> stark.Scene:
    scene = stark.Scene()
    cloth = scene.add_cloth(
        stark.mesh.grid(1.0, 1.0, cells=60), bench_cotton(), name="cloth", position=(0.01, 0.02, 0.53)
    )
    sphere = scene.add_sphere(0.25, subdivisions=3, name="sphere", position=(0.0, 0.0, 0.26), motion="fixed")
    floor = scene.add_box((4.0, 4.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    scene.friction[cloth, sphere] = 0.3
    scene.friction[cloth, floor] = 0.3
    scene.friction[cloth, cloth] = 0.0
    return scene


def observables(sim: Any) -> dict[str, float]:
    return heights(sim["cloth"].positions)
