"""All collision primitives of a scene in one numbering, and the pairs of them that are near."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .boxes import BoxTree, overlapping_pairs
from .distances import Kind
from .reading import Body, Run

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class PairList:
    """Pairs of primitives: their points (k, 4) or (k, 5), the bodies of both sides (k, 2), and how many of
    the points are of the first side."""

    points: Integers
    bodies: Integers
    first: int

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, rows: Any) -> PairList:
        return PairList(self.points[rows], self.bodies[rows], self.first)


class Surface:
    """Points are numbered through all bodies. Edges are taken from the triangles, and of rods as they are."""

    def __init__(self, run: Run) -> None:
        self.bodies: list[Body] = run.bodies
        self.starts = np.cumsum([0, *(body.vertex_count for body in self.bodies)])
        self.triangles = np.concatenate([b.triangles + s for b, s in self._placed()]).astype(np.int64)
        self.edges = np.concatenate([_edges(b) + s for b, s in self._placed()]).astype(np.int64)
        self.points = np.unique(np.concatenate([self.triangles.ravel(), self.edges.ravel()]))
        self.body_of = np.repeat(np.arange(len(self.bodies)), [b.vertex_count for b in self.bodies])
        #: Contact distance of each body [m]; two act on each other within the sum of theirs.
        self.distance = np.array([body.contact_distance for body in self.bodies])
        self.allowed = np.ones((len(self.bodies),) * 2, dtype=bool)
        for a, b in run.scene["pairs_without_contact"]:
            self.allowed[a, b] = self.allowed[b, a] = False
        if not run.scene["contact_enabled"]:
            self.allowed[:] = False
        #: Points that are kept from a body (N, bodies), None if there are none.
        self.kept = self._kept_from(run.scene["attachments"])

    def _placed(self) -> list[tuple[Body, int]]:
        return list(zip(self.bodies, self.starts[:-1].tolist(), strict=True))

    def _kept_from(self, attachments: list[dict[str, Any]]) -> NDArray[np.bool_] | None:
        """Attached vertices do not touch the body on the other side (docs/attachments.md)."""
        if not attachments:
            return None
        kept = np.zeros((int(self.starts[-1]), len(self.bodies)), dtype=bool)

        def keep(points: dict[str, Any], other: int | None) -> None:
            if other is None or "body" not in points:
                return
            vertices = np.array(points.get("vertices", []), dtype=np.int64)
            if points["kind"] == "embedded":
                supports, weights = np.array(points["supports"]), np.array(points["weights"])
                vertices = supports[weights != 0.0]
            kept[self.starts[points["body"]] + vertices, other] = True

        for attachment in attachments:
            a = attachment["a"]
            for b in attachment["b"]:
                keep(a, b.get("body"))
                keep(b, a.get("body"))
            if "patches" in attachment:
                patch_body = attachment["patch_body"]
                keep(a, patch_body)
                vertices = np.array(attachment["patches"]).ravel()
                keep({"kind": "vertices", "body": patch_body, "vertices": vertices}, a.get("body"))
        return kept

    # --- pairs ---

    def distance_pairs(self, low: Floats, high: Floats) -> dict[Kind, PairList]:
        """Pairs whose distance counts and whose boxes overlap, from boxes of all points (N, 3)."""
        triangles, edges = self._tree(self.triangles, low, high), self._tree(self.edges, low, high)
        points = self._tree(self.points[:, None], low, high)
        return {
            Kind.POINT_TRIANGLE: self._pairs(points, self.points[:, None], triangles, self.triangles),
            Kind.EDGE_EDGE: self._pairs(edges, self.edges, edges, self.edges),
        }

    def edge_triangle_pairs(self, x: Floats) -> PairList:
        """Pairs of edges and triangles whose boxes overlap: five points each."""
        edges, triangles = self._tree(self.edges, x, x), self._tree(self.triangles, x, x)
        return self._pairs(edges, self.edges, triangles, self.triangles)

    def _tree(self, primitives: Integers, low: Floats, high: Floats) -> BoxTree:
        bodies = self.body_of[primitives[:, 0]] if len(primitives) else np.zeros(0, dtype=np.int64)
        return BoxTree(low[primitives].min(axis=1), high[primitives].max(axis=1), bodies, len(self.bodies))

    def _pairs(self, tree_a: BoxTree, a: Integers, tree_b: BoxTree, b: Integers) -> PairList:
        i, j = overlapping_pairs(tree_a, tree_b, self.allowed)
        first, second = a[i], b[j]
        shared = np.zeros(len(i), dtype=bool)
        for column_a in first.T:
            for column_b in second.T:
                shared |= column_a == column_b
        first, second = first[~shared], second[~shared]
        bodies = np.column_stack([self.body_of[first[:, 0]], self.body_of[second[:, 0]]])
        if self.kept is not None:
            out = self.kept[first, bodies[:, 1:]].any(axis=1) | self.kept[second, bodies[:, :1]].any(axis=1)
            first, second, bodies = first[~out], second[~out], bodies[~out]
        return PairList(np.concatenate([first, second], axis=1), bodies, a.shape[1])

    # --- names ---

    def names(self, pairs: PairList, row: int) -> dict[str, Any]:
        """Bodies and vertices of a pair, for a reader."""
        a, b = pairs.bodies[row].tolist()
        first, second = pairs.points[row, : pairs.first], pairs.points[row, pairs.first :]
        return {
            "bodies": [self.bodies[a].name, self.bodies[b].name],
            "vertices": [(first - self.starts[a]).tolist(), (second - self.starts[b]).tolist()],
        }


def _edges(body: Body) -> Integers:
    """Edges of the triangles, each once, and those of rods (k, 2)."""
    sides = np.concatenate([body.triangles[:, [0, 1]], body.triangles[:, [1, 2]], body.triangles[:, [2, 0]]])
    return np.unique(np.sort(np.concatenate([sides, body.edges]).astype(np.int64), axis=1), axis=0)
