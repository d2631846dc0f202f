"""A scene to export."""

from __future__ import annotations

from typing import Any

import stark


def falling() -> Any:
    """A block of jelly and a turning box above a floor."""
    scene = stark.Scene("fall")
    scene.add_floor(1.0)
    scene.add_solid(stark.mesh.tet_box(0.1, 2), name="soft/jelly", position=(0, 0, 0.06))
    scene.add_box(0.05, name="box", mass=0.1, position=(0.0, 0.0, 0.2), angular_velocity=(1.0, 2.0, 3.0))
    return stark.Simulation(scene, time_step=0.01)
