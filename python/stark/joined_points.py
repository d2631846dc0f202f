"""Points of several bodies as one selection, for energies whose elements lie on different bodies: the
sections of a cable through the links of a robot, springs between many parts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import shown_value
from stark.handle import BodyHandle
from stark.selections import Points, Stencils, rows_of

Floats = NDArray[np.float64]


class JoinedPoints:
    """Points of bodies and of the world, one selection after another. Made by ``stark.joined``."""

    point_count = 1
    body: None = None  # where one body is asked for, these are none of it

    def __init__(self, parts: Sequence[Points]) -> None:
        self.parts: tuple[Points, ...] = tuple(part for part in parts if len(part))
        """Selections of one body each."""
        if len({part.is_direction for part in self.parts}) > 1:
            raise InvalidArgument(
                f"stark.joined: {' and '.join(map(repr, parts))}: must be all points or all directions"
            )
        self.is_direction: bool = any(part.is_direction for part in self.parts)
        """Whether the positions are directions."""

    @property
    def bodies(self) -> list[BodyHandle]:
        """Whose points they are, each once."""
        return list(dict.fromkeys(body for part in self.parts for body in part.bodies))

    def __len__(self) -> int:
        return sum(len(part) for part in self.parts)

    def __getitem__(self, key: Any) -> JoinedPoints:
        """Some of the points: an index, a slice, indices or a mask."""
        chosen = np.atleast_1d(np.arange(len(self))[rows_of(key, len(self), repr(self))])
        ends = np.cumsum([len(part) for part in self.parts])
        of = np.searchsorted(ends, chosen, side="right")
        starts = ends - [len(part) for part in self.parts]
        runs = np.split(np.arange(len(chosen)), np.flatnonzero(np.diff(of)) + 1)
        return JoinedPoints(
            [self.parts[of[run[0]]][chosen[run] - starts[of[run[0]]]] for run in runs if len(run)]
        )

    @property
    def owners(self) -> NDArray[np.int64]:
        """What carries the frame of the rest position of each point (n, 2)."""
        return np.concatenate(
            [np.empty((0, 2), np.int64), *(np.repeat(p.owners, len(p), axis=0) for p in self.parts)]
        )

    @property
    def positions(self) -> Floats:
        """In the world at time 0 (n, 3) [m]; of directions, the directions."""
        return self._stacked("positions")

    @property
    def rest_positions(self) -> Floats:
        """In the frames of the meshes of their bodies (n, 3) [m]."""
        return self._stacked("rest_positions")

    @property
    def placed_rest_positions(self) -> Floats:
        """Where the points would be at time 0 if their bodies were in their rest shapes (n, 3) [m]."""
        return self._stacked("placed_rest_positions")

    def _stacked(self, name: str) -> Floats:
        return np.concatenate([np.empty((0, 3)), *(getattr(part, name) for part in self.parts)])

    def _description(self) -> dict[str, Any]:
        """As the core reads it."""
        return {"kind": "joined", "parts": [part._description() for part in self.parts]}

    def __repr__(self) -> str:
        owners = [f"'{body.name}'" for body in self.bodies]
        owners += ["the world"] if any(part.body is None for part in self.parts) else []
        return f"<{len(self)} points of {' and '.join(owners) or 'nothing'}>"


def joined(*selections: Points | JoinedPoints | Stencils | Iterable[Any]) -> Any:
    """Points of several bodies, or stencils of as many points each, as one selection, in the order in which
    they are given: ``stark.joined(link.points((0, 0, 0.1)) for link in links)``. InvalidArgument for anything
    else and for points with stencils."""
    given: list[Any] = []
    for item in selections:
        given += [item] if isinstance(item, (Points, JoinedPoints, Stencils)) else _items(item)
    if given and all(isinstance(item, (Points, JoinedPoints)) for item in given):
        return _points(given)
    counts = {item.point_count for item in given if isinstance(item, Stencils)}
    if not given or len(counts) != 1 or not all(isinstance(item, Stencils) for item in given):
        raise InvalidArgument(
            f"stark.joined: got {shown_value(given)}: must be points, such as box.points(...) and "
            f"cloth.vertices, or stencils of as many points each, such as cloth.edges"
        )
    columns = [[_full(item, j) for item in given] for j in range(counts.pop())]
    return Stencils([_points(column) for column in columns], given[0]._noun)


def _items(item: Any) -> list[Any]:
    try:
        return list(item)
    except TypeError:
        return [item]


def _points(given: Sequence[Points | JoinedPoints]) -> JoinedPoints:
    return JoinedPoints(
        [part for item in given for part in (item.parts if isinstance(item, JoinedPoints) else [item])]
    )


def _full(item: Stencils, j: int) -> Points | JoinedPoints:
    """Column j with a point for each stencil."""
    column: Points | JoinedPoints = item.columns[j]
    return column[np.zeros(len(item), dtype=np.int64)] if len(column) == 1 else column
