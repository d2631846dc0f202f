"""A cotton cloth of 60 x 60 cells drapes over a sphere and reaches the floor."""

from typing import Any

import numpy as np

import stark

from ._common import heights, no_nans

until: float = 2.0  # [s]
_RADIUS, _HEIGHT = 0.25, 0.26  # of the sphere and its centre [m]


def settings() -> dict[str, object]:
    return {"time_step": 1.0 / 60.0, "contact_distance": 0.002}


def build() -> stark.Scene:
    scene = stark.Scene()
    cloth = scene.add_cloth(
        stark.mesh.grid(1.0, 1.0, cells=60), stark.materials.cotton, name="cloth", position=(0.01, 0.02, 0.53)
    )
    sphere = scene.add_sphere(
        _RADIUS, subdivisions=3, name="sphere", position=(0.0, 0.0, _HEIGHT), motion="fixed"
    )
    floor = scene.add_box((4.0, 4.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    scene.friction[cloth, sphere] = 0.3
    scene.friction[cloth, floor] = 0.3
    scene.friction[cloth, cloth] = 0.2
    return scene


def observables(sim: Any) -> dict[str, float]:
    return heights(sim["cloth"].positions)


def check(run: Any) -> None:
    cloth = no_nans(run, "cloth")
    # The facets of the sphere lie at most 1 % inside its radius.
    distance = np.linalg.norm(cloth - [0.0, 0.0, _HEIGHT], axis=1)
    assert distance.min() > 0.985 * _RADIUS, "the cloth went into the sphere"
    assert cloth[:, 2].min() > 0.0, "the cloth went into the floor"
    assert cloth[:, 2].max() > _HEIGHT + 0.97 * _RADIUS, "the cloth slid off the sphere"
    assert cloth[:, 2].min() < 0.01, "the corners did not reach the floor"
