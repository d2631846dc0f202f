"""creases: sheets and wires that are bent and let go. Those that yield stay bent, elastic ones spring back.

python examples/creases.py      simulates, checks itself, writes the picture out/creases.png
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pictures

import stark

LENGTH, WIDTH, CELLS = 0.12, 0.06, 8  # [m] of a sheet
RADIUS, BENT = 0.5e-3, 2.0  # [m] of the wires, [rad] that they are bent by
FOLD = 2.4  # [rad] that the sheets are folded by
CARD = stark.ShellMaterial(
    density=0.2, thickness=3e-4, youngs_modulus=2e7, bending_stiffness=2e-4, bending_yield_moment=0.02
)
WIRE = stark.materials.steel_wire.replace(radius=RADIUS, yield_stress=4e8, hardening_modulus=5e9)
SHEETS = {"card": CARD, "elastic sheet": CARD.replace(bending_yield_moment=np.inf)}
WIRES = {"wire": WIRE, "elastic wire": WIRE.replace(yield_stress=np.inf, hardening_modulus=0.0)}


def add_sheet(scene: stark.Scene, name: str, material: stark.ShellMaterial, y: float) -> None:
    """A sheet that is pinned left of its middle; a hand has the right half."""
    mesh = stark.mesh.grid(LENGTH, WIDTH, cells=(2 * CELLS, CELLS))
    x = np.asarray(mesh.vertices)[:, 0]
    sheet = scene.add_cloth(mesh, material, pins=np.flatnonzero(x < 1e-6), name=name, position=(0, y, 0))
    hand = scene.add_box(0.01, motion="scripted", name=f"hand of the {name}", position=(0, y, 0))
    scene.attach(sheet.vertices[np.flatnonzero(x > 1e-6)], hand)


def add_wire(scene: stark.Scene, name: str, material: stark.RodMaterial, y: float) -> None:
    """A wire along x that is clamped at one end; a hand has the other one."""
    path = stark.mesh.polyline((0, y, 0), (LENGTH, y, 0), 24)
    wire = scene.add_rod(path, material, clamps=[0], name=name)
    hand = scene.add_box(0.01, motion="scripted", name=f"hand of the {name}", position=(LENGTH, y, 0))
    scene.add_fixed(wire.frame(-1), hand)


def bend(sim: stark.Simulation, part: float) -> None:
    """Hands on their ways: sheets are folded about the middle, wires bent to arcs."""
    for name in SHEETS:
        sim[f"hand of the {name}"].rotation = stark.rotation(axis="y", angle=-part * FOLD)
    for name in WIRES:
        hand, angle = sim[f"hand of the {name}"], part * BENT
        y = hand.position[1]
        hand.position = LENGTH / angle * np.array([np.sin(angle), 0.0, 1.0 - np.cos(angle)]) + [0.0, y, 0.0]
        hand.rotation = stark.rotation(axis="y", angle=-angle)


def angles(sim: stark.Simulation) -> dict[str, float]:
    """By how much each is bent [rad]."""
    found = {}
    for name in SHEETS:
        x = sim[name].positions
        far = x[np.argmax(np.hypot(x[:, 0], x[:, 2]) * (sim[name].mesh.vertices[:, 0] > 0))]
        found[name] = float(np.arctan2(far[2], far[0]))
    for name in WIRES:
        d3 = sim[name].frames[-1, :, 2]
        found[name] = float(np.arctan2(d3[2], d3[0]))
    return found


def run() -> tuple[stark.Simulation, dict[str, float]]:
    scene = stark.Scene("creases")
    for k, (name, card) in enumerate(SHEETS.items()):
        add_sheet(scene, name, card, 0.09 * k)
    for k, (name, wire) in enumerate(WIRES.items()):
        add_wire(scene, name, wire, 0.16 + 0.03 * k)
    options: dict[str, Any] = {"contact.enabled": False, "time.integrator": "quasistatic"}
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **options)
    for part in np.linspace(0.0, 1.0, 13)[1:]:
        bend(sim, part)
        sim.step()
    for glue in sim.attachments:
        glue.enabled = False
    for joint in sim.joints:
        joint.enabled = False
    sim.step()
    return sim, angles(sim)


def main() -> None:
    sim, left = run()
    for name, angle in left.items():
        print(f"{name}: {np.degrees(angle):.1f} degrees are left")
    # A fold opens by the yield moment over the stiffness of its hinges, 3 k |e|^2/(A_a + A_b).
    edge = LENGTH / 2 / CELLS
    opened = CARD.bending_yield_moment * edge / (3.0 * CARD.bending_stiffness)
    section = WIRE.section
    bent = BENT / LENGTH  # the curvature in the hand
    moment, stiffness = section["yield_moment_1"], section["bending_stiffness_1"]
    hardening = section["yield_hardening"] * moment**2
    plastic = (stiffness * bent - moment) / (stiffness + hardening)
    assert abs(left["card"] - (FOLD - opened)) < 0.02 * FOLD
    assert abs(left["wire"] - plastic * LENGTH) < 0.02 * BENT
    assert abs(left["elastic sheet"]) < 1e-3
    assert abs(left["elastic wire"]) < 1e-3
    names, colors = (*SHEETS, *WIRES), 2 * (pictures.RED, pictures.BLUE)
    bodies = [pictures.snapshot(sim[name], color=c) for name, c in zip(names, colors, strict=True)]
    path = pictures.save("creases", bodies, azimuth=-50, elevation=25)
    print(f"check: passed, picture {path}")


if __name__ == "__main__":
    main()
