"""A 0.4 m cotton cloth falls over a turning box and folds; friction takes it along."""

from typing import Any

import numpy as np

import stark

from ._common import no_nans, spinning_box, spinning_box_observables, turn_box

until: float = 10.0  # [s]
drive = turn_box
observables = spinning_box_observables


def settings() -> dict[str, object]:
    return {"time_step": 1.0 / 30.0, "contact_distance": 0.0025}


def build() -> stark.Scene:
    return spinning_box(cells=32, friction=0.3)


def check(run: Any) -> None:
    box, cloth = run.positions("box", -1), no_nans(run, "cloth")
    turned = np.linalg.norm(box[:, :2], axis=1)
    assert np.allclose(turned, turned[0], atol=1e-5), "the box must only turn about z"
    # Folds may swing together below the box, whose bottom is at z = -0.12; at its height they are outside.
    column = cloth[(np.hypot(cloth[:, 0], cloth[:, 1]) < 0.03) & (cloth[:, 2] > -0.12)]
    assert len(column) > 0 and column[:, 2].min() > -0.04, "the cloth went through the top of the box"
    # Hanging cloth keeps its size: a corner is at most half a diagonal, plus the strain limit, below the
    # box's top.
    assert cloth[:, 2].min() > -0.04 - 1.15 * 0.2 * np.sqrt(2.0), "the cloth stretched or fell"
    assert cloth[:, 2].min() < -0.08, "the cloth did not come down around the box"
