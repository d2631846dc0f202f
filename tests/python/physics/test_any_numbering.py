"""Numbers of vertices and elements mean nothing, and neither does what is far away."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from _worlds import Floats, roof

import stark

SETTINGS = {"newton.step_tolerance": 1e-8, "newton.acceleration_tolerance": 1e-6, "contact.distance": 1e-3}
TURNS = [[0, 1, 2, 3], [1, 2, 0, 3], [3, 1, 0, 2]]  # of the corners of a tetrahedron, without a mirror


def renumbered(mesh: Any, seed: int | None) -> tuple[Any, Floats]:
    """The same shape, and the new number of each vertex."""
    new = np.arange(len(mesh.vertices))
    if seed is None:
        return mesh, new
    rng = np.random.default_rng(seed)
    new = rng.permutation(new)
    x = np.empty_like(mesh.vertices)
    x[new] = mesh.vertices
    if isinstance(mesh, stark.mesh.TriangleMesh):
        rows = rng.permutation(new[mesh.triangles])
        return stark.mesh.TriangleMesh(x, [np.roll(row, rng.integers(3)) for row in rows]), new
    rows = rng.permutation(new[mesh.elements])
    if isinstance(mesh, stark.mesh.TetMesh):
        return stark.mesh.TetMesh(x, [row[TURNS[rng.integers(3)]] for row in rows]), new
    return type(mesh)(x, rows), new


def pressed(kind: str, seed: int | None) -> Floats:
    """Held at one side, pressed on its surface."""
    scene = stark.Scene()
    solids = {
        "tet4": stark.mesh.tet_box(0.1, 2),
        "tet10": stark.mesh.to_quadratic(stark.mesh.tet_box(0.1, 2)),
        "hex8": stark.mesh.box_hexahedra(0.1, 2),
        "hex27": stark.mesh.to_quadratic(stark.mesh.box_hexahedra(0.1, 2)),
    }
    given = solids.get(kind) or roof()
    mesh, new = renumbered(given, seed)
    held = new[given.vertices[:, 1] < given.vertices[:, 1].min() + 1e-9]
    if kind in solids:
        rubber = stark.SolidMaterial(
            density=1000.0, youngs_modulus=3e4, strain_limit=0.1, strain_damping=20.0
        )
        body = scene.add_solid(mesh, rubber, pins=held)
    else:
        cotton = stark.materials.cotton.replace(bending_stiffness=1e-4)
        materials = {
            "hinges": cotton,
            "creases": cotton.replace(yield_stress=2e3, bending_yield_moment=1e-5),
            "plates": stark.materials.plate(
                youngs_modulus=1e8, poissons_ratio=0.3, thickness=5e-4, density=1e3
            ),
        }
        body = scene.add_cloth(mesh, materials[kind], rest_angles="mesh", pins=held)
    scene.add_face_pressure(body, 5.0 if kind not in solids else 200.0)
    return run(scene, [lambda: body.positions[new]], 6)[0]


def run(scene: stark.Scene, readings: list[Callable[[], Floats]], steps: int) -> list[Floats]:
    sim = stark.Simulation(scene, settings=SETTINGS, time_step=0.01)
    for _ in range(steps):
        report = sim.step()
        assert not report.failed, report.message
    return [seen() for seen in readings]


KINDS = ["hinges", "creases", "plates", "tet4", "tet10", "hex8", "hex27"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_with_other_numbers_goes_the_same_way(kind: str) -> None:
    here = pressed(kind, None)
    for seed in (1, 2):
        assert np.abs(pressed(kind, seed) - here).max() < 1e-9


def lamp(scene: stark.Scene, x: float) -> Callable[[], Floats]:
    """A ball that drops on a sheet, and a bar on a driven hinge."""
    scene.default_friction = 0.0
    sheet = scene.add_cloth(
        stark.mesh.grid(0.3, 0.3, 5), pins=[0, 5, 30, 35], position=(x, 0, 0), self_contact=False
    )
    ball = scene.add_sphere(0.05, subdivisions=2, mass=0.1, position=(x, 0, 0.06))
    bar = scene.add_box((0.3, 0.05, 0.05), mass=1.0, position=(x + 0.65, 0, 0))
    hinge = scene.add_hinge(None, bar, (x + 0.5, 0, 0), (0, 1, 0.3))
    hinge.add_motor(1.0, cap=2.0, delta=0.1)
    return lambda: np.concatenate([sheet.positions, [ball.position, bar.position]]) - (x, 0, 0)


def test_bodies_far_apart_go_as_each_alone() -> None:
    alone = stark.Scene()
    (here,) = run(alone, [lamp(alone, 0.0)], 12)
    scene = stark.Scene()
    for there in run(scene, [lamp(scene, 4.0 * k) for k in range(3)], 12):
        assert np.abs(there - here).max() < 1e-9
