"""Bodies that fall past the edge of a floor whose size nobody has chosen: what is said of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stark import _core
from stark.bodies.body import Body
from stark.bodies.rigid import RigidBody
from stark.caller import warn

_LOOK_EVERY = 16  # steps
_LEVEL = 1e-6  # difference of heights of a level floor [m]


class FloorEdges:
    """Watches what starts above the lowest of such floors in a simulation, and warns once. Floors that move
    or slope are left out: what is below them need not have fallen."""

    def __init__(self, floors: Sequence[Body], bodies: Sequence[Body], core: _core.Simulation) -> None:
        self._steps = 0
        self._rigid: list[Body] = []
        self._deformable: list[Body] = []
        level = [
            (corners, floor)
            for corners, floor in ((core.positions(floor._index), floor) for floor in floors)
            if floor.motion == "fixed" and np.ptp(corners[:, 2]) < _LEVEL
        ]
        if not level:
            return
        corners, self._floor = min(level, key=lambda row: float(row[0][0, 2]))
        self._height = float(corners[0, 2])
        self._rim = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
        for body in bodies:
            if (isinstance(body, RigidBody) and body.motion != "dynamic") or body in floors:
                continue
            if core.positions(body._index)[:, 2].min() >= self._height:
                (self._rigid if isinstance(body, RigidBody) else self._deformable).append(body)

    def look(self, core: _core.Simulation) -> None:
        """To be called after each step."""
        self._steps += 1
        if self._steps % _LOOK_EVERY != 0 or not (self._rigid or self._deformable):
            return
        origins, _ = core.poses([body._index for body in self._rigid])
        lower = [body for body, origin in zip(self._rigid, origins, strict=True) if origin[2] < self._height]
        fallen = [
            body
            for body in (*lower, *self._deformable)
            if self._is_past_the_edge(core.positions(body._index))
        ]
        if not fallen or not core.gravity[2] < 0.0:
            return
        others = f" and {len(fallen) - 1} more" if len(fallen) > 1 else ""
        warn(
            f"'{fallen[0].name}'{others} fell past the edge of '{self._floor.name}' before {core.time:.3g} "
            f"s: without size= a floor is 4 m along x and y; give scene.add_floor(size) the size you need"
        )
        self._rigid, self._deformable = [], []

    def _is_past_the_edge(self, places: NDArray[np.float64]) -> bool:
        """Below the floor and beside it, at least in part: what is right below has gone through."""
        low, high = self._rim
        beside = ((places[:, :2] < low) | (places[:, :2] > high)).any()
        return bool(beside and places[:, 2].max() < self._height)
