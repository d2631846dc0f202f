"""Scenes and energies that several tests of formulas share."""

from __future__ import annotations

import numpy as np

import stark

NO_GRAVITY = {"gravity": (0.0, 0.0, 0.0)}


@stark.energy
def spring(e: stark.Edge, stiffness: float = stark.parameter(10.0, unit="N/m", min=0.0)):
    """Spring between the ends of an edge."""
    return 0.5 * stiffness * (e.length - e.rest_length) ** 2


@stark.energy
def anchor(p: stark.Point, target: stark.Vec3, stiffness: float = stark.parameter(10.0, unit="N/m", min=0.0)):
    """Spring of rest length zero to a place in the world."""
    d = p.x - target
    return 0.5 * stiffness * (d @ d)


@stark.energy
def tie(a: stark.Point, b: stark.Point, stiffness: float = stark.parameter(10.0, unit="N/m", min=0.0)):
    """Spring of rest length zero between two points."""
    d = a.x - b.x
    return 0.5 * stiffness * (d @ d)


def sheet(cells: int = 4, **options: object) -> tuple[stark.Scene, stark.Cloth]:
    """A scene with a square cloth of 0.4 m about the origin."""
    scene = stark.Scene()
    return scene, scene.add_cloth(stark.mesh.grid(0.4, 0.4, cells=cells), name="sheet", **options)


def sheet_and_box(cells: int = 4, **options: object) -> tuple[stark.Scene, stark.Cloth, stark.RigidBody]:
    """The cloth with a free box 0.3 m below."""
    scene, cloth = sheet(cells, **options)
    return scene, cloth, scene.add_box(size=0.08, position=(0.02, -0.01, -0.3), density=500.0, name="box")


def cloth_masses(cloth: stark.Cloth) -> np.ndarray:
    """Lumped masses of the vertices (n,) [kg]: a third of each triangle."""
    X = cloth.mesh.vertices[cloth.triangles]
    areas = 0.5 * np.linalg.norm(np.cross(X[:, 1] - X[:, 0], X[:, 2] - X[:, 0]), axis=1)
    return (
        np.bincount(cloth.triangles.reshape(-1), np.repeat(areas / 3.0, 3)) * stark.materials.cotton.density
    )
