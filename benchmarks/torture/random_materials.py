"""Bodies that yield, creep, grow, keep their volume or hang in a lattice, and joints that break: thrown at
each other and at a floor, pressed by a lid."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import stark

from .case import Setup
from .random_scenes import Description, Source
from .random_world import draw_world, rotation_of, setup_of, unit

#: What is drawn; the first ones have branches that relax, which bdf2 refuses.
FLOWING = ("prony_solid", "prony_shell", "prony_rod")
KINDS = (
    *FLOWING,
    *("lattice", "lattice_quadratic", "volume", "metal"),
    *("creased", "dented", "bent", "growing_solid", "growing_shell", "growing_rod", "breaking"),
)
#: For which a step may fail: a lid against what cannot give way; and what is thrown many times as fast as
#: waves run in it, at 100 m/s on 10 kPa, folds up to nothing, or throws nodes further than their bodies are
#: wide in the shortest step.
_CAUSES = ("blocked_motion", "crushing_load", "detour")
#: Radius of a body over the distance of two.
_FILL = 0.45


def draw_materials(source: Source) -> Description:
    bodies = [_draw_body(source) for _ in range(source.whole(1, 3))]
    world = draw_world(source)
    world["bdf2"] = world["bdf2"] and not any(body["kind"] in FLOWING for body in bodies)
    return {
        **world,
        "bodies": bodies,
        "floor": bool(source.whole(0, 2)),
        "lid": source.number(0.0, 1.0) if source.whole(0, 2) == 0 else None,  # scales in the whole time
    }


def _draw_body(source: Source) -> Description:
    return {
        "kind": KINDS[source.whole(0, len(KINDS) - 1)],
        "size": source.number(0.4, 1.0),
        "cells": source.whole(1, 3),
        "turn": [source.number(-1.0, 1.0) for _ in range(3)] if source.whole(0, 2) else [0.0] * 3,
        "density": source.number(2.0, 4.0),
        "stiffness": source.number(4.0, 9.0),  # [Pa]
        "poissons_ratio": source.number(0.0, 0.4),
        "yield": source.number(-4.0, -1.0),  # strain
        "hardening": source.number(-3.0, -0.5) if source.whole(0, 1) else None,  # over the modulus
        "time": source.number(-1.0, 2.0),  # of a branch, over the time step
        "growth": source.number(0.6, 1.6),  # at the end
        "break_force": source.number(-4.0, 2.0),  # over the weight
        "speed": source.number(-2.0, 2.0) if source.whole(0, 3) else None,  # [m/s]
        "aim": [source.number(-1.0, 1.0) for _ in range(3)],
    }


def build_materials(d: Description) -> Setup:
    size = 10.0 ** d["scale"]
    until = 10.0 ** d["time_step"] * d["steps"]
    scene = stark.Scene()
    high = (len(d["bodies"]) - 1.0) * size
    if d["floor"]:
        scene.add_floor(8.0 * size, height=-0.55 * size)
    for k, body in enumerate(d["bodies"]):
        place = np.array([0.0, 0.0, k * size])
        target = np.array([0.0, 0.0, 0.5 * high]) - place + 0.5 * size * np.array(body["aim"])
        speed = 0.0 if body["speed"] is None else 10.0 ** body["speed"]
        add_body(
            scene,
            body,
            d,
            position=place,
            rotation=rotation_of(body["turn"]),
            velocity=speed * unit(target),
        )
    if d["lid"] is not None:
        box, place = (3.0 * size, 3.0 * size, 0.2 * size), (0.0, 0.0, high + 0.65 * size)
        velocity = (0.0, 0.0, -d["lid"] * size / until)
        scene.add_box(box, motion="scripted", position=place, velocity=velocity, name="lid")
    return setup_of(scene, d, passive=False, causes=_CAUSES[1:] if d["lid"] is None else _CAUSES)


def add_body(scene: stark.Scene, b: Description, d: Description, **place: Any) -> None:
    """Of a radius below ``_FILL`` scales about its position."""
    radius = _FILL * 10.0 ** d["scale"] * b["size"]
    kind = b["kind"]
    if kind == "breaking":
        _add_pair(scene, b, radius, **place)
    elif kind in ("prony_rod", "bent", "growing_rod"):
        line = stark.mesh.polyline((-radius, 0.0, 0.0), (radius, 0.0, 0.0), 2 * b["cells"] + 1)
        _grow(scene.add_rod(line, _rod(b, d, radius), **place), b, d)
    elif kind in ("prony_shell", "creased", "dented", "growing_shell"):
        sheet = stark.mesh.grid(1.4 * radius, 1.4 * radius, 2 * b["cells"])
        _grow(scene.add_cloth(sheet, _shell(b, d, radius), **place), b, d)
    else:
        options: dict[str, Any] = {"formulation": "mean_dilatation"} if kind == "volume" else {}
        _grow(scene.add_solid(_solid_mesh(b, radius), _solid(b, d), **options, **place), b, d)


def _solid_mesh(b: Description, radius: float) -> Any:
    if b["kind"].startswith("lattice"):
        surface = stark.mesh.sphere(0.95 * radius, subdivisions=1)
        return stark.mesh.lattice(surface, cells=1 + b["cells"], order=2 if "quadratic" in b["kind"] else 1)
    edge = 1.1 * radius
    if b["kind"] == "volume":
        return stark.mesh.box_hexahedra(edge, b["cells"])
    return stark.mesh.tet_box(edge, b["cells"])


def _solid(b: Description, d: Description) -> Any:
    modulus, density, nu = 10.0 ** b["stiffness"], 10.0 ** b["density"], b["poissons_ratio"]
    shear, bulk = modulus / (2.0 * (1.0 + nu)), modulus / (3.0 * (1.0 - 2.0 * nu))
    if b["kind"] == "prony_solid":
        moduli, times = [shear, 0.3 * shear], _times(b, d)
        return stark.generalized_maxwell(
            shear_modulus=shear, bulk_modulus=bulk, moduli=moduli, times=times, density=density
        )
    if b["kind"] == "metal":
        return stark.j2_plasticity(
            shear_modulus=shear,
            bulk_modulus=bulk,
            yield_stress=modulus * 10.0 ** b["yield"],
            hardening_modulus=modulus * _hardening(b),
            density=density,
        )
    nu = 0.499 if b["kind"] == "volume" else nu
    return stark.SolidMaterial(density=density, youngs_modulus=modulus, poissons_ratio=nu)


def _shell(b: Description, d: Description, radius: float) -> Any:
    thick = 0.02 * radius
    modulus = 10.0 ** b["stiffness"]
    shell = stark.ShellMaterial(
        density=10.0 ** b["density"] * thick,
        thickness=thick,
        youngs_modulus=modulus,
        poissons_ratio=b["poissons_ratio"],
    )
    strain = 10.0 ** b["yield"]
    if b["kind"] == "prony_shell":
        return stark.generalized_maxwell_shell(shell, moduli=[modulus, 0.3 * modulus], times=_times(b, d))
    if b["kind"] == "creased":
        return shell.replace(bending_yield_moment=strain * modulus * thick**2 / 4.0)
    if b["kind"] == "dented":
        return shell.replace(yield_stress=strain * modulus, hardening_modulus=modulus * _hardening(b))
    return shell


def _rod(b: Description, d: Description, radius: float) -> Any:
    modulus = 10.0 ** b["stiffness"]
    rod = stark.RodMaterial(density=10.0 ** b["density"], youngs_modulus=modulus, radius=0.03 * radius)
    if b["kind"] == "prony_rod":
        return stark.generalized_maxwell_rod(rod, moduli=[modulus, 0.3 * modulus], times=_times(b, d))
    if b["kind"] == "bent":
        return rod.replace(
            yield_stress=10.0 ** b["yield"] * modulus, hardening_modulus=modulus * _hardening(b)
        )
    return rod


def _times(b: Description, d: Description) -> list[float]:
    """[s] Of two branches."""
    first = float(10.0 ** (d["time_step"] + b["time"]))
    return [first, 10.0 * first]


def _hardening(b: Description) -> float:
    return 0.0 if b["hardening"] is None else float(10.0 ** b["hardening"])


def _grow(body: Any, b: Description, d: Description) -> None:
    if not b["kind"].startswith("growing"):
        return
    until = 10.0 ** d["time_step"] * d["steps"]
    body.growth = _growth(b["growth"], until)


def _growth(end: float, until: float) -> Callable[[float], float]:
    return lambda time: 1.0 + (end - 1.0) * min(time / until, 1.0)


def _add_pair(scene: stark.Scene, b: Description, radius: float, **place: Any) -> None:
    """Two boxes, one above the other, that are fixed to each other until it breaks."""
    edge, turn = 0.7 * radius, place["rotation"]
    density = 10.0 ** b["density"]
    boxes = []
    for side in (-1.0, 1.0):
        at = place["position"] + turn @ np.array([0.0, 0.0, 0.56 * edge * side])
        boxes.append(scene.add_box(edge, density=density, **{**place, "position": at}))
    force = 10.0 ** b["break_force"] * 9.81 * density * edge**3
    scene.add_fixed(*boxes, anchor=place["position"], break_force=force, break_torque=force * edge)
