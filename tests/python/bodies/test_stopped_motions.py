"""``follow()`` ends a motion also where the step that was to take it failed: none goes on to its target."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark


def down(t: float) -> tuple[float, float, float]:
    return (0.0, 0.0, -20.0 * t)


def turning(t: float) -> Any:
    return stark.rotation(axis="x", angle=10.0 * t)


def box(scene: stark.Scene) -> Any:
    scene.add_box(0.02, mass=1.0, position=(0, 0, 0.03), name="in between")
    body = scene.add_box(0.1, motion="scripted", position=(0, 0, 0.1))
    body.follow(position=lambda t: np.add((0, 0, 0.1), down(t)), rotation=turning)
    return body


def cloth(scene: stark.Scene) -> Any:
    body = scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), position=(0, 0, 0.1), pins=range(9))
    body.follow(displacement=down)
    return body


def rod(scene: stark.Scene) -> Any:
    line = stark.mesh.polyline((-0.1, 0, 0.1), (0.1, 0, 0.1), 4)
    body = scene.add_rod(
        line, stark.RodMaterial(density=1000.0, youngs_modulus=1e6, radius=2e-3), clamps=[0, 1, 2, 3, 4]
    )
    body.follow(displacement=down, rotation=turning)
    return body


@pytest.mark.parametrize("add", [box, cloth, rod])
def test_what_followed_a_motion_into_a_wall_stays(add: Callable[[stark.Scene], Any]) -> None:
    scene = stark.Scene()
    scene.add_box((1.0, 1.0, 0.02), motion="fixed", name="wall")
    body = add(scene)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), time_step=0.01, settings={"time.min_step": 0.005})
    before = np.array(body.vertices.positions if add is box else body.positions)
    assert sim.step().failed
    body.follow()
    for _ in range(3):
        report = sim.step()
        assert not report.failed, report.message
    assert np.array_equal(body.vertices.positions if add is box else body.positions, before)
    if add is rod:
        np.testing.assert_allclose(
            body.frames[0], sim.scene._core.initial_frames(body._index).reshape(-1, 3, 3)[0]
        )
