"""What calculations stumble over: exact symmetry, parallel and collinear edges, gaps of next to nothing,
motions that cannot be."""

from __future__ import annotations

from typing import Any

import numpy as np

import stark

from .case import Case, Setup

D = 5e-4  # contact distance [m]
RUBBER = stark.SolidMaterial(density=1000.0, youngs_modulus=2e5, poissons_ratio=0.3)
FABRIC = stark.ShellMaterial(density=0.5, youngs_modulus=1e5, bending_stiffness=1e-5)
CORD = stark.RodMaterial(density=1000.0, youngs_modulus=1e8, radius=5e-4)


def _tetrahedron(size: float) -> stark.TriangleMesh:
    """With its tip down at z = 0."""
    angle = np.radians([90.0, 210.0, 330.0])
    top = np.column_stack([0.6 * np.cos(angle), 0.6 * np.sin(angle), np.ones(3)])
    vertices = size * np.concatenate([[[0.0, 0.0, 0.0]], top])
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    return stark.mesh.oriented(stark.TriangleMesh(vertices, faces))


def exact_drops(full: bool) -> Setup:
    """Tips that fall exactly on vertices, edges and faces of a floor of tiles; faces that fall exactly on
    each other."""
    scene = stark.Scene()
    tiles = stark.mesh.grid(0.8, 0.8, 8)  # vertices at multiples of 0.1 m
    scene.add_rigid(tiles, motion="fixed", name="tiles")
    tip = _tetrahedron(0.05)
    places = [(0.0, 0.0), (0.15, 0.0), (0.0, 0.15), (0.25, 0.25), (-0.2 + 0.1 / 3, -0.2 + 0.2 / 3)]
    for k, (x, y) in enumerate(places):
        place = {"position": (x, y, 0.01), "velocity": (0, 0, -1.0)}
        if k % 2 or not full:
            scene.add_rigid(tip, density=1000.0, **place)
        else:
            tets = stark.mesh.oriented(stark.TetMesh(tip.vertices, [[0, 1, 2, 3]]))
            scene.add_solid(tets, RUBBER, **place)
    # A cube exactly over a tile, another exactly over that one.
    for k in range(4 if full else 2):
        scene.add_box(0.1, density=1000.0, position=(-0.25, 0.25, 0.06 + 0.11 * k))
    # A sheet with the same vertices as the tiles, another one exactly over it.
    for k in range(3 if full else 2):
        scene.add_cloth(stark.mesh.grid(0.2, 0.2, 2), FABRIC, position=(0.2, -0.2, 0.01 * (k + 1)))
    return Setup(scene, until=0.3 if full else 0.15, settings={"time_step": 5e-3, "contact_distance": D})


def lines(full: bool) -> Setup:
    """Cords that are parallel, collinear, end to end and crossed at nodes come at each other, without
    gravity."""
    scene = stark.Scene()
    line = stark.mesh.polyline((-0.05, 0, 0), (0.05, 0, 0), 4)
    slow = 1.0
    rows: list[tuple[float, tuple[float, float, float], float]] = [
        (0.0, (0.0, 0.0, 0.01), 0.0),  # parallel, above: exactly on it
        (0.2, (0.05, 0.0, 0.01), 0.0),  # half over the end
        (0.4, (0.0, 0.0, 0.01), 90.0),  # crossed at nodes
        (0.6, (0.1, 0.0, 0.01), 0.0),  # only the ends are above each other
        (0.8, (0.0, 1e-9, 0.01), 1e-7),  # parallel but for rounding
    ]
    for y, shift, turn in rows:
        scene.add_rod(line, CORD, position=(0, y, 0))
        scene.add_rod(
            line,
            CORD,
            position=np.array([0, y, 0]) + shift,
            rotation=stark.rotation(axis="z", angle=turn * stark.deg),
            velocity=(0, 0, -slow),
        )
    # Collinear: end to end.
    scene.add_rod(line, CORD, position=(0, -0.2, 0))
    scene.add_rod(line, CORD, position=(0.11, -0.2, 0), velocity=(-slow, 0, 0))
    # Coplanar triangles, border on border and tip on tip.
    sheet = stark.TriangleMesh([(0, 0, 0), (0.1, 0.05, 0), (0.1, -0.05, 0)], [(0, 2, 1)])
    scene.add_cloth(sheet, FABRIC, position=(0, -0.4, 0))
    scene.add_cloth(sheet, FABRIC, position=(0.11, -0.4, 0), velocity=(-slow, 0, 0))
    mirrored = stark.rotation(axis="z", angle=np.pi)
    scene.add_cloth(sheet, FABRIC, position=(-0.01, -0.6, 0), rotation=mirrored)
    scene.add_cloth(sheet, FABRIC, position=(0, -0.6, 0), velocity=(-slow, 0, 0))
    return Setup(
        scene,
        until=0.06 if full else 0.03,
        settings={"time_step": 1e-3, "contact_distance": D, "gravity": (0, 0, 0)},
    )


#: Pairs of bodies of which the second one is put at a gap above the first one.
TOUCHING = ("box_on_floor", "box_on_box", "cloth_on_cloth", "soft_on_floor", "tip_on_tip", "edge_on_edge")
TOUCHING_RODS = ("rods_crossed", "rods_parallel", "rod_on_cloth")


