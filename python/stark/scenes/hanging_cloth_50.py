"""Comparison: a cotton cloth of 50 x 50 cells hangs by two corners, without contact."""

from typing import Any

import numpy as np

import stark

from ._common import bench_cotton, bench_settings, heights

until: float = 3.0  # [s]


def settings() -> dict[str, object]:
    return bench_settings(**{"contact.enabled": False})


def build() -> stark.Scene:
    scene = stark.Scene()
    mesh = stark.mesh.grid(1.0, 1.0, cells=50)
    cloth = scene.add_cloth(mesh, bench_cotton(), name="cloth")
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    cloth.pin(np.flatnonzero((np.abs(np.abs(x) - 0.5) < 1e-9) & (np.abs(y - 0.5) < 1e-9)))
    return scene


def observables(sim: Any) -> dict[str, float]:
    return heights(sim["cloth"].positions)
