"""What tests of the command share: a scene that falls freely, and ways to run the command."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from stark.cli import main

FALL = '''
"""A patch falls freely."""
import stark

until = 0.1

def settings():
    return {"time_step": 0.01, "contact.enabled": False}

def build():
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), stark.materials.cotton, name="patch")
    return scene, {"newton.max_iterations": 55}

def observables(sim):
    return {"z": sim["patch"].positions[:, 2].mean()}

def check(run):
    # Implicit Euler: z after n steps is -g h^2 n (n + 1) / 2; mass damping of 0.1/s takes off 0.4 % at most.
    z = run.positions("patch", -1)[:, 2].mean()
    assert abs(z + 9.81 * 0.01**2 * 55) < 0.01 * 0.054, f"fell to {z} m"
'''


def command(*words: object) -> int:
    """Runs the command in this process; returns its exit code."""
    return main([str(word) for word in words])


def environment() -> dict[str, str]:
    """Of a process that imports the same package."""
    source = str(Path(__file__).parents[3] / "python")
    paths = [p for p in sys.path if p]
    return {**os.environ, "PYTHONPATH": os.pathsep.join([*paths, source])}
