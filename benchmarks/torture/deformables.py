"""Soft things under force: squeezed, twisted, pinched; needle-thin triangles."""

from __future__ import annotations

import numpy as np

import stark

from .case import Case, Setup
from .shapes import slivers

D = 2e-4  # contact distance [m]


def squeeze(full: bool) -> Setup:
    """A block of rubber between plates, to 5 % of its height."""
    scene = stark.Scene()
    scene.default_friction = 0.3
    height, gap = 0.1, 3.9e-4
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3)
    scene.add_solid(stark.mesh.tet_box(height, 4 if full else 2), rubber, name="block")
    duration = 0.5
    for side, name in ((-1, "lower"), (1, "upper")):
        start = np.array([0.0, 0.0, side * (height / 2 + gap + 0.01)])
        end = np.array([0.0, 0.0, side * (0.05 * height / 2 + gap + 0.01)])
        plate = scene.add_box((0.6, 0.6, 0.02), motion="scripted", position=start, name=name)
        plate.follow(stark.motion.linear([0.0, duration], [start, end]))

    def flat(sim: stark.Simulation) -> str | None:
        extent = float(np.ptp(sim["block"].positions[:, 2]))
        return None if extent < 0.06 * height + 2 * gap else f"the block is {extent:.3g} m high still"

    return Setup(
        scene,
        until=duration,
        settings={"time_step": 0.01, "contact_distance": D, "gravity": (0, 0, 0)},
        check=flat,
        passive=False,
        most_iterations=2000,
    )


def twist(full: bool) -> Setup:
    """A strip of cloth whose ends are turned against each other, ten times in all; it coils up on itself."""
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.4, 0.1, (40, 10) if full else (24, 6))
    ends = np.abs(mesh.vertices[:, 0]) > 0.2 - 1e-6
    pins = np.flatnonzero(ends)
    cloth = stark.ShellMaterial(
        density=0.3, youngs_modulus=2e4, poissons_ratio=0.3, bending_stiffness=1e-6, strain_damping=1.0
    )
    sheet = scene.add_cloth(mesh, cloth.replace(mass_damping=2.0), name="cloth", pins=pins)
    turns, duration = 10.0, 2.0 if full else 1.0
    for side in (-1, 1):
        rate = side * np.pi * turns / duration  # half of the turns by each end
        mine = pins[side * mesh.vertices[pins, 0] > 0]
        # The ends come nearer, so that the coil finds cloth.
        sheet.follow(
            displacement=lambda t, s=side: (-s * 0.05 * t / duration, 0.0, 0.0),
            rotation=lambda t, r=rate: stark.rotation(axis="x", angle=r * t),
            center=(side * 0.2, 0.0, 0.0),
            vertices=mine,
        )
    return Setup(
        scene,
        until=duration,
        settings={"time_step": 0.01 if full else 5e-3, "contact_distance": 5e-4, "gravity": (0, 0, 0)},
        check=lambda sim: None if sim.time > 0.99 * duration else "it stopped early",
        balanced=False,
        passive=False,
        most_iterations=4000,
        most_retries=40,
        # Layers of a coil rub along each other in every step.
        searched=False,
        most_open=10**9,
    )


def pinch(full: bool, friction: float = 0.8) -> Setup:
    """Cloth that hangs between two fingers, which close on it and lift it; with little friction it slips
    out."""
    scene = stark.Scene()
    scene.default_friction = friction
    cells = 16 if full else 8
    upright = stark.rotation(axis="x", angle=90 * stark.deg)
    cloth = stark.materials.cotton.replace(mass_damping=0.0)
    scene.add_cloth(
        stark.mesh.grid(0.1, 0.1, cells), cloth, rotation=upright, position=(0, 0, -0.04), name="cloth"
    )
    closed, opened = 0.005 + (1.2 if friction > 0.5 else 1.9) * D, 0.005 + 2.5 * D
    lift = 0.1
    for side in (-1, 1):
        finger = scene.add_box((0.02, 0.01, 0.02), motion="scripted", position=(0, side * opened, 0))
        finger.follow(
            stark.motion.linear(
                [0.0, 0.02, 0.05, 0.35],
                [
                    (0, side * opened, 0),
                    (0, side * closed, 0),
                    (0, side * closed, 0),
                    (0, side * closed, lift),
                ],
            )
        )

    def where(sim: stark.Simulation) -> str | None:
        middle = float(sim["cloth"].positions[:, 2].mean())
        held = middle > -0.04 + 0.8 * lift
        if held == (friction > 0.5):
            return None
        return f"the cloth is at {middle:.3g} m: {'held' if held else 'lost'}"

    return Setup(
        scene,
        until=0.35,
        settings={"time_step": 5e-3, "contact_distance": D},
        check=where,
        passive=False,
        most_iterations=1000,
    )


def slivers_on_edge(full: bool) -> Setup:
    """A strip of triangles of 100 mm by 0.1 mm (small: 1.7 mm) on a disk of thin triangles, hit by another
    such disk."""
    scene = stark.Scene()
    count = 200 if full else 12
    strip = slivers(0.1, 0.02, count)
    cloth = stark.materials.cotton.replace(mass_damping=0.0)
    scene.add_cloth(strip, cloth, position=(0.0, 0.0, 0.003), self_contact=False, contact_distance=1e-5)
    scene.add_cylinder(0.03, 1e-3, segments=256 if full else 24, motion="fixed", position=(0, 0, -5e-4))
    scene.add_cylinder(
        0.02,
        2e-4,
        segments=128 if full else 20,
        density=2700.0,
        position=(0.005, 0.002, 0.006),
        velocity=(0, 0, -1.0),
    )
    return Setup(
        scene,
        until=0.1,
        settings={"time_step": 5e-3, "contact_distance": 1e-4},
        most_open=3,
        most_iterations=1500,
    )


CASES = [
    Case("squeeze", squeeze, slow=True),
    Case("twist", twist, slow=True),
    Case("pinch_holds", pinch),
    Case("pinch_slips", lambda full: pinch(full, friction=0.0)),
    Case("slivers", slivers_on_edge),
]
