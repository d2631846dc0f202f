"""Small fast bodies, to 1,000 m/s, against free thin plates and sheets, one or several behind each other: who
comes from one side of a plate must not be on the other after a step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stark

from .case import Setup
from .random_scenes import Description, Source
from .random_world import (
    RIGID_SHAPES,
    add_thing,
    distance_of,
    draw_thing,
    draw_world,
    rotation_of,
    setup_of,
)

Floats = NDArray[np.float64]

PLATES = ("rigid", "rigid", "rigid", "open", "sheet", "soft", "fixed")
#: Places on a plate, over its size: two bodies never start in the same.
_PLACES = [(x, y) for x in (-0.3, 0.0, 0.3) for y in (-0.3, 0.0, 0.3)]
#: For which a step may fail: bodies of a hundredth of a millimetre go further than their size in the shortest
#: step, and what is hit by them may have no room.
_CAUSES = ("detour", "crushing_load")
#: Turn of a plate in a step [rad] from which it is not told who went around it and who through it.
_TURN = 0.3
#: Part of a plate, from its middle, where nothing gets around it within a step.
_MIDDLE = 0.8


def draw_impacts(source: Source) -> Description:
    first, stride = source.whole(0, 8), (1, 2, 4)[source.whole(0, 2)]
    return {
        **draw_world(source),
        "plates": [
            {
                "kind": PLATES[source.whole(0, len(PLATES) - 1)],
                "thickness": source.number(-2.3, -0.7),  # over the size
                "density": source.number(1.0, 4.0),
                "stiffness": source.number(3.5, 9.0),
                "gap": source.number(-0.5, 1.5),  # behind it, over the range of contact
                "velocity": source.number(-1.0, 1.0) if source.whole(0, 3) == 0 else 0.0,  # scales a second
                "cells": source.whole(1, 3),
            }
            for _ in range(source.whole(1, 3))
        ],
        "turn": [source.number(-1.0, 1.0) for _ in range(3)] if source.whole(0, 1) else [0.0] * 3,
        "bodies": [
            {
                **draw_thing(source, RIGID_SHAPES if source.whole(0, 3) else ("soft", "cloth")),
                "radius": source.number(-2.0, -0.9),  # over the size of the plates
                "place": (first + stride * k) % len(_PLACES),
                "above": bool(source.whole(0, 3)),
                "speed": source.number(0.0, 3.0),  # [m/s]
                "slant": [source.number(-0.4, 0.4) for _ in range(2)] if source.whole(0, 1) else [0.0] * 2,
                "flight": source.number(0.02, 2.5),  # steps until it is there
                "spin": source.number(0.0, 3.0) if source.whole(0, 3) == 0 else None,  # [rad/s]
            }
            for k in range(source.whole(1, 4))
        ],
        "floor": source.whole(0, 3) == 0,
    }


def build_impacts(d: Description) -> Setup:
    size, distance = 10.0 ** d["scale"], distance_of(d)
    turn = rotation_of(d["turn"])
    scene = stark.Scene()
    plates, height, low = [], 0.0, 0.0
    for plate in d["plates"]:
        thick = size * 10.0 ** plate["thickness"] if plate["kind"] in ("rigid", "fixed", "soft") else 0.0
        middle = height - thick / 2
        velocity = turn @ np.array([0.0, 0.0, size * plate["velocity"]])
        plates.append(_add_plate(scene, plate, size, thick, turn, turn @ np.array([0, 0, middle]), velocity))
        low = height - thick
        height = low - 2.0 * distance * 10.0 ** plate["gap"]
    for body in d["bodies"]:
        _add_body(scene, body, d, size, distance, turn, low)
    if d["floor"]:
        scene.add_floor(10.0 * size, height=-3.0 * size)
    rigid = [(plate, size) for plate in plates if plate.kind == "rigid"]
    return setup_of(scene, d, watch=no_passing(rigid), causes=_CAUSES)


def _add_plate(
    scene: stark.Scene, plate: Description, size: float, thick: float, turn: Floats, at: Floats, v: Floats
) -> Any:
    place: dict[str, Any] = {"position": at, "rotation": turn}
    density, modulus = 10.0 ** plate["density"], 10.0 ** plate["stiffness"]
    cells = plate["cells"]
    if plate["kind"] in ("rigid", "fixed"):
        place |= {"motion": "fixed"} if plate["kind"] == "fixed" else {"density": density, "velocity": v}
        return scene.add_box((size, size, thick), **place)
    if plate["kind"] == "open":
        weight = density * 0.01 * size**3
        return scene.add_rigid(stark.mesh.grid(size, size, cells), mass=weight, velocity=v, **place)
    if plate["kind"] == "soft":
        mesh = stark.mesh.tet_box(1.0, cells).scaled((size, size, thick))
        material = stark.SolidMaterial(density=density, youngs_modulus=modulus, poissons_ratio=0.3)
        return scene.add_solid(mesh, material, velocity=v, **place)
    film = 0.01 * size
    shell = stark.ShellMaterial(
        density=density * film,
        youngs_modulus=modulus * film,
        poissons_ratio=0.3,
        bending_stiffness=0.1 * modulus * film**3,
    )
    return scene.add_cloth(stark.mesh.grid(size, size, 2 * cells), shell, velocity=v, **place)


def _add_body(
    scene: stark.Scene,
    body: Description,
    d: Description,
    size: float,
    distance: float,
    turn: Floats,
    low: float,
) -> None:
    radius = size * 10.0 ** body["radius"]
    speed, flight = 10.0 ** body["speed"], 10.0 ** d["time_step"] * body["flight"]
    way = np.array([*body["slant"], -1.0 if body["above"] else 1.0])
    way /= np.linalg.norm(way)
    target = np.array([*(size * np.array(_PLACES[body["place"]])), 0.0 if body["above"] else low])
    # What starts beside the others and goes along with them never meets them on the way.
    clear = (radius + 2.5 * distance) * (1.0 if body["above"] else -1.0)
    start = target + np.array([0.0, 0.0, clear]) - speed * flight * way
    spin = np.zeros(3)
    if body["spin"] is not None:
        spin = 10.0 ** body["spin"] * turn @ np.array([0.6, 0.0, 0.8])
    rotation = turn @ rotation_of(body["turn"])
    place = {"position": turn @ start, "velocity": speed * turn @ way, "angular_velocity": spin}
    add_thing(scene, body, radius, **{**place, "rotation": rotation})


def no_passing(plates: list[tuple[Any, float]]) -> Callable[[stark.Simulation], str | None] | None:
    """A watch: no body goes, as a whole and through the middle, from one side of a flat rigid plate to the
    other in a step, as seen from the plate, if that turns slowly."""
    if not plates:
        return None
    last: dict[tuple[str, str], Floats] = {}
    turned: dict[str, Floats] = {}

    def seen(sim: stark.Simulation) -> dict[tuple[str, str], Floats]:
        return {
            (body.name, plate.name): (body.surface_positions - sim[plate].position) @ sim[plate].rotation
            for plate, _ in plates
            for body in sim.bodies
            if body.name != plate.name
        }

    def watch(sim: stark.Simulation) -> str | None:
        found = None
        sizes = {plate.name: size for plate, size in plates}
        now = seen(sim)
        turns = {plate.name: _turn(turned.get(plate.name), sim[plate].rotation) for plate, _ in plates}
        turned.update({plate.name: sim[plate].rotation for plate, _ in plates})
        for (body, plate), after in now.items():
            before = last.get((body, plate))
            if before is not None and _went_through(before, after, sizes[plate], turns[plate]):
                found = f"'{body}' passed through '{plate}'"
        last.update(now)
        return found

    return watch


def _turn(before: Floats | None, after: Floats) -> float:
    """[rad]"""
    if before is None:
        return np.inf
    return float(np.arccos(np.clip(0.5 * (np.trace(after @ before.T) - 1.0), -1.0, 1.0)))


def _went_through(before: Floats, after: Floats, size: float, turn: float) -> bool:
    """All points of a body, in the frame of a plate across z that turns by an angle in the step: far bodies
    cross its plane elsewhere than on the straight line in its frame, by less than that angle times their
    distance. What turns much they get around."""
    if turn > _TURN:
        return False
    a, b = before[:, 2], after[:, 2]
    if not ((a > 0).all() and (b < 0).all()) and not ((a < 0).all() and (b > 0).all()):
        return False
    part = (a / (a - b))[:, None]
    crossing = (before + part * (after - before))[:, :2]
    off = turn * max(float(np.linalg.norm(x, axis=1).max()) for x in (before, after))
    return bool((np.abs(crossing) + off < 0.5 * _MIDDLE * size).all())
