"""Prescribed bodies that close on what is between them: to a stop, further than it is thick, through each
other, and open again. Pins that stretch and press. Steps stop where nothing can give way, and say why."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import stark

from .case import Setup
from .random_scenes import Description, Source
from .random_world import add_thing, draw_thing, draw_world, rotation_of, setup_of

Floats = NDArray[np.float64]

JAWS = ("plates", "plates", "spheres", "wedges", "ring")
#: For which a step may fail; ``pins`` more than squeezes.
_CAUSES = ("blocked_motion", "crushing_load")
_PIN_CAUSES = ("overconstrained_pins", "inverted_element")


def draw_squeezes(source: Source) -> Description:
    return {
        **draw_world(source),
        "jaws": JAWS[source.whole(0, len(JAWS) - 1)],
        "count": source.whole(2, 6),
        "opening": source.number(1.02, 1.6),  # of the room at the start, over the thing
        "closing": source.number(-0.3, 1.6),  # at the end, over the thing: below 0 beyond the middle
        "back": source.whole(0, 2) == 0,
        "one_sided": source.whole(0, 3) == 0,
        "follow": bool(source.whole(0, 1)),
        "thing": draw_thing(source),
        "more": [draw_thing(source) for _ in range(source.whole(0, 2))],
        "pins": source.number(-0.9, 2.0) if source.whole(0, 3) == 0 else None,  # stretch of a pinned thing
        "turn": [source.number(-1.0, 1.0) for _ in range(3)] if source.whole(0, 1) else [0.0] * 3,
    }


def build_squeezes(d: Description) -> Setup:
    size, turn = 0.3 * 10.0 ** d["scale"], rotation_of(d["turn"])
    scene = stark.Scene()
    thing = add_thing(scene, d["thing"], size, position=(0, 0, 0), name="thing")
    ways = _ways(d)
    room = not any(abs(way[2]) > 0.5 for way in ways)
    for k, other in enumerate(d["more"] if room else ()):  # above each other, beside the jaws
        at = turn @ np.array([0.0, 0.0, 2.1 * size * (k + 1)])
        add_thing(scene, other, size, position=at)
    pinned = d["pins"] is not None and d["thing"]["shape"] in ("soft", "cloth")
    if pinned:
        _pull(thing, d, size)
    for k, way in enumerate(ways):
        _add_jaw(scene, d, k, turn @ way, size)
    return setup_of(scene, d, passive=False, balanced=not pinned, causes=_CAUSES + _PIN_CAUSES * pinned)


def _ways(d: Description) -> list[Floats]:
    """Directions from which jaws come."""
    if d["jaws"] == "ring":
        angles = 2.0 * np.pi * np.arange(d["count"]) / d["count"]
        return [np.array([np.cos(angle), np.sin(angle), 0.0]) for angle in angles]
    axes = [np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), np.array([0, 0, 1.0])]
    return [side * axis for axis in axes for side in (1.0, -1.0)][
        : d["count"] // 2 * 2 if d["count"] > 2 else 2
    ]


def _add_jaw(scene: stark.Scene, d: Description, k: int, way: Floats, size: float) -> None:
    """A body whose front is ``opening`` sizes from the middle at first, ``closing`` at the end."""
    until = 10.0 ** d["time_step"] * d["steps"]
    still = d["one_sided"] and k % 2 == 1
    mesh, front = _jaw(d, size)
    rotation = _towards(-way)
    start, end = ((front + part * size) * way for part in (d["opening"], d["closing"]))
    if still:
        scene.add_rigid(mesh, motion="fixed", position=start, rotation=rotation, name=f"jaw_{k}")
        return
    velocity = np.zeros(3) if d["follow"] else (end - start) / (0.8 * until)
    jaw = scene.add_rigid(
        mesh, motion="scripted", position=start, rotation=rotation, velocity=velocity, name=f"jaw_{k}"
    )
    if d["follow"]:
        times = [0.0, 0.5 * until, until] if d["back"] else [0.0, 0.8 * until]
        places = [start, end, start] if d["back"] else [start, end]
        jaw.follow(position=stark.motion.linear(times, places))


def _jaw(d: Description, size: float) -> tuple[Any, float]:
    """Mesh with its front towards +x, and how far that is from its origin. Plates of different sides do not
    meet before they are closed to half."""
    wide = size * min(1.0, d["opening"])
    if d["jaws"] == "spheres":
        return stark.mesh.sphere(0.9 * size, subdivisions=1), 0.9 * size
    if d["jaws"] == "wedges":
        corners = [(0, 0, -1), (0, 0, 1), (-1, -0.4, -1), (-1, 0.4, -1), (-1, -0.4, 1), (-1, 0.4, 1)]
        faces = [(0, 2, 3), (1, 5, 4), (0, 1, 2), (1, 4, 2), (0, 3, 1), (1, 3, 5), (2, 4, 3), (4, 5, 3)]
        return stark.mesh.oriented(stark.TriangleMesh(wide * np.array(corners, dtype=float), faces)), 0.0
    thick = 0.2 * size
    across = wide * (2.0 if d["jaws"] == "plates" and d["count"] < 4 else 0.9)
    return stark.mesh.box((thick, across, across)), 0.5 * thick


def _towards(way: Floats) -> Floats:
    """Turns x to a direction."""
    other = np.array([0.0, 0.0, 1.0]) if abs(way[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    y = np.cross(other, way)
    y /= np.linalg.norm(y)
    return np.column_stack([way, y, np.cross(way, y)])


def _pull(thing: Any, d: Description, size: float) -> None:
    """Pins on two sides of the thing that are pulled apart, or pressed together and beyond."""
    x = thing.positions
    along = x[:, 0] - x[:, 0].mean()
    reach = np.abs(along).max()
    pins = np.flatnonzero(np.abs(along) > 0.9 * reach)
    if reach < 1e-6 * size or len(pins) == len(x):
        return
    thing.pin(pins)
    until, stretch = 10.0 ** d["time_step"] * d["steps"], d["pins"]
    start = x[pins]
    offset = np.zeros_like(start)
    offset[:, 0] = stretch * along[pins]
    thing.follow(lambda time: start + min(time / until, 1.0) * offset)
