"""Comparison: five soft cubes of 6 x 6 x 6 cells, one on the other, pressed by a plate."""

from typing import Any

import numpy as np

import stark

from ._common import bench_settings, heights

until: float = 1.0  # [s]
_SPEED = -0.1  # of the plate along z [m/s]
#: Height of the plate's centre at the start [m]: over the top of the highest cube, a gap of twice 1.5 mm.
_PLATE = 0.0515 + 4 * 0.1015 + 0.05 + 0.003 + 0.01


def settings() -> dict[str, object]:
    return bench_settings(contact_distance=0.0005)


def build() -> stark.Scene:
    scene = stark.Scene()
    scene.default_friction = 0.5
    rubber = stark.materials.soft_rubber.replace(youngs_modulus=1e5)
    for i in range(5):
        scene.add_solid(
            stark.mesh.tet_box(0.1, cells=6),
            rubber,
            name=f"cube_{i}",
            position=(0.002 * (i % 2), 0.001 * (i % 3), 0.0515 + 0.1015 * i),
        )
    scene.add_box((4.0, 4.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    scene.add_box((0.2, 0.2, 0.02), name="plate", position=(0.0, 0.0, _PLATE), motion="scripted")
    return scene


def drive(sim: Any) -> None:
    sim["plate"].position = (0.0, 0.0, _PLATE + _SPEED * (sim.time + sim.time_step))


def observables(sim: Any) -> dict[str, float]:
    points = np.concatenate([b.positions for b in sim.bodies if b.name.startswith("cube")])
    return {
        **heights(points),
        "x_abs_max": float(np.abs(points[:, 0]).max()),
        "y_abs_max": float(np.abs(points[:, 1]).max()),
        "plate_z": float(sim["plate"].position[2]),
    }