def touching(kind: str, gap: float) -> stark.Scene:
    """Two bodies at a gap [m]."""
    scene = stark.Scene()
    above: dict[str, Any] = {"position": (0, 0, gap)}
    line = stark.mesh.polyline((-0.1, 0, 0), (0.1, 0, 0), 3)
    sheet = stark.TriangleMesh([(0, 0, 0), (0.1, 0.05, 0), (0.1, -0.05, 0)], [(0, 2, 1)])
    upright = stark.rotation(axis="y", angle=-90 * stark.deg)
    if kind == "box_on_floor":
        scene.add_floor(1.0)
        scene.add_rigid(stark.mesh.box(0.1).translated((0.01, 0.02, 0.05)), mass=1.0, **above)
    elif kind == "box_on_box":
        scene.add_rigid(stark.mesh.box(0.1).translated((0, 0, -0.05)), motion="fixed")
        scene.add_rigid(stark.mesh.box(0.1).translated((0, 0, 0.05)), mass=1.0, **above)
    elif kind == "cloth_on_cloth":
        scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), FABRIC)
        scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), FABRIC, **above)
    elif kind == "soft_on_floor":
        scene.add_floor(1.0)
        scene.add_solid(stark.mesh.tet_box(0.1, 1).translated((0.01, 0, 0.05)), RUBBER, **above)
    elif kind == "tip_on_tip":
        scene.add_cloth(sheet, FABRIC, rotation=upright.T)
        scene.add_cloth(sheet, FABRIC, rotation=upright, **above)
    elif kind == "edge_on_edge":
        across = stark.rotation(axis="z", angle=90 * stark.deg)
        down = stark.TriangleMesh([(-0.1, 0, 0), (0.1, 0, 0), (0, 0, -0.1)], [(0, 1, 2)])
        up = stark.TriangleMesh([(-0.1, 0, 0), (0.1, 0, 0), (0, 0, 0.1)], [(0, 1, 2)])
        scene.add_cloth(down, FABRIC)
        scene.add_cloth(up, FABRIC, rotation=across, **above)
    elif kind == "rod_on_cloth":
        scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), FABRIC)
        scene.add_rod(line, CORD, **above)
    else:
        turn = 90.0 if kind == "rods_crossed" else 0.0
        scene.add_rod(line, CORD)
        scene.add_rod(line, CORD, rotation=stark.rotation(axis="z", angle=turn * stark.deg), **above)
    return scene


def gap_case(kind: str, exponent: float | None) -> Case:
    """``exponent``: the gap is the contact distance times a power of ten; None: no gap at all."""

    def build(full: bool) -> Setup:
        gap = 0.0 if exponent is None else D * 10.0**exponent
        settings = {"time_step": 5e-3, "contact_distance": D, "gravity": (0, 0, -9.81)}
        if exponent is None:
            return Setup(touching(kind, gap), 0.05, settings, refused="time 0")
        # What is squeezed together so much flies apart: not passive, its barrier holds the energy.
        return Setup(touching(kind, gap), 0.05, settings, passive=False, most_open=2)

    text = "0" if exponent is None else f"1e{exponent:g}"
    return Case(f"gap_{text}_{kind}", build)


def crushed(full: bool, ball: bool = False) -> Setup:
    """A scripted press on a rigid body on the floor: the step that cannot be must fail and say why."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    if ball:
        scene.add_sphere(0.05, subdivisions=2 if full else 1, mass=1.0, position=(0.01, 0.02, 0.0505))
    else:
        scene.add_box(0.1, mass=1.0, position=(0.01, 0.02, 0.0505))
    press = scene.add_box((0.3, 0.3, 0.02), motion="scripted", position=(0, 0, 0.12), name="press")
    press.follow(position=lambda t: (0.0, 0.0, 0.12 - 0.5 * t))
    return Setup(
        scene,
        until=0.3,
        settings={"time_step": 5e-3, "contact_distance": D},
        # A ball rolls: the press gets there, and what is below it has no place left.
        fails="time.min_step" if ball else "blocked by an obstacle",
        passive=False,
        most_iterations=10**9,
        most_retries=10**9,
        most_open=2,
    )


def pushed_into_wall(full: bool) -> Setup:
    """A border of cloth is pushed through a fixed wall."""
    scene = stark.Scene()
    scene.add_box((0.02, 1.0, 1.0), motion="fixed", position=(0.05, 0, 0), name="wall")
    sheet = stark.mesh.grid(0.05, 0.05, 6 if full else 3)
    pins = np.flatnonzero(sheet.vertices[:, 0] > 0.025 - 1e-6)
    cloth = scene.add_cloth(sheet, FABRIC, pins=pins, name="cloth")
    cloth.follow(displacement=lambda t: (0.5 * t, 0.0, 0.0))
    return Setup(
        scene,
        until=0.3,
        settings={"time_step": 5e-3, "contact_distance": D, "gravity": (0, 0, 0)},
        fails="blocked by an obstacle",
        balanced=False,
        passive=False,
        most_iterations=10**9,
        most_retries=10**9,
    )


CASES = [
    Case("exact_drops", exact_drops),
    Case("lines", lines),
    Case("crushed_box", crushed),
    Case("crushed_ball", lambda full: crushed(full, ball=True)),
    Case("pushed_into_wall", pushed_into_wall),
    *(gap_case(kind, None) for kind in (*TOUCHING, *TOUCHING_RODS)),
    *(gap_case(kind, e) for kind in (*TOUCHING, *TOUCHING_RODS) for e in (-6.0, -3.0, -0.3)),
]
