"""Cutting meshes by a plane: what is left of surfaces, and the section that is seen of solids."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .._core import InvalidArgument
from ..rotations import vector


class Plane(NamedTuple):
    """Half space that is kept: where ``normal`` . x <= ``offset`` [m]."""

    normal: np.ndarray  #: (3,) of length one
    offset: float  #: [m]

    @classmethod
    def of(cls, point: ArrayLike, normal: ArrayLike) -> Plane:
        """Through a point (3,) [m]; ``normal`` (3,) points to the side that is taken away."""
        n = vector(normal, "clip: normal")
        length = float(np.linalg.norm(n))
        if length == 0.0:
            raise InvalidArgument("clip: normal = (0, 0, 0): must point to the side that is taken away")
        n = n / length
        return cls(n, float(n @ vector(point, "clip: point")))

    def heights(self, points: np.ndarray) -> np.ndarray:
        """Signed distances [m]: positive where it is taken away."""
        return np.asarray(points @ self.normal - self.offset)


def cut_triangles(plane: Plane, data: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is kept of triangles (m, 3). ``data`` (n, k) are the vertices, three coordinates [m] first, and
    whatever is linear in between behind them; returns rows and triangles, new vertices last."""
    height = plane.heights(data[:, :3])
    out = (height > 0.0)[triangles]
    count = out.sum(axis=1)
    kept = [triangles[count == 0]]
    new: list[np.ndarray] = []
    for outside in (1, 2):
        rows, odd = triangles[count == outside], out[count == outside] == (outside == 1)
        if not len(rows):
            continue
        # The vertex alone on its side comes first.
        turned = rows[np.arange(len(rows))[:, None], (odd.argmax(axis=1)[:, None] + np.arange(3)) % 3]
        a, b, c = turned.T
        start = len(data) + sum(map(len, new))
        ab, ac = start + np.arange(len(rows)), start + len(rows) + np.arange(len(rows))
        new += [_between(data, height, a, b), _between(data, height, a, c)]
        if outside == 2:
            kept.append(np.stack([a, ab, ac], axis=1))
        else:
            kept += [np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)]
    return np.concatenate([data, *new]), np.concatenate(kept).astype(np.int32)


def section(plane: Plane, data: np.ndarray, tets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Section of tetrahedra (m, 4) with the plane: rows as those of ``data`` (n, k) in ``cut_triangles``, and
    triangles that look along the normal."""
    height = plane.heights(data[:, :3])
    # Vertices of each tetrahedron from the lowest to the highest.
    ordered = np.take_along_axis(tets, np.argsort(height[tets], axis=1), axis=1)
    above = (height > 0.0)[ordered].sum(axis=1)
    rows: list[np.ndarray] = []
    triangles: list[np.ndarray] = []
    for edges, number in (
        (((0, 3), (1, 3), (2, 3)), 1),
        (((0, 1), (0, 2), (0, 3)), 3),
        (((0, 2), (0, 3), (1, 3), (1, 2)), 2),  # around the quadrilateral
    ):
        cut = ordered[above == number]
        start, n = sum(map(len, rows)), len(cut)
        rows += [_between(data, height, cut[:, i], cut[:, j]) for i, j in edges]
        corner = start + np.arange(n)
        for k in range(1, len(edges) - 1):
            triangles.append(np.stack([corner, corner + k * n, corner + (k + 1) * n], axis=1))
    points, faces = np.concatenate(rows), np.concatenate(triangles).astype(np.int32)
    x = points[:, :3][faces]
    backwards = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) @ plane.normal < 0.0
    faces[backwards] = faces[backwards][:, ::-1]
    return points, faces


def _between(data: np.ndarray, height: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Rows where the edges from a to b meet the plane."""
    share = (height[a] / (height[a] - height[b]))[:, None]
    return np.asarray(data[a] + share * (data[b] - data[a]))
