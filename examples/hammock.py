"""hammock: a scanned rabbit, soft all through, falls into a hammock of cotton and comes to rest.

What it shows: a dirty scan becomes a solid by stark.mesh.solid_from_scan, a soft body on cloth that hangs by
pins, the pressure between them. The rabbit is bunny.obj of the package pybullet, a clean model of 453
vertices. No package has a raw scan of an animal, so this one is made: refined, with noise, holes, triangles
that are turned or do not share their vertices, and crumbs.
The check: the repair gives the volume of the clean model back; at rest the hammock carries the weight of the
rabbit and hangs clear of the floor; nothing creeps.

    python examples/hammock.py    leaves a recording and a picture in out/hammock
    stark run examples/hammock.py --option edge=0.02
                                  needs pip install 'stark-sim[examples]'
"""

import sys
from typing import Any

import numpy as np
import pictures
import running

import stark

until = 3.0  # [s]
# Edge of the tetrahedra [m], squares of cloth along the hammock, what the scanner gets wrong.
options: dict[str, Any] = {"edge": 0.016, "cells": 44, "seed": 1}
SIZE, SOFT, GRAVITY = 0.28, 6e4, 9.81  # length of the rabbit [m], Young's modulus [Pa]
LENGTH, WIDTH, SPAN, HEIGHT = 0.80, 0.46, 0.66, 0.40  # of the hammock [m]; of its ends above the floor [m]
NOISE, HOLES, CRUMBS = 2e-4, 12, 8  # of the scanner [m]
CLOTH = stark.materials.towel.replace(youngs_modulus=1e5, bending_stiffness=2e-4, mass_damping=4.0)
FUR, COTTON, WOOD = (0.80, 0.66, 0.52), (0.36, 0.52, 0.72), (0.62, 0.44, 0.28)


def settings():
    return {"time_step": 1.0 / 60.0, "contact_distance": 0.0005}


def rabbit():
    """The clean model, refined, about the origin with its feet down and its nose along x [m]."""
    coarse = stark.mesh.load(running.installed("pybullet_data", "pybullet_data") / "bunny.obj")
    assert isinstance(coarse, stark.mesh.TriangleMesh)
    import trimesh

    vertices, triangles = trimesh.remesh.subdivide_loop(coarse.vertices, coarse.triangles, iterations=2)
    vertices = vertices[:, [2, 0, 1]] * (SIZE / np.ptp(coarse.vertices[:, 2]))  # z of the file is forwards
    return stark.mesh.TriangleMesh(vertices, triangles.astype(np.int32)).centered()


def scan(model):
    """What a careless scanner makes of the model."""
    random = np.random.default_rng(options["seed"])
    vertices = model.vertices + random.normal(0.0, NOISE, model.vertices.shape)
    middles = vertices[model.triangles].mean(axis=1)
    seen = np.ones(len(middles), dtype=bool)
    for center in middles[random.integers(len(middles), size=HOLES)]:
        seen &= np.linalg.norm(middles - center, axis=1) > 0.004
    triangles = model.triangles[seen]
    turned = random.random(len(triangles)) < 0.01
    triangles[turned] = triangles[turned][:, ::-1]
    loose = random.random(len(triangles)) < 0.3  # have vertices of their own, at the same places
    soup = stark.mesh.TriangleMesh(
        vertices[triangles[loose]].reshape(-1, 3), np.arange(3 * loose.sum(), dtype=np.int32).reshape(-1, 3)
    )
    crumbs = [
        stark.mesh.sphere(0.002, 1).translated(random.uniform(-0.5, 0.5, 3) * SIZE + (0, 0, SIZE))
        for _ in range(CRUMBS)
    ]
    return stark.mesh.joined([stark.mesh.TriangleMesh(vertices, triangles[~loose]), soup, *crumbs])


