"""What random scenes of all kinds have: scale, steps, integrator, threads, friction, restitution, and small
free bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stark

from .case import Setup
from .random_scenes import Description, Source

Floats = NDArray[np.float64]

#: Shapes of small free bodies, the first ones rigid.
SHAPES = ("box", "sphere", "tetrahedron", "needle", "soft", "cloth")
RIGID_SHAPES = SHAPES[:4]

#: Fast bodies that bounce in a small room take a thousand short steps.
_MOST_STEPS = 30

#: How a scene is run once more: on other threads, from a checkpoint on, or recorded and certified.
AGAIN = ("",) * 20 + ("threads", "threads", "resume", "certify")


def draw_world(source: Source) -> Description:
    """Exponents are of ten; ``scale`` [m], ``time_step`` [s], ``contact_distance`` over the scale."""
    return {
        "scale": source.number(-2.5, 0.5),
        "contact_distance": source.number(-3.5, -1.7),
        "time_step": source.number(-3.0, -1.48),
        "steps": source.whole(3, 10),
        "friction": source.number(0.0, 1.0) if source.whole(0, 3) else 0.0,
        "restitution": source.number(0.0, 1.0) if source.whole(0, 2) == 0 else None,
        "bdf2": source.whole(0, 3) == 0,
        "threads": (1, 1, 1, 1, 1, 2, 3, 5)[source.whole(0, 7)],
        "weightless": source.whole(0, 3) == 0,
        "again": AGAIN[source.whole(0, len(AGAIN) - 1)],
    }


def settings_of(d: Description, **more: Any) -> dict[str, Any]:
    cell = 10.0 ** d["scale"]
    settings: dict[str, Any] = {
        "time_step": 10.0 ** d["time_step"],
        "contact_distance": cell * 10.0 ** d["contact_distance"],
        "threads": d["threads"],
    }
    settings |= {"time.integrator": "bdf2"} if d["bdf2"] else {}
    settings |= {"gravity": (0.0, 0.0, 0.0)} if d["weightless"] else {}
    return settings | more


def distance_of(d: Description) -> float:
    """[m] Contact distance of a body, half of the range of two."""
    return float(10.0 ** d["scale"] * 10.0 ** d["contact_distance"])


def add_pairs(scene: stark.Scene, d: Description) -> None:
    """Friction of all, restitution of all rigid pairs that can be thrown apart; after the last body."""
    scene.default_friction = d["friction"]
    if d["restitution"] is None:
        return
    rigid = [body for body in scene.bodies if body.kind == "rigid"]
    for k, a in enumerate(rigid):
        for b in rigid[:k]:
            if "dynamic" in (a.motion, b.motion):
                scene.restitution[a, b] = d["restitution"]


#: Cause that any scene can have: what is light beside what is stiff rounds by more than the tolerances.
_ROUNDING = "tolerance_below_round_off"


def setup_of(
    scene: stark.Scene,
    d: Description,
    *,
    balanced: bool = True,
    passive: bool = True,
    causes: tuple[str, ...] = (),
    drive: Callable[[stark.Simulation], None] | None = None,
    watch: Callable[[stark.Simulation], str | None] | None = None,
    **settings: Any,
) -> Setup:
    """Of random scenes: no budgets but that of time. ``causes``: for which a step may fail."""
    add_pairs(scene, d)
    return Setup(
        scene,
        until=10.0 ** d["time_step"] * d["steps"],
        settings=settings_of(d, **settings),
        drive=drive,
        watch=watch,
        causes=frozenset((*causes, _ROUNDING)),
        balanced=balanced and not d["bdf2"],
        passive=passive and not d["bdf2"],
        most_iterations=10**9,
        most_retries=10**9,
        most_open=10**9,
        most_steps=_MOST_STEPS,
    )


# --- small free bodies ---


def draw_thing(source: Source, shapes: tuple[str, ...] = SHAPES) -> Description:
    return {
        "shape": shapes[source.whole(0, len(shapes) - 1)],
        "size": source.number(0.2, 1.0),
        "flatness": source.number(-1.0, 0.0) if source.whole(0, 1) else 0.0,
        "turn": [source.number(-1.0, 1.0) for _ in range(3)] if source.whole(0, 2) else [0.0] * 3,
        "density": source.number(1.0, 4.0),
        "stiffness": source.number(3.5, 8.0),
    }


def rotation_of(turn: list[float]) -> Floats:
    """About an axis, by its length in half turns."""
    angle = float(np.linalg.norm(turn))
    return stark.rotation(axis=turn, angle=np.pi * angle) if angle > 1e-9 else np.eye(3)


def shape_of(thing: Description) -> Any:
    """Of a reach of 1 about its origin."""
    flat, shape = 10.0 ** thing["flatness"], thing["shape"]
    mesh: Any
    if shape == "box":
        mesh = stark.mesh.box((1.0, 1.0, flat))
    elif shape == "sphere":
        mesh = stark.mesh.sphere(1.0, subdivisions=int(flat > 0.5))
    elif shape == "soft":
        mesh = stark.mesh.tet_box((1.0, 1.0, max(flat, 0.3)), 1)
    elif shape == "cloth":
        mesh = stark.mesh.grid(1.0, 1.0, 2)
    else:
        corners = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
        corners = corners * ((1.0, 0.02, 0.02) if shape == "needle" else (1.0, 1.0, flat))
        faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
        mesh = stark.mesh.oriented(stark.TriangleMesh(corners, faces))
    return mesh.scaled(1.0 / float(np.linalg.norm(mesh.vertices, axis=1).max()))


def add_thing(scene: stark.Scene, thing: Description, radius: float, **place: Any) -> Any:
    """Adds a body that a ball of ``radius`` [m] about its position holds."""
    mesh = shape_of(thing).scaled(radius * thing["size"])
    density, modulus = 10.0 ** thing["density"], 10.0 ** thing["stiffness"]
    place = {"rotation": rotation_of(thing["turn"]), **place}
    if thing["shape"] == "soft":
        solid = stark.SolidMaterial(density=density, youngs_modulus=modulus, poissons_ratio=0.3)
        return scene.add_solid(mesh, solid, **place)
    if thing["shape"] == "cloth":
        thick = 0.02 * radius * thing["size"]
        shell = stark.ShellMaterial(
            density=density * thick,
            youngs_modulus=modulus * thick,
            poissons_ratio=0.3,
            bending_stiffness=0.1 * modulus * thick**3,
        )
        return scene.add_cloth(mesh, shell, **place)
    return scene.add_rigid(mesh, density=density, **place)


def unit(direction: Any) -> Floats:
    """Of length 1; along z where there is none."""
    length = float(np.linalg.norm(direction))
    return np.array(direction) / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])
