"""Bodies that fall past the edge of a floor whose size nobody has chosen: what is said of them."""

from __future__ import annotations

from collections.abc import Sequence

from stark import _core
from stark.bodies.body import Body
from stark.bodies.rigid import RigidBody
from stark.caller import warn

_LOOK_EVERY = 16  # steps


class FloorEdges:
    """Watches what starts above the lowest of such floors in a simulation, and warns once."""

    def __init__(self, floors: Sequence[Body], bodies: Sequence[Body], core: _core.Simulation) -> None:
        self._steps = 0
        self._rigid: list[Body] = []
        self._deformable: list[Body] = []
        if not floors:
            return
        self._height, self._floor = min(
            ((float(core.positions(floor._index)[0, 2]), floor) for floor in floors), key=lambda row: row[0]
        )
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
            if core.positions(body._index)[:, 2].max() < self._height
        ]
        if not fallen or not core.gravity[2] < 0.0:
            return
        others = f" and {len(fallen) - 1} more" if len(fallen) > 1 else ""
        warn(
            f"'{fallen[0].name}'{others} fell past the edge of '{self._floor.name}' before {core.time:.3g} "
            f"s: without size= a floor is 4 m along x and y; give scene.add_floor(size) the size you need"
        )
        self._rigid, self._deformable = [], []
