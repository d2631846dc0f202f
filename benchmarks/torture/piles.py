"""What stands by balance, weight and friction: stacks, a house of cards, a masonry arch, layers of cloth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import stark

from .case import Case, Setup

D = 1e-4  # contact distance [m]
APART = 1.9 * D  # about the gap at rest


def _moved_less(names: list[str], start: np.ndarray, most: float) -> Callable[[stark.Simulation], str | None]:
    def check(sim: stark.Simulation) -> str | None:
        moved = np.linalg.norm(np.array([sim[name].position for name in names]) - start, axis=1).max()
        return None if moved < most else f"something has moved by {moved:.3g} m, allowed are {most:g} m"

    return check


def _standing(scene: stark.Scene, until: float, most: float) -> Setup:
    """Dynamic bodies must stay where they are."""
    bodies = [b for b in scene.bodies if b.motion == "dynamic"]
    start = np.array(
        [np.asarray(b.mesh.vertices).mean(axis=0) * 0.0 + scene._core.pose(b._index)[0] for b in bodies]
    )
    settings = {"time_step": 0.01, "contact_distance": D, "contact.stick_velocity": 1e-4}
    return Setup(scene, until, settings, check=_moved_less([b.name for b in bodies], start, most))


def tower(full: bool) -> Setup:
    """Cubes on each other."""
    scene = stark.Scene()
    scene.add_floor(2.0)
    for k in range(40 if full else 8):
        scene.add_box(0.1, mass=1.0, position=(0.1, 0.2, APART + 0.05 + k * (0.1 + APART)))
    # Under 39 kg the gaps at the bottom are a third of what they are at the top.
    return _standing(scene, 1.0 if full else 0.3, 1e-2)


def wall(full: bool) -> Setup:
    """Bricks in a bond, each on two below."""
    scene = stark.Scene()
    scene.add_floor(4.0)
    rows = 10 if full else 4
    for row in range(rows):
        for k in range(rows - row):
            x = (k + 0.5 * row) * (0.2 + APART)
            scene.add_box((0.2, 0.1, 0.06), mass=3.0, position=(x, 0.0, 0.03 + APART + row * (0.06 + APART)))
    return _standing(scene, 1.0 if full else 0.3, 1e-3)


def arch(full: bool) -> Setup:
    """A semicircle of voussoirs of mean radius 1 m, 0.15 m thick, between two fixed ones."""
    scene = stark.Scene()
    scene.default_friction = 0.5
    count, thickness = (25, 0.16) if full else (9, 0.2)
    cube = stark.mesh.box(1.0)
    u, v, w = (cube.vertices + 0.5).T  # along the radius, across the arch, along it
    for k in range(-1, count + 1):
        angle = np.pi / count * (k + w)
        radius = 1.0 + thickness * (u - 0.5)
        radial = np.column_stack([-np.cos(angle), np.zeros(8), np.sin(angle)])
        along = np.column_stack([np.sin(angle), np.zeros(8), np.cos(angle)])
        vertices = radius[:, None] * radial + APART * (0.5 - w)[:, None] * along
        vertices[:, 1] = 0.2 * (v - 0.5)
        mesh = stark.mesh.oriented(stark.TriangleMesh(vertices, cube.triangles))
        if k in (-1, count):
            scene.add_rigid(mesh, motion="fixed")
        else:
            scene.add_rigid(mesh, density=2000.0)
    return _standing(scene, 1.0 if full else 0.3, 0.02)


def card_house(full: bool) -> Setup:
    """Cards of 90 x 60 x 1 mm that lean against each other in pairs, with cards across."""
    scene = stark.Scene()
    scene.default_friction = 0.7
    scene.add_floor(1.0)
    slope, length, thickness = np.radians(70.0), 0.09, 1e-3
    y = np.array([0.0, 1.0, 0.0])

    def card(size: float, position: tuple[float, float, float], up: np.ndarray) -> None:
        axes = np.column_stack([up, y, np.cross(up, y)])
        scene.add_box((size, 0.06, thickness), density=800.0, rotation=axes, position=position)

    def tent(x: float, ground: float) -> float:
        for side in (1, -1):
            up = np.array([side * np.cos(slope), 0, np.sin(slope)])
            extent = np.abs(np.column_stack([up, np.cross(up, y)])) @ (length / 2, thickness / 2)
            card(length, (x - side * (extent[0] + APART / 2), 0.0, ground + APART + extent[2]), up)
        return ground + APART + 2 * extent[2]

    base = 2.0 * length * np.cos(slope) + 2 * thickness + 4 * APART
    levels, ground = (3 if full else 2), 0.0
    for level in range(levels):
        count = levels - level
        xs = base * (np.arange(count) - (count - 1) / 2)
        top = max(tent(x, ground) for x in xs)
        if count > 1:
            for x in 0.5 * (xs[1:] + xs[:-1]):
                card(base - 4 * APART, (x, 0.0, top + APART + thickness / 2), np.array([1.0, 0.0, 0.0]))
        ground = top + APART + thickness
    return _standing(scene, 1.0 if full else 0.3, 5e-3)


def layers(full: bool) -> Setup:
    """Sheets that fall on each other and on a table: their order stays."""
    scene = stark.Scene()
    scene.default_friction = 0.3
    scene.add_box((0.14, 0.14, 0.02), motion="fixed", position=(0.0, 0.0, -0.01), name="table")
    count, cells = (100, 6) if full else (16, 4)
    rng = np.random.default_rng(5)
    spacing = 1.2e-3
    for k in range(count):
        turn = stark.rotation(axis="z", angle=float(rng.uniform(-0.3, 0.3)))
        # Each a bit faster than the one below: they hit all at once.
        scene.add_cloth(
            stark.mesh.grid(0.16, 0.16, cells),
            stark.materials.cotton.replace(mass_damping=0.0),
            position=(*rng.uniform(-5e-3, 5e-3, 2), 1e-3 + spacing * k),
            rotation=turn,
            velocity=(0, 0, -0.01 * k),
            name=f"sheet {k}",
        )

    def disordered(sim: stark.Simulation) -> str | None:
        middle = np.array([_height_in_the_middle(sim[f"sheet {k}"]) for k in range(count)])
        wrong = np.flatnonzero(np.diff(middle) <= 0.0)
        return f"sheets {wrong.tolist()} are above the next ones" if len(wrong) else None

    return Setup(
        scene,
        until=0.2 if full else 0.1,
        settings={"time_step": 0.01, "contact_distance": 2.5e-4},
        watch=disordered,
        most_open=5,
    )


def _height_in_the_middle(sheet: stark.Cloth) -> float:
    """Lowest point of the sheet above the middle of the table [m]."""
    x = sheet.positions[sheet.triangles]
    a, b, c = (x[:, i, :2] for i in range(3))

    def cross(p: np.ndarray, q: np.ndarray) -> np.ndarray:
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    weights = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=1)
    hit = (weights >= 0).all(axis=1) | (weights <= 0).all(axis=1)
    return float(((weights[hit] * x[hit][:, :, 2]).sum(axis=1) / weights[hit].sum(axis=1)).min())


CASES = [
    Case("tower", tower),
    Case("brick_wall", wall),
    Case("arch", arch),
    Case("card_house", card_house),
    Case("layers", layers, slow=True),
]
