"""What tests of studies share: a scene that falls freely and a plan of it."""

from __future__ import annotations

from pathlib import Path

FALL = '''
"""A box falls freely."""
import os
import time

import stark

until = 0.05
options = {"height": 1.0, "wait": 0.0, "die": "", "label": "a", "steps": 1, "bad": False}

def settings():
    return {"time_step": 0.01}

def build():
    scene = stark.Scene()
    if options["bad"]:
        raise ValueError("a bad scene")
    scene.add_box(0.1, mass=1.0, name="box", position=(0, 0, options["height"]))
    return scene

def drive(sim):
    time.sleep(options["wait"])
    # Dies once: the file says that it has been there.
    if options["die"] and sim.time > 0.025 and not os.path.exists(options["die"]):
        open(options["die"], "x").close()
        os.kill(os.getpid(), 9)

def measure(sim):
    return {"height": sim["box"].position[2]}

def observables(sim):
    return {"fallen": options["height"] - sim["box"].position[2]}
'''


def write_study(folder: Path, sampling: str, more: str = "") -> Path:
    """A scene file and a plan in ``folder``; ``more`` are lines at the top of the plan."""
    (folder / "fall.py").write_text(FALL)
    plan = folder / "plan.toml"
    plan.write_text(f'scene = "fall.py"\ncheckpoint_every = 0\n{more}\n{sampling}\n')
    return plan


def grid(**options: object) -> str:
    """The sampling of a grid."""
    lines = [f"{name} = {values}" for name, values in options.items()]
    return "\n".join(["[sampling]", 'kind = "grid"', "[sampling.options]", *lines])
