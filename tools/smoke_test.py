#!/usr/bin/env python3
"""Smoke test of an installed wheel: `python tools/smoke_test.py`, in an environment with the wheel alone.

A scene is recorded, certified and drawn, and a formula is compiled, with no compiler on the path. Takes a few
seconds and exits with 1 at the first failure. --checkout also accepts a package that is not installed."""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import stark

ROOT = Path(__file__).resolve().parents[1]
TABLE, CUBE = 0.05, 0.06  # top of the table and size of the cube [m]

SCENE = f"""import stark

until = 0.4

def settings():
    return {{"time_step": 0.01, "contact_distance": 0.002}}

def build():
    scene = stark.Scene()
    scene.add_box((0.4, 0.4, 2 * {TABLE}), motion="fixed", name="table")
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, 10), position=(0, 0, {TABLE} + 0.01), name="cloth")
    scene.add_box({CUBE}, mass=0.1, position=(0, 0, {TABLE} + 0.02 + {CUBE} / 2), name="cube")
    return scene
"""


@stark.energy
def spring(p: stark.Point, target: stark.Vec3, stiffness: float = 10.0):
    d = p.x - target
    return 0.5 * stiffness * (d @ d)


def installation(checkout: bool = False) -> str:
    """The package is the installed one, with types and a version that agrees with its metadata."""
    place = Path(stark.__file__).resolve().parent
    if not checkout:
        assert not place.is_relative_to(ROOT), f"{place} is a checkout, not an installed wheel"
        version = importlib.metadata.version("stark-sim")
        assert version == stark.__version__, f"metadata say {version}, the core {stark.__version__}"
    for name in ("py.typed", "__init__.pyi", "_core/__init__.pyi"):
        assert (place / name).is_file(), f"the wheel has no {name}"
    return f"stark {stark.__version__} in {place}"


def command(folder: Path, *words: str) -> str:
    """Runs the command line in a folder, with a path on which there is no compiler."""
    environment = {**os.environ, "PATH": str(folder / "nothing")}
    # Of a checkout, the path may be relative to another folder.
    environment["PYTHONPATH"] = str(Path(stark.__file__).resolve().parents[1])
    done = subprocess.run(
        [sys.executable, "-m", "stark", *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"stark {' '.join(words)}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def recording(folder: Path) -> str:
    """A cube falls on a cloth on a table; at the end it lies there."""
    (folder / "scene.py").write_text(SCENE)
    command(folder, "run", "scene.py", "--certify", "--out", "run", "--quiet")
    run = stark.recording.Recording(folder / "run")
    height = run.positions("cube", -1)[:, 2].mean() - TABLE - CUBE / 2
    # Two contacts lie below it, each within the sum of two contact distances of 2 mm.
    assert 0.0 < height < 0.01, f"the cube is {height} m above the table"
    return f"{len(run)} frames, the cube lies {1e3 * height:.1f} mm above the table"


def certificate(folder: Path) -> str:
    """The recording is certified by the checker."""
    command(folder, "verify", "run", "--quiet")
    found = stark.verify.verify(folder / "run")
    assert found.verdict == "certified", found.text()
    return found.verdict


def picture(folder: Path) -> str:
    """The run left a picture that shows something, and a replay page."""
    pixels = stark.render.read_png(folder / "run/picture.png")
    colours = len(np.unique(pixels.reshape(-1, pixels.shape[-1]), axis=0))
    assert pixels.std() > 5.0 and colours > 50, "the picture is empty"
    page = folder / "run/replay.html"
    assert page.stat().st_size > 10_000, "the replay page is empty"
    return f"{pixels.shape[1]} x {pixels.shape[0]} pixels, {colours} colours"


def formula() -> str:
    """A formula of the user is differentiated and compiled in process: its force is the closed form."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2))
    pull = scene.add(spring(cloth.vertices, target=(0, 0, 1)))
    sim = stark.Simulation(scene)
    assert not sim.step().failed
    assert np.allclose(pull.forces[:, 0], 10.0 * (np.array([0, 0, 1]) - cloth.positions), rtol=1e-12)
    return "forces are those of the closed form"


def main(arguments: list[str]) -> int:
    """Runs all checks; returns the exit status."""
    checkout = "--checkout" in arguments
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        checks = {
            "installation": lambda: installation(checkout),
            "recording": lambda: recording(folder),
            "certificate": lambda: certificate(folder),
            "picture": lambda: picture(folder),
            "formula": formula,
        }
        for title, check in checks.items():
            try:
                print(f"{title}: {check()}")
            except AssertionError as error:
                print(f"{title}: FAILED: {error}")
                return 1
    print("smoke test: passed")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
