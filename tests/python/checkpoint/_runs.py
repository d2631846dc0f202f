"""A scene file for tests of resuming, and what a recording holds apart from the clock."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

SCENE = '''
"""A box swings on a hinge with a controller that has a memory and random numbers."""

import numpy as np

import stark

until = 0.4  # [s]
options = {"mass": 1.0, "fail_at": 9.0}
memory = {"integral": 0.0, "rng": None, "history": np.zeros(3)}


def settings():
    return {"time_step": 0.01, "contact.enabled": False}


def build():
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=options["mass"], position=(0.3, 0.0, 0.0), name="box")
    hinge = scene.add_hinge(None, box, anchor=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    hinge.add_effort(0.0, name="push")
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), position=(0.0, 1.0, 0.0), name="cloth", pins=[0])
    return scene


def drive(sim):
    rng = np.random.default_rng(7)
    if memory["rng"] is not None:
        rng.bit_generator.state = memory["rng"]
    memory["integral"] *= 0.9
    memory["integral"] += float(np.linalg.norm(sim.joints[0].reaction.force)) + rng.normal()
    memory["history"] = np.append(memory["history"][1:], memory["integral"])
    memory["rng"] = rng.bit_generator.state
    sim.actuators[0].target = 0.02 * float(memory["history"].mean())
    if sim.time > options["fail_at"]:
        raise ArithmeticError("the controller gave up")


def measure(sim):
    return {"integral": memory["integral"]}


def observables(sim):
    return {"z": float(sim["box"].position[2])}


def check(run):
    assert run.telemetry["measured.integral"][-1] > 0.0
'''


def write_scene(folder: Path, name: str = "swing.py", **replaced: str) -> Path:
    """The scene as a file; ``replaced``: texts in place of those in capitals, for variants."""
    path = folder / name
    text = SCENE
    for old, new in replaced.items():
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path


def content(folder: Path) -> dict[str, Any]:
    """All that a run folder holds, without seconds of the clock on the wall and dates, and without digests
    that depend on them."""
    parts = [
        p for name in ("frames", "states") if (folder / name).exists() for p in (folder / name).iterdir()
    ]
    frames = {f"{p.parent.name}/{p.name}": p.read_bytes() for p in sorted(parts)}
    rows = [json.loads(line) for line in (folder / "telemetry.jsonl").read_text().splitlines()]
    for row in rows:
        del row["wall"], row["phases"], row["chain"]
    manifest = json.loads((folder / "manifest.json").read_text())
    for name in ("created", "resumed"):
        del manifest[name]
    manifest["summary"].pop("wall", None)
    del manifest["chain"]["telemetry"], manifest["chain"]["manifest"]
    return {"frames": frames, "telemetry": rows, "manifest": manifest}
