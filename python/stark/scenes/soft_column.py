"""Five soft boxes, one on the other, are pressed by a plate and let go."""

from collections.abc import Callable
from typing import Any

import numpy as np

import stark

from . import soft_column_6

until: float = 2.0  # [s]
build: Callable[[], stark.Scene] = soft_column_6.build
observables: Callable[[Any], dict[str, float]] = soft_column_6.observables
_PLATE = soft_column_6._PLATE
_DEPTH, _PERIOD = 0.1, 2.0  # of the plate's way [m] and of going down and up again [s]


def settings() -> dict[str, object]:
    return {"time_step": 1.0 / 60.0, "contact_distance": 0.0005}


def drive(sim: Any) -> None:
    phase = (sim.time + sim.time_step) / _PERIOD
    sim["plate"].position = (0.0, 0.0, _PLATE - 0.5 * _DEPTH * (1.0 - np.cos(2.0 * np.pi * phase)))


def check(run: Any) -> None:
    cubes = [entry.name for entry in run.bodies if entry.name.startswith("cube")]
    middle = run.nearest(1.0)
    for index in (middle, len(run) - 1):
        points = np.concatenate([run.positions(name, index) for name in cubes])
        plate = run.positions("plate", index)
        assert np.isfinite(points).all(), "positions are not finite"
        assert points[:, 2].min() > 0.0, "a cube went into the floor"
        assert points[:, 2].max() < plate[:, 2].min(), "a cube went into the plate"
    pressed = np.concatenate([run.positions(name, middle) for name in cubes])
    assert pressed[:, 2].max() < 0.44, "the plate did not press the column down"
