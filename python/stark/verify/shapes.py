"""Rigid bodies keep their shape, and fixed ones their place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .certificate import NOT_APPLICABLE, VERIFIED, VIOLATED, Claim, comparable
from .run import Run, State

#: Rounding of a pose times a vertex, over the size of the coordinates.
_ROUNDING = 1e-12


@dataclass
class ShapeCheck:
    """``add(state)`` for each state, the first one first, then ``claims()``."""

    run: Run
    start: State | None = None
    share: float = -1.0  # of what rounding explains
    worst: float = 0.0  # [m]
    allowed: float = 0.0
    where: dict[str, Any] | None = None

    def add(self, state: State) -> None:
        self.start = self.start or state
        for i, body in enumerate(self.run.bodies):
            first, pose = self.start.poses[i], state.poses[i]
            if first is None or pose is None:
                continue
            x0, x = self.start.positions[i], state.positions[i]
            turn = pose[1:] @ first[1:].T
            expected = x0 if body.motion == "fixed" else pose[0] + (x0 - first[0]) @ turn.T
            # A matrix that is no rotation would carry a deformed shape along, or its mirror image.
            skew = float(np.abs(turn @ turn.T - np.eye(3)).max())
            skew = max(skew, 1.0 - float(np.linalg.det(turn)))
            size = float(np.abs(x0).max() + np.abs(x).max()) + 1e-300
            error = float(np.abs(x - expected).max()) + skew * size
            share = comparable(error / (_ROUNDING * size))
            if share > self.share:
                self.share, self.worst, self.allowed = share, error, _ROUNDING * size
                self.where = {"time": state.time, "bodies": [body.name]}

    def claims(self) -> list[Claim]:
        name, basis = "rigid_shapes", "states, vertices against poses"
        statement = "rigid bodies keep their shape, and fixed ones their place"
        if self.where is None:
            return [Claim(name, statement, NOT_APPLICABLE, basis, detail="there are none")]
        status = VERIFIED if self.share <= 1.0 else VIOLATED
        return [Claim(name, statement, status, basis, self.worst, self.allowed, "m", self.where)]
