"""500 rigid bodies of scanned and drawn meshes, 0.95 million triangles, fall into a bin.

The meshes are files of the package pybullet (``pip install 'stark-sim[examples]'``): a scanned rabbit,
frame, wheel, handlebar and rack of a bicycle, links of a robot arm, a shaft, a ring and an open box. None is
convex; frames, wheels and racks catch each other. ``meshes=made`` takes shapes of ``stark.mesh``
instead, which need no package. The bench takes the first collisions.

    stark bench benchmarks/scenes/rigid_pile_500.py [--option bodies=12] [--option meshes=made]
"""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from typing import Any

import numpy as np

import stark
from stark.scenes._common import bench_settings, heights

until: float = 0.1  # [s]
options: dict[str, Any] = {"bodies": 500, "meshes": "files"}
SIZE, PITCH = 0.12, 0.13  # diameter of the balls around the bodies and distance of their centres [m]
DENSITY, FRICTION, WALL, GAP = 1000.0, 0.4, 0.05, 0.01  # [kg/m^3], [1], [m], [m]
FILES = (
    "bunny.obj",
    "bicycle/files/handlebar_scaled.stl",
    "bicycle/files/frame_scaled.stl",
    "bicycle/files/wheel_scaled.stl",
    "bicycle/files/bike_rack.stl",
    "torus/torus_textured.obj",
    "differential/diff_leftshaft.stl",
    "kuka_iiwa/meshes/link_2.stl",
    "kuka_iiwa/meshes/link_5.stl",
    "toys/shape_sorter.obj",
)


def settings() -> dict[str, object]:
    return bench_settings(contact_distance=0.0005)


def meshes() -> list[stark.TriangleMesh]:
    """Closed surfaces, none of which intersects itself, in balls of diameter SIZE about the origin."""
    kind = options["meshes"]
    if kind == "made":
        found = [
            stark.mesh.torus(0.04, 0.012),
            stark.mesh.capsule(0.02, 0.06),
            stark.mesh.box((0.1, 0.05, 0.02)),
        ]
    elif kind == "files":
        package = importlib.util.find_spec("pybullet_data")
        if package is None or package.origin is None:
            raise ImportError(
                "rigid_pile_500 reads files of pybullet_data: pip install 'stark-sim[examples]'"
            )
        found = [stark.mesh.cleaned(stark.mesh.load(Path(package.origin).parent / file)) for file in FILES]
    else:
        raise stark.InvalidArgument(f"option meshes = '{kind}': must be 'files' or 'made'")
    return [_in_ball(mesh) for mesh in found]


def _in_ball(mesh: stark.TriangleMesh) -> stark.TriangleMesh:
    low, high = mesh.bounds
    centred = mesh.translated(-0.5 * (low + high))
    return centred.scaled(0.5 * SIZE / float(np.linalg.norm(centred.vertices, axis=1).max()))


def side() -> int:
    """Columns of the pile along x and along y."""
    return max(2, math.ceil(math.sqrt(options["bodies"] / 8)))


def build() -> stark.Scene:
    scene = stark.Scene()
    scene.default_friction = FRICTION
    shapes, n = meshes(), side()
    _add_bin(scene, n * PITCH + 2.0 * GAP, PITCH * math.ceil(options["bodies"] / n**2))
    for k in range(options["bodies"]):
        ix, iy, iz = k % n, (k // n) % n, k // n**2
        jitter = 0.001 * np.array([(5 * k) % 7 - 3, (3 * k) % 7 - 3, 0])
        place = PITCH * np.array([ix - 0.5 * (n - 1), iy - 0.5 * (n - 1), iz + 0.5]) + jitter
        axis = ((7 * k) % 11 - 5, (3 * k) % 13 - 6, (5 * k) % 17 - 7.5)
        turn = stark.rotation(axis=axis, angle=((37 * k) % 360) * stark.deg)
        mesh = shapes[(7 * k) % len(shapes)]
        scene.add_rigid(mesh, name=f"part_{k:03d}", density=DENSITY, position=place, rotation=turn)
    return scene


def _add_bin(scene: stark.Scene, inside: float, height: float) -> None:
    outside = inside + 2.0 * WALL
    scene.add_box((outside, outside, WALL), name="floor", position=(0, 0, -0.5 * WALL), motion="fixed")
    for axis, sign in ((0, -1), (0, 1), (1, -1), (1, 1)):
        place, size = [0.0, 0.0, 0.5 * height + 0.001], [inside - 0.002, inside - 0.002, height]
        place[axis], size[axis] = sign * 0.5 * (inside + WALL), WALL  # walls do not touch each other
        if axis == 0:
            size[1] = outside
        name = f"wall_{'xy'[axis]}{'-+'[sign > 0]}"
        scene.add_box(tuple(size), name=name, position=tuple(place), motion="fixed")


def observables(sim: Any) -> dict[str, float]:
    """Heights of the centres, farthest surface from the middle, mean speed and what the floor carries."""
    parts = [body for body in sim.bodies if body.motion == "dynamic"]
    speeds = np.linalg.norm([np.asarray(body.velocity) for body in parts], axis=1)
    surfaces = np.concatenate([body.positions for body in parts])
    floor = sim.contacts.of("floor").forces.sum(axis=0)[2]
    return {
        **heights(np.array([body.position for body in parts])),
        "lowest": float(surfaces[:, 2].min()),
        "farthest": float(np.abs(surfaces[:, :2]).max()),
        "speed_mean": float(speeds.mean()),
        "floor_force": abs(float(floor)),
        "weight": 9.81 * sum(float(body.mass) for body in parts),
    }