def build():
    model = rabbit()
    solid = stark.mesh.solid_from_scan(scan(model), edge_length=options["edge"])
    print(solid.report)
    share = solid.surface.volume / model.volume
    # Flat triangles lie within the curved surface: less by the square of their edges.
    assert abs(share - 1.0) < 0.01 * (options["edge"] / 0.016) ** 2, (
        f"the repaired scan has {share:.4f} of the volume of the model"
    )
    scene = stark.Scene()
    scene.default_friction = 0.4
    add_hammock(scene)
    rubber = stark.materials.soft_rubber.replace(
        youngs_modulus=SOFT, poissons_ratio=0.4, strain_damping=200.0, mass_damping=1.0
    )
    scene.add_solid(
        solid.mesh, rubber, name="rabbit", position=(-0.03, 0.04, HEIGHT - 0.03),
        rotation=stark.rotation(axis="z", angle=-90 * stark.deg), color=FUR,
    )  # fmt: skip
    scene.add_floor(3.0)
    return scene


def add_hammock(scene):
    """A cloth that hangs by the pins of two rods, which stand on posts."""
    cells = (options["cells"], options["cells"] // 2)
    flat = stark.mesh.grid(LENGTH, WIDTH, cells=cells)
    s = flat.vertices[:, 0] / (0.5 * LENGTH)
    sag = np.sqrt(3.0 / 8.0 * SPAN * (LENGTH - SPAN))  # of a flat parabola of that length
    start = np.column_stack([0.5 * SPAN * s, flat.vertices[:, 1], sag * (s * s - 1.0)])
    ends = np.flatnonzero(np.abs(s) > 1.0 - 1e-9)
    scene.add_cloth(
        flat, CLOTH, name="hammock", initial_positions=start, position=(0, 0, HEIGHT), pins=ends,
        color=COTTON,
    )  # fmt: skip
    for side in (-1.0, 1.0):
        x = side * (0.5 * SPAN + 0.009)
        rod = stark.mesh.cylinder(0.008, WIDTH + 0.06, 24).rotated(
            stark.rotation(axis="x", angle=90 * stark.deg)
        )
        scene.add_rigid(rod, name=f"rod_{side:+.0f}", motion="fixed", position=(x, 0, HEIGHT), color=WOOD)
        for y in (-0.5 * WIDTH - 0.02, 0.5 * WIDTH + 0.02):
            post = stark.mesh.box((0.016, 0.016, HEIGHT - 0.01))
            at = (x, y, 0.5 * HEIGHT - 0.005)
            scene.add_rigid(post, name=f"post_{side:+.0f}_{y:+.2f}", motion="fixed", position=at, color=WOOD)
    scene.disable_contact("hammock", "rod_-1")
    scene.disable_contact("hammock", "rod_+1")


def measure(sim):
    """After every step: load of the hammock [N], largest pressure [Pa], heights [m], speed [m/s]."""
    body, cloth = sim["rabbit"], sim["hammock"]
    return {
        "load": body.contact_force[2],
        "weight": body.mass * GRAVITY,
        "pressure": body.contact_pressure("hammock").max(),
        "height": body.positions[:, 2].mean(),
        "lowest": min(body.positions[:, 2].min(), cloth.positions[:, 2].min()),
        "speed": np.linalg.norm(body.velocities, axis=1).max(),
    }


def check(run):
    running.assert_close(results(run))


def results(run):
    """What came out, what is expected and how far it may be off, by name, in SI units."""
    t = running.measured(run)
    rest = t["time"] > t["time"][-1] - 0.3
    weight = t["weight"][0]
    return {
        "load": (t["load"][rest].mean(), weight, 0.02 * weight),
        "clearance": (t["lowest"][rest].min(), 0.5 * HEIGHT, 0.4 * HEIGHT),
        "sway": (np.ptp(t["height"][rest]), 0.0, 0.002),
        "fastest": (
            t["speed"].max(),
            0.5 * np.sqrt(2.0 * GRAVITY * HEIGHT),
            0.5 * np.sqrt(2.0 * GRAVITY * HEIGHT),
        ),
    }


def draw(run, path):
    """At rest."""
    frame = run.frame(-1)
    shown = [pictures.part(body) for body in frame.bodies if body.name != "floor"]
    return pictures.compose(path, shown, azimuth=-112, elevation=26, height=600)


if __name__ == "__main__":
    sys.exit(running.main(__file__))
