"""27 rigid boxes in three layers settle on a floor and stay standing."""

from typing import Any

import numpy as np

import stark

until: float = 2.0  # [s]
_SIZE, _GAP = 0.1, 0.004  # [m]


def settings() -> dict[str, object]:
    return {"time_step": 1.0 / 60.0, "contact_distance": 0.0005}


def build() -> stark.Scene:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_box((2.0, 2.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    for k in range(27):
        ix, iy, iz = k % 3, (k // 3) % 3, k // 9
        pitch = _SIZE + _GAP
        position = (pitch * (ix - 1), pitch * (iy - 1), 0.5 * _SIZE + _GAP + pitch * iz)
        scene.add_box(_SIZE, name=f"box_{k:02d}", density=500.0, position=position)
    return scene


def check(run: Any) -> None:
    boxes = [entry.name for entry in run.bodies if entry.name != "floor"]
    first = np.array([run.positions(name, 0).mean(axis=0) for name in boxes])
    last = np.array([run.positions(name, -1).mean(axis=0) for name in boxes])
    assert np.isfinite(last).all(), "positions are not finite"
    assert np.abs(last[:, :2] - first[:, :2]).max() < 0.01, "a box slid or fell off the stack"
    # Each layer rests on the one below; gaps are between zero and the contact distances of both (1 mm).
    for layer in range(3):
        z = last[9 * layer : 9 * layer + 9, 2]
        low = 0.5 * _SIZE + layer * _SIZE
        assert z.min() > low and z.max() < low + 1e-3 * (layer + 1), (
            f"layer {layer} is at {z.min():.5f}-{z.max():.5f} m"
        )
