"""Small scenes from numbers: a description is JSON, drawn from a seed here or by hypothesis in tests/torture,
and ``build`` makes the scene of it. Bodies start in cells of a grid, so that nothing intersects at time 0."""

from __future__ import annotations

import itertools
from typing import Any, Protocol

import numpy as np

import stark

from .case import Setup

Description = dict[str, Any]
KINDS = ("box", "sphere", "tetrahedron", "needle", "cloth", "soft_box", "soft_tetrahedron", "rod")
PLACES = tuple(itertools.product((-1, 0, 1), (-1, 0, 1), (0, 1)))  # cells of the grid
#: Radius of what is put into a cell, over the size of the cell.
_FILL = 0.48


class Source(Protocol):
    """Where numbers come from."""

    def number(self, low: float, high: float) -> float: ...
    def whole(self, low: int, high: int) -> int: ...


class Generator:
    """Numbers of a seed."""

    def __init__(self, *seed: int) -> None:
        self._rng = np.random.default_rng(seed)

    def number(self, low: float, high: float) -> float:
        return float(self._rng.uniform(low, high))

    def whole(self, low: int, high: int) -> int:
        return int(self._rng.integers(low, high, endpoint=True))


def draw(source: Source) -> Description:
    """All lengths of bodies are over the size of a cell, ``scale`` [m]; exponents are of ten."""
    count = source.whole(1, 5)
    first = source.whole(0, len(PLACES) - 1)
    stride = (1, 5, 7, 11)[source.whole(0, 3)]
    return {
        "scale": source.number(-2.5, 0.5),
        "contact_distance": source.number(-3.5, -1.5),
        "time_step": source.number(-3.0, -1.48),
        "steps": source.whole(4, 12),
        "friction": source.number(0.0, 1.0) if source.whole(0, 3) else 0.0,
        "bdf2": source.whole(0, 5) == 0,
        "ground": ("floor", "floor", "nothing", "plate", "tilted")[source.whole(0, 4)],
        "lid": ("nothing", "nothing", "nothing", "pressing", "turning")[source.whole(0, 4)],
        "lid_speed": source.number(-2.0, 0.7),
        "bodies": [
            _draw_body(source, PLACES[(first + stride * k) % len(PLACES)], lying=k == 0) for k in range(count)
        ],
    }


def _draw_body(source: Source, place: tuple[int, int, int], lying: bool) -> Description:
    return {
        "kind": KINDS[source.whole(0, len(KINDS) - 1)],
        "place": list(place),
        "size": source.number(0.3, 1.0),
        "flatness": [source.number(-1.5, 0.0) if source.whole(0, 1) else 0.0 for _ in range(2)],
        "cells": source.whole(1, 4),
        "turn": [source.number(-1.0, 1.0) for _ in range(4)] if source.whole(0, 2) else [0.0] * 3 + [1.0],
        "speed": source.number(-2.0, 1.7) if source.whole(0, 3) else None,
        "aim": [source.number(-1.0, 1.0) for _ in range(3)],
        "spin": source.number(-1.0, 2.5) if source.whole(0, 3) == 0 else None,
        "density": source.number(1.0, 4.0),
        "stiffness": source.number(0.0, 1.0),
        "poissons_ratio": source.number(0.0, 0.49),
        "damping": source.whole(0, 2) == 0,
        "strain_limit": source.whole(0, 4) == 0,
        "contact_distance": source.number(-0.7, 0.3) if source.whole(0, 3) == 0 else None,
        # Lies on the floor at this gap, over the distance at which the two act on each other.
        "gap": source.number(-8.0, 0.0) if lying and source.whole(0, 1) else None,
    }


def build(description: Description) -> Setup:
    """The scene of a description."""
    d = description
    cell = 10.0 ** d["scale"]
    distance = cell * 10.0 ** d["contact_distance"]
    scene = stark.Scene()
    scene.default_friction = d["friction"]
    top = 2.0 * cell
    passive = _add_surroundings(scene, d, cell, top)
    for body in d["bodies"]:
        _add_body(scene, body, d, cell, distance)
    step = 10.0 ** d["time_step"]
    settings: dict[str, Any] = {"time_step": step, "contact_distance": distance}
    settings |= {"time.integrator": "bdf2"} if d["bdf2"] else {}
    # A lid that comes down on what cannot give way must stop.
    return Setup(
        scene,
        until=step * d["steps"],
        settings=settings,
        balanced=not d["bdf2"],
        passive=passive and not d["bdf2"],
        most_iterations=10**9,
        most_retries=10**9,
        most_open=10**9,
    )


def _add_surroundings(scene: stark.Scene, d: Description, cell: float, top: float) -> bool:
    """Ground below z = 0, lid above ``top``. Returns whether nothing of it moves."""
    speed = cell * 10.0 ** d["lid_speed"]
    if d["ground"] == "plate":
        plate = stark.mesh.box((5 * cell, 5 * cell, 0.1 * cell))
        scene.add_rigid(
            plate, motion="scripted", position=(0, 0, -0.05 * cell), velocity=(speed, 0, 0), name="ground"
        )
    elif d["ground"] != "nothing":
        tilt = stark.rotation(axis="y", angle=-20 * stark.deg if d["ground"] == "tilted" else 0.0)
        # Only the part below the bodies is under them when it is tilted: it lies lower, then.
        low = -2.0 * cell if d["ground"] == "tilted" else 0.0
        scene.add_floor(8.0 * cell, height=low, rotation=tilt, name="ground")
    if d["lid"] != "nothing":
        size, spin = (4 * cell, 4 * cell, 0.1 * cell), (0.0, 0.0, 0.0)
        if d["lid"] == "turning":
            size, spin = (4 * cell, 0.1 * cell, 0.1 * cell), (0.0, 2.0 * speed / cell, 0.0)
        height = top + (2.2 * cell if d["lid"] == "turning" else 0.06 * cell)
        scene.add_box(
            size,
            motion="scripted",
            position=(0, 0, height),
            velocity=(0, 0, -speed),
            angular_velocity=spin,
            name="lid",
        )
    return d["lid"] == "nothing" and d["ground"] != "plate"


