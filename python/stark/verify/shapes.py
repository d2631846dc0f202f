"""Rigid bodies keep their shape, and fixed ones their place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .certificate import NOT_APPLICABLE, VERIFIED, VIOLATED, Claim, comparable
from .files import need
from .run import Run, State, stacked

Floats = NDArray[np.float64]

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

    def __post_init__(self) -> None:
        bodies = [(i, body) for i, body in enumerate(self.run.bodies) if body.has_pose]
        self.numbers: list[int] = [i for i, _ in bodies]
        counts = np.array([body.vertex_count for _, body in bodies], dtype=np.int64)
        need(bool((counts > 0).all()), "a rigid body has no vertices")
        #: First vertices of bodies, and the bodies of vertices, counting rigid ones only.
        self.firsts: NDArray[np.int64] = np.cumsum(counts) - counts
        self.owners: NDArray[np.int64] = np.repeat(np.arange(len(counts)), counts)
        fixed = np.array([body.motion == "fixed" for _, body in bodies], dtype=bool)
        self.is_still: NDArray[np.bool_] = fixed[self.owners]

    def add(self, state: State) -> None:
        self.start = self.start or state
        if not self.numbers:
            return
        poses0, poses = (stacked(s.poses, self.numbers).reshape(-1, 4, 3) for s in (self.start, state))
        x0, x = (stacked(s.positions, self.numbers).reshape(-1, 3) for s in (self.start, state))
        turns = poses[:, 1:] @ poses0[:, 1:].transpose(0, 2, 1)
        arms = x0 - poses0[self.owners, 0]
        expected = poses[self.owners, 0]
        for k in range(3):
            expected += arms[:, k, None] * turns[self.owners, :, k]
        expected[self.is_still] = x0[self.is_still]
        # A matrix that is no rotation would carry a deformed shape along, or its mirror image.
        off = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        skew = np.maximum(off, 1.0 - np.linalg.det(turns))
        size = self._largest(x0) + self._largest(x) + 1e-300
        error = self._largest(x - expected) + skew * size
        share = error / (_ROUNDING * size)
        worst = int(np.argmax(share))  # the first NaN, if there are any
        if comparable(float(share[worst])) > self.share:
            self.share = comparable(float(share[worst]))
            self.worst, self.allowed = float(error[worst]), _ROUNDING * float(size[worst])
            self.where = {"time": state.time, "bodies": [self.run.bodies[self.numbers[worst]].name]}

    def _largest(self, rows: Floats) -> Floats:
        """Largest absolute value of each body."""
        largest: Floats = np.maximum.reduceat(np.abs(rows).max(axis=1), self.firsts)
        return largest

    def claims(self) -> list[Claim]:
        name, basis = "rigid_shapes", "states, vertices against poses"
        statement = "rigid bodies keep their shape, and fixed ones their place"
        if self.where is None:
            return [Claim(name, statement, NOT_APPLICABLE, basis, detail="there are none")]
        status = VERIFIED if self.share <= 1.0 else VIOLATED
        return [Claim(name, statement, status, basis, self.worst, self.allowed, "m", self.where)]
