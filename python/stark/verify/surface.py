"""All collision primitives of a scene in one numbering, and the pairs of them that are near."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .boxes import BoxTree, group_table, overlapping_pairs
from .distances import Kind
from .files import need
from .run import Body, Run

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


_RINGS = 2  #: edges from what carries an attached point of its own body to what it is still kept from


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
        self.starts: NDArray[Any] = np.cumsum([0, *(body.vertex_count for body in self.bodies)])
        self.triangles: NDArray[Any] = np.concatenate([b.triangles + s for b, s in self._placed()]).astype(
            np.int64
        )
        self.edges: NDArray[Any] = np.concatenate([_edges(b) + s for b, s in self._placed()]).astype(np.int64)
        self.points: NDArray[Any] = np.unique(np.concatenate([self.triangles.ravel(), self.edges.ravel()]))
        self.body_of: NDArray[Any] = np.repeat(
            np.arange(len(self.bodies)), [b.vertex_count for b in self.bodies]
        )
        #: Contact distance of each body [m]; two act on each other within the sum of theirs.
        self.distance: NDArray[Any] = np.array([body.contact_distance for body in self.bodies])
        #: Along each body, the length within which parts of it do not touch [m].
        self.untouched: Floats = np.array([length_without_contact(body) for body in self.bodies])
        #: Where the points of rods are along them at rest [m].
        self.along: Floats = np.zeros(int(self.starts[-1]))
        for body, start in self._placed():
            if body.edge_lengths is not None:
                places = np.cumsum([0.0, *body.edge_lengths])
                self.along[start : start + len(places)] = places
        #: Bodies that are not excluded for good.
        self.can_touch: NDArray[Any] = np.ones((len(self.bodies),) * 2, dtype=bool)
        for a, b in run.scene["pairs_without_contact"]:
            self.can_touch[a, b] = self.can_touch[b, a] = False
        #: What joints and attachments keep from contact, in the order in which states have it.
        self.exclusions: list[tuple[int, int, int]] = exclusions(run.scene, self.can_touch)
        if not run.scene["contact_enabled"]:
            self.can_touch[:] = False
        #: Of bodies attached to themselves, what their vertices are kept from.
        self._near: dict[tuple[int, int], Integers] = near_attachments(run.scene, run.bodies)
        self._regained: bytes | None = None
        #: What is allowed, and the table of that, which is as large as there are pairs of bodies.
        self._table: tuple[NDArray[np.bool_], NDArray[np.bool_]] | None = None
        self.watch(None)

    def watch(self, regained: NDArray[np.int8] | None) -> None:
        """Leaves out what is excluded in a step, by ``State.regained``; None: all exclusions."""
        rows = np.zeros(len(self.exclusions), dtype=np.int8) if regained is None else regained
        need(
            rows.shape == (len(self.exclusions),),
            f"contact_regained of {rows.shape} states has no entry for each of {len(self.exclusions)} "
            f"exclusions",
        )
        if rows.tobytes() == self._regained:
            return
        self._regained = rows.tobytes()
        self.allowed: NDArray[Any] = self.can_touch.copy()
        #: Points that are kept from a body (N, bodies), None if there are none.
        self.kept: NDArray[np.bool_] | None = None
        local = [np.zeros(0, dtype=np.int64)]
        for (body, vertex, other), back in zip(self.exclusions, rows.tolist(), strict=True):
            if back:
                continue
            if vertex < 0:
                self.allowed[body, other] = self.allowed[other, body] = False
                continue
            if body == other:
                start = int(self.starts[body])
                local.append((start + vertex) * int(self.starts[-1]) + start + self._near[body, vertex])
                continue
            if self.kept is None:
                self.kept = np.zeros((int(self.starts[-1]), len(self.bodies)), dtype=bool)
            self.kept[self.starts[body] + vertex, other] = True
        #: Pairs of points, as codes, whose primitives are kept from each other.
        self.kept_pairs: Integers = np.unique(np.concatenate(local))

    def _placed(self) -> list[tuple[Body, int]]:
        return list(zip(self.bodies, self.starts[:-1].tolist(), strict=True))

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

    def edge_triangle_pairs_of(self, a: int, b: int, x: Floats) -> PairList:
        """The same of two bodies, whatever is excluded."""
        allowed, kept, pairs = self.allowed, self.kept, self.kept_pairs
        self.allowed = np.zeros_like(allowed)
        self.kept, self.kept_pairs = None, pairs[:0]
        self.allowed[a, b] = self.allowed[b, a] = True
        try:
            return self.edge_triangle_pairs(x)
        finally:
            self.allowed, self.kept, self.kept_pairs = allowed, kept, pairs

    def _tree(self, primitives: Integers, low: Floats, high: Floats) -> BoxTree:
        bodies = self.body_of[primitives[:, 0]] if len(primitives) else np.zeros(0, dtype=np.int64)
        lowest, highest = low[primitives[:, 0]], high[primitives[:, 0]]
        for column in primitives.T[1:]:
            np.minimum(lowest, low[column], out=lowest)
            np.maximum(highest, high[column], out=highest)
        return BoxTree(lowest, highest, bodies, len(self.bodies))

    def _pairs(self, tree_a: BoxTree, a: Integers, tree_b: BoxTree, b: Integers) -> PairList:
        if self._table is None or self._table[0] is not self.allowed:
            self._table = self.allowed, group_table(self.allowed)
        i, j = overlapping_pairs(tree_a, tree_b, self._table[1])
        first, second = a[i], b[j]
        shared = np.zeros(len(i), dtype=bool)
        for column_a in first.T:
            for column_b in second.T:
                shared |= column_a == column_b
        if a.shape[1] == b.shape[1] == 2 and self.untouched.any():
            shared |= self._are_near_along(first, second)
        if len(self.kept_pairs):
            shared |= self._are_kept_apart(first, second)
        first, second = first[~shared], second[~shared]
        bodies = np.column_stack([self.body_of[first[:, 0]], self.body_of[second[:, 0]]])
        if self.kept is not None:
            out = self.kept[first, bodies[:, 1:]].any(axis=1) | self.kept[second, bodies[:, :1]].any(axis=1)
            first, second, bodies = first[~out], second[~out], bodies[~out]
        return PairList(np.concatenate([first, second], axis=1), bodies, a.shape[1])

    def _are_kept_apart(self, first: Integers, second: Integers) -> NDArray[np.bool_]:
        """Pairs at what attaches a body to itself."""
        count = int(self.starts[-1])
        out = np.zeros(len(first), dtype=bool)
        rows = np.flatnonzero(self.body_of[first[:, 0]] == self.body_of[second[:, 0]])
        a, b = first[rows][:, :, None], second[rows][:, None, :]
        for codes in (a * count + b, b * count + a):
            out[rows] |= np.isin(codes, self.kept_pairs).any(axis=(1, 2))
        return out

    def _are_near_along(self, first: Integers, second: Integers) -> NDArray[np.bool_]:
        """Pairs of edges of one rod that no contact keeps apart."""
        rods = self.body_of[first[:, 0]]
        apart = np.abs(self.along[first[:, :, None]] - self.along[second[:, None, :]]).min(axis=(1, 2))
        near: NDArray[np.bool_] = (rods == self.body_of[second[:, 0]]) & (apart < self.untouched[rods])
        return near

    # --- names ---

    def names(self, pairs: PairList, row: int) -> dict[str, Any]:
        """Bodies and vertices of a pair, for a reader."""
        a, b = pairs.bodies[row].tolist()
        first, second = pairs.points[row, : pairs.first], pairs.points[row, pairs.first :]
        return {
            "bodies": [self.bodies[a].name, self.bodies[b].name],
            "vertices": [(first - self.starts[a]).tolist(), (second - self.starts[b]).tolist()],
        }


def length_without_contact(body: Body) -> float:
    """Along a rod: half a turn of its tightest bend, at its contact distance (docs/rods.md) [m]."""
    return 0.0 if body.edge_lengths is None else math.pi * body.contact_distance


def leaves_out_parts(body: Body) -> bool:
    """Whether edges of a rod that do not meet are that near along it."""
    lengths = body.edge_lengths
    return lengths is not None and len(lengths) > 2 and lengths[1:-1].min() < length_without_contact(body)


def _edges(body: Body) -> Integers:
    """Edges of the triangles, each once, and those of rods (k, 2)."""
    sides = np.concatenate([body.triangles[:, [0, 1]], body.triangles[:, [1, 2]], body.triangles[:, [2, 0]]])
    return np.unique(np.sort(np.concatenate([sides, body.edges]).astype(np.int64), axis=1), axis=0)


def _carriers(points: dict[str, Any]) -> list[Integers]:
    """Of attached points: the vertices that each is, or that carry it; none on rigid bodies and the world."""
    if points["kind"] == "embedded":
        supports, weights = np.array(points["supports"]), np.array(points["weights"])
        return [row[weight != 0.0].astype(np.int64) for row, weight in zip(supports, weights, strict=True)]
    if points["kind"] == "vertices":
        return list(np.array(points["vertices"], dtype=np.int64).reshape(-1, 1))
    return [np.zeros(0, dtype=np.int64)] * len(np.array(points["local"]).reshape(-1, 3))


def near_attachments(scene: dict[str, Any], bodies: list[Body]) -> dict[tuple[int, int], Integers]:
    """Of bodies attached to themselves: by body and attached vertex what the vertex is kept from, those that
    carry what it is attached to and those up to two edges from them (docs/attachments.md)."""
    carriers: dict[tuple[int, int], set[int]] = {}
    for attachment in scene["attachments"]:
        body = attachment["a"].get("body")
        for a, b in _pairs_within(attachment, body):
            for ends, others in ((a, b), (b, a)):
                for v in ends.tolist():
                    carriers.setdefault((body, v), set()).update(others.tolist())
    edges = {body: _edges(bodies[body]) for body, _ in carriers}
    return {key: _rings_around(carriers[key], edges[key[0]]) for key in carriers}


def _pairs_within(attachment: dict[str, Any], body: int | None) -> list[tuple[Integers, Integers]]:
    """Carriers of both ends, of the pairs that attach a body to itself."""
    of_a = _carriers(attachment["a"])
    if body is None:
        return []
    if "patches" in attachment:
        patches = [np.array(patch, dtype=np.int64) for patch in attachment["patches"]]
        return list(zip(of_a, patches, strict=True)) if attachment["patch_body"] == body else []
    of_b = [(b.get("body"), carriers) for b in attachment["b"] for carriers in _carriers(b)]
    return [(a, b) for a, (other, b) in zip(of_a, of_b, strict=True) if other == body]


def _rings_around(vertices: set[int], edges: Integers) -> Integers:
    found = np.array(sorted(vertices), dtype=np.int64)
    for _ in range(_RINGS):
        hit = np.isin(edges, found).any(axis=1)
        found = np.unique(np.concatenate([found, edges[hit].ravel()]))
    return found


def exclusions(scene: dict[str, Any], can_touch: NDArray[np.bool_]) -> list[tuple[int, int, int]]:
    """What joints and attachments keep from contact while they hold, sorted: (body, -1, other) two bodies,
    (body, vertex, other) a vertex and a body, or of its own body what is near there (docs/attachments.md)."""
    found: set[tuple[int, int, int]] = set()

    def keep_bodies(sides: list[dict[str, Any]], contact: bool) -> None:
        bodies = sorted({side["body"] for side in sides if "body" in side})
        if not contact and len(bodies) == 2:
            found.add((bodies[0], -1, bodies[1]))

    def keep(points: dict[str, Any], other: int | None) -> None:
        if other is None or "body" not in points:
            return
        found.update((points["body"], v, other) for carriers in _carriers(points) for v in carriers.tolist())

    for joint in scene.get("joints", []):
        keep_bodies([joint["a"], joint["b"]], joint.get("contact", True))
    for attachment in scene["attachments"]:
        a, patches = attachment["a"], []
        for b in attachment["b"]:
            keep(a, b.get("body"))
            keep(b, a.get("body"))
        if "patches" in attachment:
            vertices = np.array(attachment["patches"]).ravel()
            patches = [{"kind": "vertices", "body": attachment["patch_body"], "vertices": vertices}]
            keep(a, attachment["patch_body"])
            keep(patches[0], a.get("body"))
        keep_bodies([a, *attachment["b"], *patches], attachment.get("contact", True))
    return sorted(entry for entry in found if can_touch[entry[0], entry[2]])
