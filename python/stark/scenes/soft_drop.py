"""A soft cube of 20 x 20 x 20 cells falls on a floor, bounces and comes to rest."""

from collections.abc import Callable
from typing import Any

import stark

from . import soft_box_drop_20
from ._common import no_nans

until: float = 1.0  # [s]
build: Callable[[], stark.Scene] = soft_box_drop_20.build
observables: Callable[[Any], dict[str, float]] = soft_box_drop_20.observables


def settings() -> dict[str, object]:
    return {"time_step": 1.0 / 60.0, "contact_distance": 0.001}


def check(run: Any) -> None:
    cube = no_nans(run, "cube")
    assert cube[:, 2].min() > 0.0, "the cube went into the floor"
    assert cube[:, 2].min() < 0.01, "the cube does not lie on the floor"
    height = float(cube[:, 2].max() - cube[:, 2].min())
    assert 0.12 < height < 0.21, (
        f"the cube is {height:.3f} m high; it must sag under its weight but not collapse"
    )
