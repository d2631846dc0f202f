"""Closed shells that hold bodies: hollow rigid ones, bags of cloth, boxes with walls, soft shells, thrown,
shaken or still. What is inside stays inside."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stark

from .case import Setup
from .random_scenes import Description, Source
from .random_world import add_thing, distance_of, draw_thing, draw_world, rotation_of, setup_of

Floats = NDArray[np.float64]

SHELLS = ("box", "sphere", "tetrahedron", "bag", "bag", "walls", "soft_walls")
#: For which a step may fail, as in random_impacts.
_CAUSES = ("detour", "crushing_load")
#: Cells of the room (over its half width), one thing in each.
_CELLS = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]


def draw_containers(source: Source) -> Description:
    first, stride = source.whole(0, 7), (1, 3, 5)[source.whole(0, 2)]
    return {
        **draw_world(source),
        "shell": SHELLS[source.whole(0, len(SHELLS) - 1)],
        "motion": ("dynamic", "dynamic", "dynamic", "scripted", "fixed")[source.whole(0, 4)],
        "wall": source.number(-2.0, -0.5),  # thickness over the half width
        "density": source.number(1.0, 4.0),
        "stiffness": source.number(4.0, 9.0),
        "speed": source.number(-1.0, 2.0) if source.whole(0, 1) else None,  # [m/s]
        "spin": source.number(-1.0, 2.0) if source.whole(0, 2) == 0 else None,  # [rad/s]
        "aim": [source.number(-1.0, 1.0) for _ in range(3)],
        "turn": [source.number(-1.0, 1.0) for _ in range(3)] if source.whole(0, 1) else [0.0] * 3,
        "things": [
            {
                **draw_thing(source),
                "cell": (first + stride * k) % len(_CELLS),
                "speed": source.number(-1.0, 3.0) if source.whole(0, 2) else None,
                "aim": [source.number(-1.0, 1.0) for _ in range(3)],
                "nested": source.whole(0, 5) == 0,
            }
            for k in range(source.whole(1, 3))
        ],
        "floor": bool(source.whole(0, 1)),
    }


def build_containers(d: Description) -> Setup:
    size, distance = 0.5 * 10.0 ** d["scale"], distance_of(d)
    scene, turn = stark.Scene(), rotation_of(d["turn"])
    shell, room = _add_shell(scene, d, size, turn)
    width = size * (0.3 if d["shell"] == "tetrahedron" else 0.5 if d["shell"] == "sphere" else 0.9)
    radius = 0.4 * width - 2.5 * distance
    held = []
    for thing in d["things"]:
        at = turn @ (width * np.array(_CELLS[thing["cell"]]))
        velocity = np.zeros(3)
        if thing["speed"] is not None:
            velocity = 10.0 ** thing["speed"] * np.array(thing["aim"])
        if thing["nested"]:  # a hollow ball around it
            ball = stark.mesh.sphere(radius, subdivisions=1)
            around = scene.add_rigid(
                ball, hollow=True, mass=_mass(thing, radius), position=at, velocity=velocity
            )
            held.append((around, shell, room))
            inner = add_thing(scene, thing, 0.6 * radius, position=at)
            held.append((inner, around, np.asarray(ball.triangles)))
        else:
            held.append((add_thing(scene, thing, radius, position=at, velocity=velocity), shell, room))
    if d["floor"]:
        scene.add_floor(40.0 * size, height=-5.5 * size)
    still = d["motion"] == "fixed" or d["shell"] in ("bag", "soft_walls") or d["motion"] == "dynamic"
    # A shell that is moved presses what is in it against its walls and the floor.
    causes = (*_CAUSES, "blocked_motion") if d["motion"] == "scripted" else _CAUSES
    return setup_of(scene, d, passive=still, watch=staying(held), causes=causes)


def _mass(thing: Description, radius: float) -> float:
    return float(0.1 * 10.0 ** thing["density"] * radius**3)


def _add_shell(scene: stark.Scene, d: Description, size: float, turn: Floats) -> tuple[Any, Any]:
    """The container, and the triangles that bound its room."""
    velocity, spin = np.zeros(3), np.zeros(3)
    if d["speed"] is not None:
        velocity = 10.0 ** d["speed"] * np.array(d["aim"])
    if d["spin"] is not None:
        spin = 10.0 ** d["spin"] * np.array(d["aim"])
    place: dict[str, Any] = {
        "rotation": turn,
        "velocity": velocity,
        "angular_velocity": spin,
        "name": "shell",
    }
    density = 10.0 ** d["density"]
    if d["shell"] in ("bag", "soft_walls"):
        place["angular_velocity"] = 0.1 * spin
        return _add_soft_shell(scene, d, size, density, place)
    mesh = _walls(size, d["wall"]) if d["shell"] == "walls" else _surface(d["shell"], size)
    room = np.asarray(mesh.triangles)
    room = room[len(room) // 2 :] if d["shell"] == "walls" else room
    if d["motion"] == "dynamic":
        place["mass"] = 0.2 * density * size**3
    else:
        place["motion"] = d["motion"]
    if d["motion"] == "fixed":
        place.pop("velocity"), place.pop("angular_velocity")
    return scene.add_rigid(mesh, hollow=d["shell"] != "walls", **place), room


def _surface(kind: str, size: float) -> stark.TriangleMesh:
    if kind == "box":
        return stark.mesh.box(2.0 * size)
    if kind == "sphere":
        return stark.mesh.sphere(size, subdivisions=1)
    corners = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    return stark.mesh.oriented(stark.TriangleMesh(size * corners, faces))


def _walls(size: float, wall: float) -> stark.TriangleMesh:
    """A box with a room in it; the second half of the triangles bounds the room."""
    outer, inner = stark.mesh.box(2.0 * size * (1.0 + 10.0**wall)), stark.mesh.box(2.0 * size)
    inwards = np.asarray(inner.triangles)[:, ::-1] + len(outer.vertices)
    return stark.TriangleMesh(
        np.concatenate([outer.vertices, inner.vertices]), np.concatenate([outer.triangles, inwards])
    )


def _add_soft_shell(
    scene: stark.Scene, d: Description, size: float, density: float, place: dict[str, Any]
) -> tuple[Any, Any]:
    modulus = 10.0 ** d["stiffness"]
    if d["shell"] == "bag":
        film = 0.02 * size
        shell = stark.ShellMaterial(
            density=density * film,
            youngs_modulus=modulus * film,
            poissons_ratio=0.3,
            bending_stiffness=0.1 * modulus * film**3,
        )
        mesh = stark.mesh.box(2.0 * size, 2)
        return scene.add_cloth(mesh, shell, rest_angles="mesh", **place), np.asarray(mesh.triangles)
    mesh, room = _hollow_block(size)
    material = stark.SolidMaterial(density=density, youngs_modulus=modulus, poissons_ratio=0.3)
    body = scene.add_solid(mesh, material, **place)
    return body, room


def _hollow_block(size: float) -> tuple[Any, Any]:
    """A block of tetrahedra, four cells wide, without those in the middle, and the triangles of its room."""
    block = stark.mesh.tet_box(4.0 * size, 4)
    centres = block.vertices[block.tets].mean(axis=1)
    kept = block.tets[(np.abs(centres) > size).any(axis=1)]
    used, tets = np.unique(kept, return_inverse=True)
    mesh = stark.TetMesh(block.vertices[used], tets.reshape(-1, 4))
    faces = np.sort(
        np.concatenate([mesh.tets[:, list(c)] for c in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))])
    )
    rows, count = np.unique(faces, axis=0, return_counts=True)
    border = rows[count == 1]
    room = border[(np.abs(mesh.vertices[border]) < 1.01 * size).all(axis=(1, 2))]
    # Turned outwards, as a surface of what is inside.
    a, b, c = (mesh.vertices[room[:, k]] for k in range(3))
    wrong = (np.cross(b - a, c - a) * (a + b + c)).sum(axis=1) < 0.0
    room[wrong] = room[wrong][:, ::-1]
    return mesh, room


def staying(held: list[tuple[Any, Any, Any]]) -> Callable[[stark.Simulation], str | None]:
    """A watch: bodies have their surfaces in the room that triangles of another body bound. Nodes inside of
    solids have no contact: where elements are inverted, they may be anywhere."""

    def watch(sim: stark.Simulation) -> str | None:
        for body, shell, room in held:
            number = winding(sim[body].surface_positions, sim[shell].positions[room])
            if not (np.abs(np.abs(number) - 1.0) < 0.4).all():
                return f"'{body.name}' is not inside of '{shell.name}' any more"
        return None

    return watch


def winding(points: Floats, corners: Floats) -> Floats:
    """Numbers of a closed surface (m, 3, 3) about points (n, 3) [van Oosterom and Strackee 1983]."""
    a, b, c = (corners[None, :, k] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    above = (a * np.cross(b, c)).sum(axis=2)
    below = la * lb * lc + (a * b).sum(axis=2) * lc + (b * c).sum(axis=2) * la + (c * a).sum(axis=2) * lb
    return np.asarray(np.arctan2(above, below).sum(axis=1) / (2.0 * np.pi))
