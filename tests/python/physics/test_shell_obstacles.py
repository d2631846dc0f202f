"""The obstacle course of shells: a roof under its weight, a cylinder and a hemisphere that are pinched."""

from __future__ import annotations

import numpy as np
import pytest
from _validation import validate

import stark

#: They are in units of their own.
pytestmark = pytest.mark.filterwarnings("ignore:.*(in cells of|has an extent|ordinary)")
SETTINGS = {"time.integrator": "quasistatic", "contact.enabled": False, "newton.step_tolerance": 1e-9}


def strip(u: np.ndarray, v: np.ndarray, closed: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parameters of the vertices and triangles of a grid, which is a ring in u where it is closed."""
    index = np.arange(len(u) * len(v)).reshape(len(u), len(v))
    a, b = index, np.roll(index, -1, axis=0)
    if not closed:
        a, b = a[:-1], b[:-1]
    cells = [(a[:, :-1], b[:, :-1], b[:, 1:]), (a[:, :-1], b[:, 1:], a[:, 1:])]
    faces = np.concatenate([np.stack([k.ravel() for k in cell], axis=1) for cell in cells])
    at_u, at_v = np.meshgrid(u, v, indexing="ij")
    return at_u.ravel(), at_v.ravel(), faces


def shell(scene: stark.Scene, points: list[np.ndarray], faces: np.ndarray, plate: tuple) -> stark.Cloth:
    """A shell of Young's modulus, Poisson's ratio and thickness, at rest in its shape, in metres."""
    modulus, ratio, thickness = plate
    skin = stark.ShellMaterial(
        density=1.0,
        thickness=thickness,
        youngs_modulus=modulus,
        poissons_ratio=ratio,
        flexural_rigidity=modulus * thickness**3 / 12.0 / (1.0 - ratio**2),
    )
    return scene.add_cloth(stark.TriangleMesh(np.column_stack(points), faces), skin, rest_angles="mesh")


def settled(scene: stark.Scene, cloth: stark.Cloth) -> np.ndarray:
    """Positions in equilibrium."""
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), settings=SETTINGS)
    assert not sim.step().failed
    return cloth.positions


def vertex(cloth: stark.Cloth, place: tuple[float, float, float]) -> int:
    return int(np.argmin(np.linalg.norm(cloth.mesh.vertices - place, axis=1)))


def test_a_roof_sags_under_its_weight() -> None:
    """Scordelis and Lo: R = 25, length 50, 80 degrees, end diaphragms, 90 per area, here a thousandth."""
    cells, radius, half = 48, 25.0, np.radians(40.0)
    u, v, faces = strip(np.linspace(-half, half, 2 * cells + 1), np.linspace(0, 50, 2 * cells + 1), False)
    scene = stark.Scene()
    roof = shell(scene, [radius * np.sin(u), v, radius * np.cos(u)], faces, (4.32e8, 0.0, 0.25))
    ends = (v < 1e-9) | (v > 50 - 1e-9)
    scene.add_rollers(roof.vertices[ends], "x")
    scene.add_rollers(roof.vertices[ends], "z")
    scene.add_rollers(roof.vertices[[vertex(roof, (0.0, 25.0, radius))]], "y")
    scene.add_traction(roof.faces, (0, 0, -0.09))
    edge = (radius * np.sin(half), 25.0, radius * np.cos(half))
    validate("obstacles.roof", 1e3 * (edge[2] - settled(scene, roof)[vertex(roof, edge), 2]))


def test_a_pinched_cylinder_gives_way() -> None:
    """R = 300, length 600, rigid end diaphragms, a unit force on each side."""
    cells, radius = 64, 300.0
    u, v, faces = strip(
        np.arange(4 * cells) * np.pi / 2.0 / cells, np.linspace(0, 600, 2 * cells + 1), closed=True
    )
    scene = stark.Scene()
    tube = shell(scene, [radius * np.sin(u), v, radius * np.cos(u)], faces, (3e6, 0.3, 3.0))
    ends = (v < 1e-9) | (v > 600 - 1e-9)
    scene.add_rollers(tube.vertices[ends], "x")
    scene.add_rollers(tube.vertices[ends], "z")
    scene.add_rollers(tube.vertices[abs(v - 300.0) < 1e-9], "y")
    top, bottom = vertex(tube, (0, 300.0, radius)), vertex(tube, (0, 300.0, -radius))
    scene.add_force(tube.vertices[[top, bottom]], [(0, 0, -1.0), (0, 0, 1.0)])
    validate("obstacles.cylinder", radius - settled(scene, tube)[top, 2])


def test_a_pinched_hemisphere_bends_without_stretch() -> None:
    """R = 10 with a hole of 18 degrees, two pairs of forces of 2 at its rim, here a hundredth."""
    cells, radius = 48, 10.0
    u, v, faces = strip(
        np.arange(4 * cells) * np.pi / 2.0 / cells, np.linspace(0, 0.4 * np.pi, cells + 1), closed=True
    )
    points = [radius * np.cos(v) * np.cos(u), radius * np.cos(v) * np.sin(u), radius * np.sin(v)]
    scene = stark.Scene()
    dome = shell(scene, points, faces, (6.825e7, 0.3, 0.04))
    rim = [vertex(dome, place) for place in ((10, 0, 0), (0, 10, 0), (-10, 0, 0), (0, -10, 0))]
    scene.add_force(dome.vertices[rim], [(0.02, 0, 0), (0, -0.02, 0), (-0.02, 0, 0), (0, 0.02, 0)])
    scene.add_rollers(dome.vertices[abs(points[1]) < 1e-9], "y")
    scene.add_rollers(dome.vertices[abs(points[0]) < 1e-9], "x")
    scene.add_rollers(dome.vertices[[rim[0]]], "z")
    validate("obstacles.hemisphere", 100.0 * (settled(scene, dome)[rim[0], 0] - radius))
