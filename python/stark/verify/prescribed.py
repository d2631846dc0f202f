"""Bodies that are scripted or fixed on both sides: nothing keeps them apart, so that they are is a claim of
its own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .certificate import NOT_APPLICABLE, VERIFIED, VIOLATED, Claim
from .predicates import segments_meet_triangles
from .run import Run, State
from .surface import Surface

Floats = NDArray[np.float64]

#: Overlap over the size of a body below which two touch.
_TOUCH = 1e-6


@dataclass
class PrescribedCheck:
    """Goes through the states: ``add(state)`` for each, then ``claims()``."""

    run: Run
    found: list[dict[str, Any]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.pairs: list[tuple[int, int]] = [
            (int(a), int(b)) for a, b in self.run.scene.get("pairs_prescribed", [])
        ]
        if not self.pairs:
            return
        self.surface: Surface = Surface(self.run)
        self.points: dict[int, NDArray[Any]] = {
            body: np.flatnonzero(self.surface.body_of == body) for pair in self.pairs for body in pair
        }

    def add(self, state: State) -> None:
        if not self.pairs:
            return
        x = state.points()
        for a, b in self.pairs:
            if self._overlap(a, b, x):
                bodies = [self.surface.bodies[a].name, self.surface.bodies[b].name]
                self.found.append({"time": state.time, "state": state.index, "bodies": bodies})

    def _overlap(self, a: int, b: int, x: Floats) -> bool:
        """Whether they meet, however one of them is moved by a little."""
        boxes = [(x[self.points[body]].min(axis=0), x[self.points[body]].max(axis=0)) for body in (a, b)]
        if (boxes[0][0] > boxes[1][1]).any() or (boxes[1][0] > boxes[0][1]).any():
            return False
        size = _TOUCH * max(float(np.linalg.norm(high - low)) for low, high in boxes)
        ways = [sign * size * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
        return all(self._meet(a, b, x, way) for way in ways)

    def _meet(self, a: int, b: int, x: Floats, way: Floats) -> bool:
        moved = x.copy()
        moved[self.points[a]] += way
        pairs = self.surface.edge_triangle_pairs_of(a, b, moved)
        return bool(segments_meet_triangles(*(moved[pairs.points[:, k]] for k in range(5))).any())

    def claims(self) -> list[Claim]:
        statement = "scripted bodies are apart from others that are scripted or fixed"
        if not self.pairs:
            detail = "there are no such pairs, or their contact is disabled"
            return [Claim("prescribed_motion", statement, NOT_APPLICABLE, "scene", detail=detail)]
        reported = [
            row.get("time") for row in self.run.rows if "prescribed_overlap" in (row.get("caveats") or [])
        ]
        where = self.found[0] if self.found else {"time": reported[0]} if reported else None
        names = sorted({" and ".join(place["bodies"]) for place in self.found})
        detail = (
            f"overlap in {len({p['state'] for p in self.found})} states: {'; '.join(names)}" if names else ""
        )
        if reported and not names:
            detail = f"reported for {len(reported)} steps, in which they pass through each other"
        return [
            Claim(
                "prescribed_motion",
                statement,
                VIOLATED if where else VERIFIED,
                "states, exact predicates; telemetry",
                float(len(self.found)),
                0.0,
                where=where,
                detail=detail,
            )
        ]
