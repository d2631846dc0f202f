"""What an installed wheel must do, in seconds and with nothing but what it requires: simulate a scene with
contact and a formula of the user, record it, check the recording, make a picture.

    python tools/smoke_test.py

Run it outside of the source tree, or it tests that instead of the wheel."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import stark
from stark.render import render, write_png


@stark.energy
def spring(p: stark.Point, anchor: stark.Vec3, k: float = 10.0):
    """A spring of no length [N/m]."""
    return 0.5 * k * stark.squared_norm(p.x - anchor)


def build() -> tuple[stark.Scene, stark.Cloth, stark.RigidBody]:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_floor(2.0)
    cloth = scene.add_cloth(
        stark.mesh.grid(0.4, 0.4, cells=12), stark.materials.cotton, position=(0, 0, 0.15)
    )
    ball = scene.add_sphere(0.05, mass=0.1, position=(0, 0, 0.06))
    scene.add(spring(cloth.vertices[:1], anchor=(-0.2, -0.2, 0.2)))
    return scene, cloth, ball


def main() -> None:
    scene, cloth, ball = build()
    sim = stark.Simulation(scene, time_step=1 / 60)
    sim.run_until(0.5)
    assert 0.05 < ball.position[2] < 0.06, f"the ball is at {ball.position[2]} m"
    assert cloth.positions[:, 2].min() > 0.0, "the cloth went through the floor"
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "scene.png"
        write_png(picture, render(sim, 320, 180))
        assert picture.stat().st_size > 1000, "the picture is empty"
        run = Path(folder) / "run"
        command = [sys.executable, "-m", "stark"]
        subprocess.run(
            [*command, "run", "hello_cloth", "--until", "0.2", "--certify", "--out", str(run)], check=True
        )
        subprocess.run([*command, "verify", str(run)], check=True)
    print(f"stark {stark.__version__} works; NumPy {np.__version__}, Python {sys.version.split()[0]}")


if __name__ == "__main__":
    main()
