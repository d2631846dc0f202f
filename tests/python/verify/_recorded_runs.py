"""Recordings for the checker, and ways of tampering with them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import stark
from stark.recording import Recorder, chain
from stark.recording.chain import RowChain


def record(folder: Path, scene: stark.Scene, steps: int, **settings: Any) -> Path:
    """A recording for certification of some steps."""
    sim = stark.Simulation(scene, **settings)
    with Recorder(folder, sim, settings=sim.settings.to_dict(), scene=scene.name, certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for _ in range(steps):
            report = sim.step()
            assert not report.failed, report.message
            recorder.report(report)
            recorder.record_state(sim)
        recorder.record(sim)
    return folder


def reseal(folder: Path) -> None:
    """Computes all digests anew, as a forger would: what is found out then, is found out from the content."""
    manifest = json.loads((folder / "manifest.json").read_text())
    names = ["frames/topology.npz", *(f"states/{name}" for name in ("scene.json", "mesh.npz"))]
    seed = chain.seed(folder, [name for name in names if (folder / name).exists()])
    heads = {"frames": RowChain(seed, "frames"), "telemetry": RowChain(seed, "telemetry")}
    heads |= {"states": RowChain(seed, "states")} if "states" in manifest else {}
    for kind in ("frames", "states"):
        for path in sorted((folder / kind).glob("chunk_*.npz")):
            with np.load(path) as stored:
                arrays = {key: stored[key] for key in stored.files if key != "chain"}
            digests = [
                heads[kind].add_arrays({key: a[0 if len(a) == 1 else k] for key, a in arrays.items()})
                for k in range(len(arrays["times"]))
            ]
            np.savez(path, **arrays, chain=np.stack(digests))
    lines = [json.loads(line) for line in (folder / "telemetry.jsonl").read_text().splitlines()]
    texts = [
        heads["telemetry"].add_line(json.dumps({key: row[key] for key in row if key != "chain"}))
        for row in lines
    ]
    (folder / "telemetry.jsonl").write_text("".join(text + "\n" for text in texts))
    manifest["chain"] = {"version": 1, "seed": seed, "lines": len(lines)}
    manifest["chain"] |= {kind: head.head for kind, head in heads.items()}
    (folder / "manifest.json").write_text(json.dumps(chain.sealed(manifest)))


def edit_json(folder: Path, name: str, change: Callable[[Any], None]) -> None:
    """Changes a JSON file of a recording."""
    value = json.loads((folder / name).read_text())
    change(value)
    (folder / name).write_text(json.dumps(value))


def edit_states(
    folder: Path, name: str, change: Callable[[np.ndarray, np.ndarray], None], chunk: int = 0
) -> None:
    """Changes an array of a chunk of states in place, ``change(array, times)``, and the digests with it."""
    path = folder / f"states/chunk_{chunk:06d}.npz"
    with np.load(path) as stored:
        arrays = {key: stored[key] for key in stored.files}
    if len(arrays[name]) == 1:  # stored once because it does not change
        arrays[name] = np.repeat(arrays[name], len(arrays["times"]), axis=0)
    change(arrays[name], arrays["times"])
    np.savez(path, **arrays)
    reseal(folder)


def edit_rows(folder: Path, change: Callable[[list[dict[str, Any]]], None]) -> None:
    """Changes the telemetry, and the digests with it."""
    path = folder / "telemetry.jsonl"
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    change(rows)
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    reseal(folder)


def sheet_on_box() -> stark.Scene:
    """A sheet that falls on a fixed box, and a small cube beside it on a plate."""
    scene = stark.Scene("sheet_on_box")
    scene.add_box((0.1, 0.1, 0.1), name="box", motion="fixed", position=(0.0, 0.0, -0.06))
    scene.add_cloth(stark.mesh.grid(0.16, 0.16, cells=8), stark.materials.cotton, name="sheet")
    scene.add_box((0.6, 0.6, 0.02), name="plate", motion="fixed", position=(1.0, 0.0, 0.0))
    scene.add_box(0.04, name="cube", density=500.0, position=(1.0, 0.0, 0.04))
    return scene


def rods() -> stark.Scene:
    """Crossed cords that fall on a floor, one of them clamped at an end."""
    scene = stark.Scene("rods")
    scene.add_floor(1.0)
    for k in range(3):
        way = 0.1 * np.array([np.cos(k), np.sin(k), 0.0])
        mesh = stark.mesh.polyline(-way, way, 8)
        scene.add_rod(
            mesh, stark.materials.rubber_cord, name=f"rod_{k}", position=(0.0, 0.0, 0.02 + 0.015 * k)
        )
    mesh = stark.mesh.polyline((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), 6)
    scene.add_rod(mesh, stark.materials.rubber_cord, name="held", position=(0.3, 0.3, 0.1), clamps=[0])
    return scene


def mechanism() -> stark.Scene:
    """Joints of all kinds between rigid bodies, a patch of cloth, a rod and the world; attachments of all
    kinds."""
    scene = stark.Scene("mechanism")
    boxes = [
        scene.add_box(0.05, name=f"box_{k}", density=500.0, position=(0.1 * k, 0.0, 0.0)) for k in range(12)
    ]
    joints = [
        ("fixed", {}),
        ("ball", {}),
        ("hinge", {"axis": (0, 1, 0)}),
        ("slider", {"axis": (1, 0, -1)}),
        ("cylindrical", {"axis": (0, 1, -1)}),
        ("universal", {"axis": (1, 0, 0)}),
        ("planar", {"axis": (1, 0, 1)}),
        ("point_on_axis", {"axis": (1, 1, -1)}),
        ("direction", {"axis": (0, 0, 1)}),
        ("orientation", {}),
    ]
    for k, (kind, options) in enumerate(joints):
        scene.add_joint(kind, None, boxes[k], anchor=(0.1 * k - 0.02, 0.02, 0.03), name=kind, **options)
    scene.add_distance(None, boxes[10], anchor_a=(1.0, 0.2, 0.1), anchor_b=(1.0, 0.0, 0.0), name="distance")
    scene.add_span(boxes[10], boxes[11], (1.0, 0.0, 0.0), (1.1, 0.0, 0.0))
    grid = stark.mesh.grid(0.1, 0.1, cells=4)
    cloth = scene.add_cloth(grid, stark.materials.cotton, name="cloth", position=(0.0, 0.5, 0.0))
    scene.attach(cloth.vertices[[0, 1]], None)
    holder = scene.add_box(0.02, name="holder", motion="scripted", position=(0.063, 0.5, 0.0))
    scene.attach(cloth, holder, distance=0.0035)
    patch = scene.add_cloth(grid, stark.materials.cotton, name="patch", position=(0.0, 0.5, 0.004))
    scene.attach(patch.vertices[[6, 12, 18]], cloth)
    weight = scene.add_box(0.02, name="weight", density=500.0, position=(0.0, 0.5, -0.05))
    scene.add_ball(cloth.frame((6, 7, 12)), weight, name="on_patch")
    mesh = stark.mesh.polyline((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), 5)
    rod = scene.add_rod(mesh, stark.materials.rubber_cord, name="rod", position=(0.0, 1.0, 0.0), clamps=[0])
    bob = scene.add_box(0.02, name="bob", density=500.0, position=(0.12, 1.0, 0.0))
    scene.add_hinge(rod.frame(-1), bob, name="on_rod")
    return scene