def _add_body(scene: stark.Scene, b: Description, d: Description, cell: float, distance: float) -> None:
    mesh = _mesh(b)
    turn = np.array(b["turn"])
    rotation = _matrix(turn / max(np.linalg.norm(turn), 1e-3)) if np.linalg.norm(turn) > 1e-3 else np.eye(3)
    reach = float(np.linalg.norm(mesh.vertices, axis=1).max())
    size = _FILL * b["size"] * cell / reach
    x, y, z = b["place"]
    position = cell * np.array([x, y, z + 0.5])
    own = distance * 10.0 ** b["contact_distance"] if b["contact_distance"] is not None else None
    if b["gap"] is not None and d["ground"] in ("floor", "plate"):
        low = float((size * mesh.vertices @ rotation.T)[:, 2].min())
        position[2] = -low + (distance + (own or distance)) * 10.0 ** b["gap"]
    velocity = np.zeros(3)
    if b["speed"] is not None:  # towards the middle, more or less
        aim = np.array([0.0, 0.0, 0.5 * cell]) - position + 0.7 * cell * np.array(b["aim"])
        velocity = 10.0 ** b["speed"] * aim / max(float(np.linalg.norm(aim)), 1e-6 * cell)
    spin = np.zeros(3)
    if b["spin"] is not None:
        spin = 10.0 ** b["spin"] * np.array(b["aim"])
    place = {
        "position": position,
        "rotation": rotation,
        "velocity": velocity,
        "angular_velocity": spin,
        "contact_distance": own,
    }
    _add(scene, b, mesh.scaled(size) if not isinstance(mesh, stark.mesh.Polyline) else None, size, place)


def _add(scene: stark.Scene, b: Description, mesh: Any, size: float, place: dict[str, Any]) -> None:
    density, s = 10.0 ** b["density"], b["stiffness"]
    limit = {"strain_limit": 0.1} if b["strain_limit"] else {}
    if b["kind"] == "cloth":
        modulus = 10.0 ** (3.0 + 5.0 * s)  # [Pa], 1 mm thick
        material = stark.ShellMaterial(
            density=1e-4 * density,
            youngs_modulus=modulus,
            poissons_ratio=b["poissons_ratio"],
            bending_stiffness=1e-9 * modulus,
            strain_damping=1e-5 * modulus if b["damping"] else 0.0,
            **limit,
        )
        scene.add_cloth(mesh, material, **place)
    elif b["kind"].startswith("soft"):
        modulus = 10.0 ** (3.5 + 6.0 * s)
        solid = stark.SolidMaterial(
            density=density,
            youngs_modulus=modulus,
            poissons_ratio=b["poissons_ratio"],
            strain_damping=1e-3 * modulus if b["damping"] else 0.0,
            **limit,
        )
        scene.add_solid(mesh, solid, **place)
    elif b["kind"] == "rod":
        points = _mesh(b).vertices * size
        segment = float(np.linalg.norm(points[1] - points[0]))
        rod = stark.RodMaterial(
            density=density,
            youngs_modulus=10.0 ** (5.0 + 6.0 * s),
            radius=0.1 * segment,
            strain_damping=1e-3 if b["damping"] else 0.0,
        )
        if place["contact_distance"] is not None:
            place["contact_distance"] = min(place["contact_distance"], 0.3 * segment)
        scene.add_rod(points, rod, **place)
    else:
        scene.add_rigid(mesh, density=density, **place)


def _mesh(b: Description) -> Any:
    """Of no particular size; ``flatness`` squeezes it along y and z."""
    n, squeeze = b["cells"], 10.0 ** np.array([0.0, *b["flatness"]])
    kind = b["kind"]
    if kind == "box":
        return stark.mesh.box(tuple(squeeze))
    if kind == "sphere":
        return stark.mesh.sphere(1.0, subdivisions=min(n - 1, 1))
    if kind == "cloth":
        return stark.mesh.grid(1.0, float(squeeze[1]), n)
    if kind == "soft_box":
        return stark.mesh.tet_box(tuple(squeeze), 1 if n < 4 else 2)
    if kind == "rod":
        return stark.mesh.polyline((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), 2 * n)
    corners = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
    corners = corners * (squeeze * (1.0, 1e-2, 1e-2) if kind == "needle" else squeeze)
    corners -= corners.mean(axis=0)
    if kind == "soft_tetrahedron":
        return stark.mesh.oriented(stark.TetMesh(corners, [[0, 1, 2, 3]]))
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    return stark.mesh.oriented(stark.TriangleMesh(corners, faces))


def _matrix(q: np.ndarray) -> np.ndarray:
    """Of a unit quaternion (w last)."""
    x, y, z, w = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
