"""A scene to look at."""

from __future__ import annotations

import socket
from typing import Any

import stark


def falling(name: str = "jelly") -> Any:
    """A ball above a block of jelly on a floor."""
    scene = stark.Scene(name)
    scene.default_friction = 0.4
    scene.add_floor(4.0)
    scene.add_solid(stark.mesh.tet_box((0.2, 0.2, 0.15), (2, 2, 2)), name="jelly", position=(0, 0, 0.077))
    scene.add_sphere(0.05, name="ball", mass=0.6, position=(0.0, 0, 0.206))
    return scene


def free_port() -> int:
    """A port that nobody has now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
