"""A smaller scene that fails in the same way: some of its bodies and nothing else, tried before it is
believed."""

from __future__ import annotations

from typing import Any

import numpy as np

from stark.body_kinds import names_of, title_of
from stark.scene_record import Call
from stark.steps import Stepping

_ADDING = tuple(f"add_{kind}" for kind in names_of())
_ABOUT_ONE = ("pin", "clamp", "set_surface_directions", "set_surface_motion")
_ABOUT_TWO = (
    "set_friction",
    "set_anisotropic_friction",
    "set_restitution",
    "disable_contact",
    "enable_contact",
)
_ABOUT_MANY = ("disable_contacts", "enable_contacts")
_REDUCIBLE = {*_ADDING, *_ABOUT_ONE, *_ABOUT_TWO, *_ABOUT_MANY, "default_friction"}

Arrays = dict[str, Any]


def candidates(sim: Stepping, diagnosis: Any) -> list[list[int]]:
    """Sets of bodies to try, the smallest first: those of the diagnosis, then all that it mentions. None when
    they are all there are, or when bodies hang together by more than contact."""
    if any(name not in _REDUCIBLE for name, _ in sim._calls):
        return []
    titles = {title_of(body): k for k, body in enumerate(sim.bodies)}
    named = {titles[name] for name in diagnosis.bodies if name in titles}
    seen = named | {titles[name] for name in _mentioned(diagnosis) if name in titles}
    sets = [sorted(bodies) for bodies in (named, seen) if 0 < len(bodies) < len(titles)]
    return sets if len(sets) < 2 or sets[0] != sets[1] else sets[:1]


def _mentioned(diagnosis: Any) -> list[str]:
    names = [row["body"] for row in [*diagnosis.forces, *diagnosis.elements]] + list(diagnosis.pushing)
    pairs = [*diagnosis.gaps, *diagnosis.start_gaps, *([diagnosis.blocking] if diagnosis.blocking else [])]
    return names + [pair[side]["body"] for pair in pairs for side in ("a", "b")]


def reduced(sim: Stepping, state: Arrays, keep: list[int]) -> tuple[list[Call], Arrays]:
    """Calls that make the scene of some of its bodies, and their part of a state. What contact remembers is
    lost: it is known by numbers of primitives and bodies."""
    number = {old: new for new, old in enumerate(keep)}
    calls: list[Call] = []
    body = -1
    for name, arguments in sim._calls:
        if name in _ADDING:
            body += 1
            if body in number:
                calls.append((name, ({**arguments[0], "name": sim.bodies[body].name}, *arguments[1:])))
        elif name == "default_friction":
            calls.append((name, arguments))
        elif name in _ABOUT_MANY:
            calls.append((name, tuple([number[i] for i in side if i in number] for side in arguments)))
        else:
            count = 1 if name in _ABOUT_ONE else 2
            if all(index in number for index in arguments[:count]):
                calls.append((name, (*(number[i] for i in arguments[:count]), *arguments[count:])))
    places = sim._core.places()
    points = _rows([places[k][:2] for k in keep])
    bodies = _rows([places[k][2:] for k in keep])
    moving = sorted({arguments[0] for name, arguments in sim._calls if name == "set_surface_motion"})
    surfaces = np.flatnonzero(np.isin(moving, keep))
    return calls, {name: _part(name, array, points, bodies, surfaces) for name, array in state.items()}


def _rows(ranges: list[tuple[int, int]]) -> np.ndarray:
    """Rows of the kept bodies, in the order in which the smaller model has them: that of the rows."""
    rows = [np.arange(first, first + count) for first, count in ranges]
    return np.sort(np.concatenate([*rows, np.empty(0, dtype=int)]).astype(int))


def _part(name: str, array: Any, points: np.ndarray, bodies: np.ndarray, surfaces: np.ndarray) -> Any:
    if name.startswith(("friction_", "contact_")):
        return array[:0]
    if np.ndim(array) == 0 or len(array) == 0:
        return array
    if name.startswith("surface_"):
        return np.ascontiguousarray(array[surfaces])
    if name == "pin_target" or "point_" in name:
        return np.ascontiguousarray(array[points])
    if name.startswith("script_") or "body_" in name:
        return np.ascontiguousarray(array[bodies])
    return array
