"""Comparison: 27 rigid cubes of 1 kg fall into a pile on a fixed floor."""

from typing import Any

import numpy as np

import stark

from ._common import bench_settings, heights

until: float = 2.0  # [s]


def settings() -> dict[str, object]:
    return bench_settings(contact_distance=0.001)


def build() -> stark.Scene:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_box((4.0, 4.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    for k in range(27):
        ix, iy, iz = k % 3, (k // 3) % 3, k // 9
        scene.add_box(
            0.1,
            name=f"cube_{k:02d}",
            mass=1.0,
            position=(
                0.135 * (ix - 1) + 0.004 * ((5 * k) % 7 - 3),
                0.135 * (iy - 1) + 0.004 * ((3 * k) % 7 - 3),
                0.06 + 0.13 * iz,
            ),
            rotation=stark.rotation(axis="z", angle=((37 * k) % 23 - 11) * stark.deg),
        )
    return scene


def observables(sim: Any) -> dict[str, float]:
    cubes = [b for b in sim.bodies if b.name != "floor"]
    centers = np.array([np.asarray(b.position) for b in cubes])
    speeds = np.linalg.norm([np.asarray(b.velocity) for b in cubes], axis=1)
    return {**heights(centers), "speed_max": float(speeds.max())}
