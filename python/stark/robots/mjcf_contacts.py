"""Which bodies of MJCF files touch each other: ``contype``, ``conaffinity``, ``<exclude>``, ``<pair>``."""

from __future__ import annotations

from itertools import combinations, product
from typing import Any

import numpy as np

from stark.robots.report import Report

#: Pairs of numbers of bodies, the smaller one first.
Pairs = list[tuple[int, int]]


def touching_geoms(model: Any) -> Any:
    """Which geoms touch anything: by their masks, or as a ``<pair>`` names them (n,) bool."""
    named = np.isin(np.arange(model.ngeom), [*model.pair_geom1, *model.pair_geom2])
    return (model.geom_contype != 0) | (model.geom_conaffinity != 0) | named


def untouching(model: Any, bodies: list[int], report: Report) -> Pairs:
    """Pairs of ``bodies`` that do not touch: those of ``<exclude>``, and those none of whose geoms collide by
    their masks. What a ``<pair>`` names touches all the same, as in mujoco."""
    known, named = set(bodies), _named_pairs(model)
    excluded = {
        (min(a, b), max(a, b))
        for a, b in ((int(pair) >> 16, int(pair) & 0xFFFF) for pair in np.ravel(model.exclude_signature))
    }
    found = excluded - named
    welds = _parts(model, bodies)
    partly: list[tuple[int, int]] = []
    for first, second in combinations(welds, 2):
        pairs = {(min(a, b), max(a, b)) for a, b in product(welds[first], welds[second])}
        collides = _collisions(model, welds[first], welds[second])
        if collides.size == 0 or pairs & named:
            continue
        if not collides.any():
            found |= pairs
        elif not collides.all() and not pairs <= excluded:
            partly.append((first, second))
    if partly:
        names = ", ".join(f"'{model.body(a).name}' and '{model.body(b).name}'" for a, b in partly[:3])
        report.add(
            "assumed",
            "file",
            f"contype and conaffinity let some geoms of {len(partly)} pairs of bodies touch and others not: "
            f"all of their geoms touch ({names}{', ...' if len(partly) > 3 else ''})",
        )
    return sorted(pair for pair in found if known.issuperset(pair))


def _parts(model: Any, bodies: list[int]) -> dict[int, list[int]]:
    """Bodies by what they are welded to: they touch as one."""
    found: dict[int, list[int]] = {}
    for body in bodies:
        found.setdefault(int(model.body_weldid[body]), []).append(body)
    return found


def _named_pairs(model: Any) -> set[tuple[int, int]]:
    """Bodies of which a ``<pair>`` names two geoms."""
    found = set()
    for a, b in zip(model.pair_geom1, model.pair_geom2, strict=True):
        one, other = int(model.geom_bodyid[a]), int(model.geom_bodyid[b])
        found.add((min(one, other), max(one, other)))
    return found


def _collisions(model: Any, first: list[int], second: list[int]) -> Any:
    """Which geoms of two parts collide by their masks (n, m) bool, without those that touch nothing."""
    type_a, affinity_a = _masks(model, first)
    type_b, affinity_b = _masks(model, second)
    return ((type_a[:, None] & affinity_b) | (type_b & affinity_a[:, None])) != 0


def _masks(model: Any, bodies: list[int]) -> tuple[Any, Any]:
    geoms = np.isin(model.geom_bodyid, bodies) & touching_geoms(model)
    return model.geom_contype[geoms], model.geom_conaffinity[geoms]
