"""Tight fits and interlocks: what can only move one way, or not at all."""

from __future__ import annotations

import numpy as np

import stark

from .case import Case, Setup
from .shapes import column_of_rings, linking_number, nut, overhand_knot, screw, total_curvature

D = 2e-4  # contact distance [m]


def peg_in_hole(full: bool, play: float = 2.0) -> Setup:
    """A peg in a hole that is larger by ``play`` contact distances on each side: with 2, as much as contact
    acts over, it touches as soon as it leaves the middle or tilts. It slides down to the bottom."""
    scene = stark.Scene()
    scene.default_friction = 0.0
    angle = np.linspace(0.0, 2.0 * np.pi, 32 if full else 12, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])

    def rings(radii: list[float], heights: list[float]) -> np.ndarray:
        return np.stack(
            [np.column_stack([r * ring, np.full(len(ring), z)]) for r, z in zip(radii, heights, strict=True)]
        )

    # Up the outside, in over the rim, down the wall of the hole to its bottom.
    block = column_of_rings(rings([0.05, 0.05, 0.02, 0.02], [-0.05, 0.0, 0.0, -0.04]), closed=False)
    scene.add_rigid(block, motion="fixed", name="block")
    length = 0.05
    # The flats of the polygons face each other; at the corners the gap is larger by 1 / cos(pi / n).
    radius = 0.02 - play * D / np.cos(np.pi / len(ring))
    peg = column_of_rings(rings([radius, radius], [0.0, length]), closed=False)
    scene.add_rigid(peg, density=7800.0, position=(2e-5, 1e-5, -0.002), name="peg")

    def at_the_bottom(sim: stark.Simulation) -> str | None:
        z = sim["peg"].positions[:, 2].min()
        return None if -0.04 < z < -0.04 + 2 * D else f"the peg is at z = {z:.4g} m, the bottom at -0.04 m"

    return Setup(scene, until=0.5, settings={"time_step": 5e-3, "contact_distance": D}, check=at_the_bottom)


def chain(full: bool) -> Setup:
    """Rings that hang in each other, dropped until the chain is taut: each pair stays linked."""
    scene = stark.Scene()
    count = 8 if full else 4
    major, minor = 0.02, 0.004
    mesh = stark.mesh.torus(major, minor, *((24, 10) if full else (12, 6)))
    step = 2.0 * (major - minor) - 6 * D
    for k in range(count):
        turn = stark.rotation(axis="x", angle=90.0 * stark.deg)
        if k % 2:
            turn = stark.rotation(axis="z", angle=90.0 * stark.deg) @ turn
        motion = {"motion": "fixed"} if k == 0 else {"density": 7800.0}
        scene.add_rigid(mesh, position=(0, 0, -0.8 * step * k), rotation=turn, name=f"link {k}", **motion)
    circle = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    core = major * np.column_stack([np.cos(circle), np.sin(circle), 0 * circle])

    def unlinked(sim: stark.Simulation) -> str | None:
        for k in range(count - 1):
            a, b = (_placed(sim[f"link {i}"], core) for i in (k, k + 1))
            if abs(abs(linking_number(a, b)) - 1.0) > 1e-6:
                return f"links {k} and {k + 1} came apart"
        return None

    return Setup(scene, until=0.5, settings={"time_step": 5e-3, "contact_distance": D}, watch=unlinked)


def _placed(body: stark.RigidBody, points: np.ndarray) -> np.ndarray:
    return body.position + points @ body.rotation.T


def nut_on_bolt(full: bool) -> Setup:
    """A nut on a steep thread of the same shape, 4 contact distances wider, without friction: it cannot fall,
    it screws itself down."""
    scene = stark.Scene()
    scene.default_friction = 0.0
    n = 32 if full else 20
    radius, depth, pitch = 0.01, 0.004, 0.04
    bolt = column_of_rings(screw(radius, depth, pitch, 0.08, n), closed=False)
    scene.add_rigid(bolt, motion="fixed", name="bolt")
    start = 0.05
    hole = screw(radius + 4 * D, depth, pitch, 0.01, n)
    turned = stark.rotation(axis="z", angle=2.0 * np.pi * start / pitch)
    scene.add_rigid(nut(hole, 0.018), density=7800.0, position=(0, 0, start), rotation=turned, name="nut")

    def screwed(sim: stark.Simulation) -> str | None:
        body = sim["nut"]
        drop = start - body.position[2]
        R = body.rotation @ turned.T
        angle = np.arctan2(R[1, 0], R[0, 0]) % (2.0 * np.pi)
        expected = -2.0 * np.pi * drop / pitch % (2.0 * np.pi)
        slack = abs((angle - expected + np.pi) % (2.0 * np.pi) - np.pi)
        if drop < 5e-3:
            return f"the nut sank by {drop:.3g} m only"
        # Play of the thread: 8 D across it, at a depth of 4 mm.
        return f"the nut is {slack:.3g} rad off the thread" if slack > 8 * D / depth else None

    return Setup(scene, until=0.15, settings={"time_step": 2e-3, "contact_distance": D}, check=screwed)


def knot(full: bool) -> Setup:
    """An overhand knot in a cord is pulled tight by its ends. By Fary and Milnor a knot has a total curvature
    of more than 4 pi, of which the way back over the pulled ends takes 2 pi."""
    scene = stark.Scene()
    points = overhand_knot(0.01, 160 if full else 80)
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    cord = stark.RodMaterial(
        density=1000.0, youngs_modulus=5e6, radius=1e-3, strain_damping=2e-3, mass_damping=2.0
    )
    last = len(points) - 1
    scene.default_friction = 0.2
    rod = scene.add_rod(points, cord, name="cord", pins=[0, last], rest_shape="straight")
    along = points[last] - points[0]
    apart = float(np.linalg.norm(along))
    along /= apart
    # Half of what the knot leaves of the cord, or most of it.
    reach = 0.5 * ((0.85 if full else 0.7) * length - apart)
    duration = 1.0 if full else 0.6
    pull = stark.motion.linear([0.0, duration], [[0.0, 0.0, 0.0], reach * along])
    rod.follow(displacement=pull, vertices=[last])
    back = stark.motion.linear([0.0, duration], [[0.0, 0.0, 0.0], -reach * along])
    rod.follow(displacement=back, vertices=[0])

    def untied(sim: stark.Simulation) -> str | None:
        turned = total_curvature(sim["cord"].positions)
        return None if turned > 2.0 * np.pi else f"total curvature is {turned:.3g} rad: the knot is gone"

    return Setup(
        scene,
        until=duration,
        settings={"time_step": 5e-3, "gravity": (0, 0, 0)},
        check=untied,
        watch=untied,
        balanced=False,
        passive=False,
        most_iterations=1500,
    )


CASES = [
    Case("peg_in_hole", peg_in_hole),
    Case("chain", chain),
    Case("nut_on_bolt", nut_on_bolt),
    Case("knot", knot, slow=True),
]
