"""Fast things: bullets, spinning bodies, masses that differ by 1e5."""

from __future__ import annotations

from typing import Any

import numpy as np

import stark

from .case import Case, Setup
from .shapes import side_of

#: Contact acts within twice the contact distance; a bullet leaves its target no time to be anywhere else.
_BALL = 0.0025  # radius [m]


def bullet_on_cloth(full: bool, plate: bool = False) -> Setup:
    """A steel ball at 100 m/s, or an aluminium plate at 200 m/s, on cloth that is pinned all around."""
    scene = stark.Scene()
    cells = 24 if full else 8
    mesh = stark.mesh.grid(0.2, 0.2, cells)
    border = np.abs(mesh.vertices[:, :2]).max(axis=1) > 0.1 - 1e-6
    scene.add_cloth(mesh, stark.materials.cotton, name="sheet", pins=border)
    place: dict[str, Any] = {"position": (0.003, 0.002, 0.5), "name": "bullet"}
    if plate:
        scene.add_box((0.05, 0.05, 0.001), density=2700.0, velocity=(0, 0, -200.0), **place)
    else:
        scene.add_sphere(_BALL, subdivisions=2, density=7800.0, velocity=(0, 0, -100.0), **place)
    return Setup(
        scene,
        until=0.04 if full else 0.03,
        settings={"time_step": 0.01, "contact_distance": 5e-4},
        watch=lambda sim: _went_through(sim),
        balanced=False,
        # The cloth is thrown around by a metre a step: the straight way is not the one it took.
        most_open=10**9,
        most_iterations=3000,
        most_retries=12,
    )


def _went_through(sim: stark.Simulation) -> str | None:
    return "the bullet is behind the sheet" if side_of(sim["bullet"], sim["sheet"]) else None


def bullets_on_wall(full: bool) -> Setup:
    """Balls, cubes and needles at 100 to 200 m/s on a fixed wall of 10 mm and on each other."""
    scene = stark.Scene()
    scene.add_box((0.01, 1.0, 1.0), motion="fixed", position=(0.005, 0, 0), name="wall")
    rng = np.random.default_rng(3)
    count = 27 if full else 6
    for k in range(count):
        where = (-0.03 - 0.02 * (k % 3), 0.02 * (k // 3 % 3), 0.02 * (k // 9))
        speed = (100.0 + 100.0 * rng.random(), rng.normal(), rng.normal())
        options: dict[str, Any] = {"density": 7800.0, "velocity": speed, "position": where}
        options["angular_velocity"] = rng.normal(size=3) * 300.0
        if k % 3 == 0:
            scene.add_sphere(0.004, subdivisions=1, **options)
        elif k % 3 == 1:
            scene.add_box(0.006, **options)
        else:
            scene.add_box((0.012, 0.001, 0.001), **options)

    past_the_rim: set[str] = set()  # thrown aside, where they may fly on

    def behind(sim: stark.Simulation) -> str | None:
        bodies = [b for b in sim.bodies if b.name != "wall"]
        past_the_rim.update(b.name for b in bodies if np.abs(b.positions[:, 1:]).max() > 0.5)
        ahead = [b.name for b in bodies if b.name not in past_the_rim and b.positions[:, 0].max() >= 0.0]
        return f"{ahead} are in the wall or behind it" if ahead else None

    return Setup(
        scene,
        until=0.02,
        settings={"time_step": 1e-3, "contact_distance": 2e-4, "gravity": (0, 0, 0)},
        watch=behind,
        most_iterations=1500,
        most_open=6,  # bodies that fly past each other by many times their size
    )


def bullet_on_solid(full: bool) -> Setup:
    """A bullet at 200 m/s on a free block of rubber, which it cannot enter."""
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e6, poissons_ratio=0.45)
    scene.add_solid(stark.mesh.tet_box(0.06, 5 if full else 2), rubber, name="block")
    scene.add_sphere(
        0.005,
        subdivisions=2 if full else 1,
        density=7800.0,
        position=(-0.05, 0.003, 0.002),
        velocity=(200.0, 0, 0),
        name="bullet",
    )

    def passed(sim: stark.Simulation) -> str | None:
        ahead = sim["bullet"].position[0] > sim["block"].positions[:, 0].mean()
        return "the bullet is past the middle of the block" if ahead else None

    return Setup(
        scene,
        until=4e-3 if full else 2e-3,
        settings={"time_step": 1e-4, "contact_distance": 2e-4, "gravity": (0, 0, 0)},
        watch=passed,
        most_open=2,
    )


def spinning(full: bool) -> Setup:
    """Cubes and a stick that turn by a third of a turn a step (2000 rad/s at 1 ms) and meet."""
    scene = stark.Scene()
    count = 6 if full else 3
    for k in range(count):
        turn = np.array([(2000.0, 300.0, 0.0), (0.0, 2000.0, -300.0), (300.0, 0.0, 2000.0)][k % 3])
        where = np.array([0.16 * k, 0.01 * (-1) ** k, 0.005 * k])
        size = (0.1, 0.1, 0.1) if k % 3 else (0.14, 0.01, 0.01)
        scene.add_box(
            size,
            density=1000.0,
            position=where,
            velocity=(-3.0 * (k - (count - 1) / 2), 0, 0),
            angular_velocity=turn,
        )
    return Setup(
        scene,
        until=0.04 if full else 0.02,
        settings={"time_step": 1e-3, "contact_distance": 5e-4, "gravity": (0, 0, 0)},
        most_open=20,  # a third of a turn a step: corners go where no straight line does
    )


def mass_ratio(full: bool, heavy_above: bool = True) -> Setup:
    """10 mg below a kilogram, or above it; a slab of rubber carries 10 kg."""
    scene = stark.Scene()
    scene.add_floor(2.0)
    gap = 1.9e-4
    masses = (1e-5, 1.0) if heavy_above else (1.0, 1e-5)
    for k, mass in enumerate(masses):
        scene.add_box(
            0.1, mass=mass, position=(0.1, 0.2, 0.05 + gap + k * (0.1 + gap)), name=("lower", "upper")[k]
        )
    if full:
        rubber = stark.SolidMaterial(density=50.0, youngs_modulus=2e4)
        scene.add_solid(stark.mesh.tet_box((0.2, 0.2, 0.02), (4, 4, 1)), rubber, position=(-0.4, 0, 0.0102))
        scene.add_box((0.19, 0.19, 0.05), mass=10.0, position=(-0.4, 0, 0.0456), name="load")
    upper = 0.15 + 2 * gap

    def stands(sim: stark.Simulation) -> str | None:
        # Stiffness of contact is that of the lighter body: under 1e5 times its weight the gaps all but close.
        moved = abs(sim["upper"].position[2] - upper)
        return f"the upper cube has moved by {moved:.3g} m" if moved > 2 * gap else None

    return Setup(scene, until=0.5, settings={"time_step": 0.01, "contact_distance": 1e-4}, check=stands)


CASES = [
    Case("ball_on_cloth", bullet_on_cloth),
    Case("plate_on_cloth", lambda full: bullet_on_cloth(full, plate=True), slow=True),
    Case("bullets_on_wall", bullets_on_wall),
    Case("bullet_on_solid", bullet_on_solid),
    Case("spinning", spinning),
    Case("heavy_on_light", mass_ratio),
    Case("light_on_heavy", lambda full: mass_ratio(full, heavy_above=False)),
]
