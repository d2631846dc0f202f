"""Points of a scene for energies: ``cloth.vertices``, ``cloth.edges``, ``box.points(...)``, ``box.frame()``.

A selection of points or stencils is indexed like an array: ``cloth.vertices[:10]``, ``cloth.edges[mask]``.
Energies pair selections element by element; a selection of one goes with all elements of the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import as_array, real_array, refuse_masked, shown_value
from stark.handle import BodyHandle
from stark.rotations import as_matrix, vector

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


class Points:
    """n points of a body or of the world. Made by the properties of bodies."""

    point_count = 1

    def __init__(
        self, body: BodyHandle | None, kind: str, columns: dict[str, Any], initial: Callable[[Points], Floats]
    ) -> None:
        self.body = body
        """The body whose points they are, None for points of the world."""
        self._kind = kind
        self._columns = columns  # arrays with a row for each point
        self._initial = initial
        self.is_direction: bool = kind == "direction"
        """Whether the positions are directions, which do not move with the origin."""

    def __len__(self) -> int:
        return len(next(iter(self._columns.values())))

    def __getitem__(self, key: Any) -> Points:
        """Some of the points: an index, a slice, indices or a mask. An index gives a set of one point."""
        rows = rows_of(key, len(self), repr(self))
        columns = {k: v if k == "node" else v[rows] for k, v in self._columns.items()}
        chosen = Points(self.body, self._kind, columns, self._initial)
        chosen.is_direction = self.is_direction
        return chosen

    @property
    def bodies(self) -> list[BodyHandle]:
        """The body whose points they are; empty for points of the world."""
        return [] if self.body is None else [self.body]

    @property
    def owners(self) -> NDArray[np.int64]:
        """What carries the frame of the rest positions: a number of the body, or of the node of a rod, for
        all points (1, 2)."""
        body = -1 if self.body is None else self.body._index
        return np.array([[body, self._columns.get("node", -1)]])

    @property
    def positions(self) -> Floats:
        """In the world at time 0 (n, 3) [m]; of directions, the directions."""
        return self._initial(self)

    @property
    def rest_positions(self) -> Floats:
        """In the frame of the body's mesh (n, 3) [m]."""
        places: Floats
        if "local" in self._columns:
            places = self._columns["local"]
            return places
        assert self.body is not None
        vertices = self.body.mesh.vertices
        if "vertices" in self._columns:
            places = vertices[self._columns["vertices"]]
        else:
            places = np.einsum("ni,nij->nj", self._columns["weights"], vertices[self._columns["supports"]])
        return places

    @property
    def placed_rest_positions(self) -> Floats:
        """Where the points would be at time 0 if their body were in its rest shape (n, 3) [m]."""
        if self.body is None or self.body._rest_placement is None:
            return self.positions
        position, rotation = self.body._rest_placement
        placed: Floats = np.asarray(position) + self.rest_positions @ np.asarray(rotation).T
        return placed

    def _description(self) -> dict[str, Any]:
        """As the core reads it."""
        body = {} if self.body is None else {"body": self.body._index}
        return {"kind": self._kind, **body, **self._columns}

    def __repr__(self) -> str:
        owner = "the world" if self.body is None else f"'{self.body.name}'"
        return f"<{len(self)} points of {owner}>"


class Stencils:
    """n stencils of k points each: edges, triangles, tetrahedra, hinges, or any points in columns."""

    def __init__(self, columns: Sequence[Any], noun: str = "stencils") -> None:
        self.columns: tuple[Any, ...] = tuple(columns)
        """k selections of points, equally long or of one point."""
        self._noun = noun
        counts = {len(c) for c in columns} - {1}
        if len(counts) > 1:
            raise InvalidArgument(
                f"stencil of {' and '.join(map(repr, columns))}: the selections must be equally long, or "
                f"have one point"
            )

    @property
    def point_count(self) -> int:
        """Number of points of each stencil."""
        return len(self.columns)

    def __len__(self) -> int:
        return max((len(c) for c in self.columns), key=lambda n: (n != 1, n))

    def __getitem__(self, key: Any) -> Stencils:
        """Some of the stencils: an index, a slice, indices or a mask."""
        rows = rows_of(key, len(self), repr(self))
        columns = [c if len(c) == 1 and len(self) != 1 else c[rows] for c in self.columns]
        return Stencils(columns, self._noun)

    def __repr__(self) -> str:
        owners = dict.fromkeys(
            owner for c in self.columns for owner in ([f"'{b.name}'" for b in c.bodies] or ["the world"])
        )
        return f"<{len(self)} {self._noun} of {self.point_count} points of {' and '.join(owners)}>"


class FrameHandle:
    """A frame for an argument ``stark.Frame``, or n frames. Made by ``frame`` of bodies."""

    def __init__(self, kind: str, columns: Sequence[Points], constants: dict[str, Floats]) -> None:
        self.kind = kind
        self.columns: tuple[Points, ...] = tuple(columns)
        self.constants = constants

    def __len__(self) -> int:
        return len(self.columns[0])

    def __repr__(self) -> str:
        body = self.columns[0].body
        return f"<frame of {'the world' if body is None else repr(body.name)}>"


# --- of bodies ---


def vertex_points(body: BodyHandle, vertices: Integers) -> Points:
    """Vertices of the body's mesh."""
    return Points(
        body, "vertices", {"vertices": vertices}, lambda p: _vertices_at_start(body)[p._columns["vertices"]]
    )


def stencils(body: BodyHandle, indices: ArrayLike, noun: str = "stencils") -> Stencils:
    """Stencils of vertices of one body from an index array (n, k)."""
    if not isinstance(body, BodyHandle):
        raise InvalidArgument(
            f"stark.stencils(body, indices): body = {shown_value(body)}: must be a body of the scene; the "
            f"indices (n, k) count its vertices"
        )
    given = as_array(indices, f"'{body.name}': stencils")
    if given.ndim != 2 or given.dtype.kind not in "iu" or given.shape[1] < 1:
        raise InvalidArgument(
            f"'{body.name}': stencils of shape {given.shape} and type {given.dtype}: must be integers of "
            f"shape (n, k), the vertices of n stencils of k points"
        )
    _check_vertices(body, given)
    rows = given.astype(np.int32)
    return Stencils([vertex_points(body, np.ascontiguousarray(column)) for column in rows.T], noun)


def local_points(body: BodyHandle, local: ArrayLike) -> Points:
    """Points fixed to a rigid body (n, 3), in the frame of its mesh [m]."""

    def initial(points: Points) -> Floats:
        position, rotation = body._scene._core.pose(body._index)
        placed: Floats = position + points._columns["local"] @ np.asarray(rotation).T
        return placed

    return Points(body, "point", {"local": _point_rows(local, f"'{body.name}': points")}, initial)


def local_directions(body: BodyHandle, local: ArrayLike) -> Points:
    """Directions fixed to a rigid body (n, 3), in the frame of its mesh; they count as points whose position
    is the direction in the world."""

    def initial(points: Points) -> Floats:
        turned: Floats = points._columns["local"] @ np.asarray(body._scene._core.pose(body._index)[1]).T
        return turned

    return Points(body, "direction", {"local": _point_rows(local, f"'{body.name}': directions")}, initial)


def embedded_points(body: BodyHandle, supports: Integers, weights: ArrayLike) -> Points:
    """Points of elements of a cloth or a solid: vertices (n, k) of the elements, k <= 4, and barycentric
    coordinates (n, k) or (k,) that sum to 1."""
    count, k = supports.shape
    given = real_array(weights, f"'{body.name}': barycentric weights")
    try:
        given = np.broadcast_to(given, (count, k))
    except ValueError:
        raise InvalidArgument(
            f"'{body.name}': barycentric weights of shape {given.shape}: must be ({count}, {k}) or ({k},)"
        ) from None
    # Absent supports repeat the first vertex with weight zero.
    filled = np.repeat(supports[:, :1], 4, axis=1)
    filled[:, :k] = supports
    padded = np.zeros((count, 4))
    padded[:, :k] = given

    def initial(points: Points) -> Floats:
        vertices = _vertices_at_start(body)[points._columns["supports"]]
        embedded: Floats = np.einsum("ni,nij->nj", points._columns["weights"], vertices)
        return embedded

    return Points(body, "embedded", {"supports": filled.astype(np.int32), "weights": padded}, initial)


def world_points(positions: ArrayLike) -> Points:
    """Points of the world that do not move (n, 3) or (3,) [m]."""
    rows = _point_rows(positions, "world points")
    return Points(None, "world", {"local": rows}, lambda p: p._columns["local"])


# --- frames ---


def rigid_frame(body: BodyHandle, position: ArrayLike, rotation: ArrayLike | None) -> FrameHandle:
    """Frame fixed to a rigid body; position [m] and rotation in the frame of its mesh."""
    owner = f"'{body.name}': frame"
    axes = as_matrix(rotation, f"{owner}: rotation")
    origin = vector(position, f"{owner}: position")
    columns = [local_points(body, origin), *(local_directions(body, axes[:, i]) for i in range(3))]
    return FrameHandle("sites", columns, {})


def node_frame(body: BodyHandle, node: int, position: ArrayLike, rotation: ArrayLike | None) -> FrameHandle:
    """Frame carried by a node of a rod; position [m] and rotation in the frame of the node, whose axes are
    d1, d2 of the section and d3 along the rod."""
    owner = f"'{body.name}': frame"
    count = len(body.mesh.vertices)
    if isinstance(node, bool) or not isinstance(node, (int, np.integer)) or not -count <= node < count:
        raise InvalidArgument(f"{owner}: node = {node!r}: must be the index of a node in [0, {count})")
    k = int(node) % count
    axes = as_matrix(rotation, f"{owner}: rotation")
    origin = vector(position, f"{owner}: position")
    columns = [node_points(body, k, origin[None])]
    columns += [node_points(body, k, axes[:, i][None].copy(), directions=True) for i in range(3)]
    return FrameHandle("sites", columns, {})


def node_points(body: BodyHandle, node: int, local: Floats, *, directions: bool = False) -> Points:
    """Points or directions (n, 3) carried by a node of a rod, in the frame of the node [m]."""

    def place(points: Points) -> Floats:
        frames = body._scene._core.initial_frames(body._index).reshape(-1, 3, 3)
        turned = points._columns["local"] @ frames[node].T
        placed: Floats = turned if points.is_direction else turned + _vertices_at_start(body)[node]
        return placed

    kind = "node_direction" if directions else "node_point"
    points = Points(body, kind, {"local": local, "node": node}, place)
    points.is_direction = directions
    return points


def world_frame(position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None) -> FrameHandle:
    """Frame of the world that does not move: position [m], rotation (matrix or quaternion)."""
    axes = as_matrix(rotation, "world_frame: rotation")
    columns = [world_points(vector(position, "world_frame: position"))]
    for i in range(3):
        columns.append(world_points(axes[:, i]))
        columns[-1].is_direction = True
    return FrameHandle("sites", columns, {})


def patch_frame(
    body: BodyHandle, vertices: ArrayLike, position: ArrayLike | None, rotation: ArrayLike | None
) -> FrameHandle:
    """Frame carried by a triangle of three vertices of a deformable body. position [m] and rotation are those
    in the world at time 0; without them, the centre of the triangle and the axes (along its first edge,
    across, normal)."""
    owner = f"'{body.name}': frame"
    corners = as_array(vertices, f"{owner}: vertices")
    if corners.shape != (3,) or corners.dtype.kind not in "iu" or len(set(corners.tolist())) < 3:
        raise InvalidArgument(
            f"{owner}: vertices = {corners.tolist()}: must be three different vertex indices"
        )
    _check_vertices(body, corners)
    x = _vertices_at_start(body)[corners]
    first, second = x[1] - x[0], x[2] - x[0]
    normal = np.cross(first, second)
    if not np.linalg.norm(normal) > 1e-10 * np.linalg.norm(first) * np.linalg.norm(second):
        raise InvalidArgument(
            f"{owner}: the vertices {corners.tolist()} are on one line: must span a triangle"
        )
    normal = normal / np.linalg.norm(normal)
    tangent = first / np.linalg.norm(first)
    axes = np.column_stack([tangent, np.cross(normal, tangent), normal])
    origin = x.mean(axis=0) if position is None else vector(position, f"{owner}: position")
    target = axes if rotation is None else as_matrix(rotation, f"{owner}: rotation")
    offset = float(normal @ (origin - x[0]))
    in_plane, *_ = np.linalg.lstsq(
        np.column_stack([first, second]), origin - x[0] - offset * normal, rcond=None
    )
    weights = np.array([1.0 - in_plane.sum(), *in_plane])
    columns = [vertex_points(body, np.array([v], dtype=np.int32)) for v in corners]
    constants = {"weights": weights, "offset": np.array([offset]), "rotation": (axes.T @ target).reshape(-1)}
    return FrameHandle("patch", columns, constants)


# --- details ---


def _vertices_at_start(body: BodyHandle) -> Floats:
    return body._scene._core.initial_positions(body._index)


def _point_rows(given: ArrayLike, owner: str) -> Floats:
    try:
        rows = real_array(given, owner)
    except InvalidArgument:
        raise InvalidArgument(f"{owner}: {given!r}: must be numbers of shape (n, 3) or (3,)") from None
    if rows.shape == (3,):
        rows = rows[None]
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise InvalidArgument(f"{owner}: got the shape {rows.shape}: must be (n, 3) or (3,)")
    return rows


def _check_vertices(body: BodyHandle, indices: NDArray[Any]) -> None:
    count = len(body.mesh.vertices)
    wrong = indices[(indices < 0) | (indices >= count)]
    if wrong.size:
        raise InvalidArgument(f"'{body.name}': vertex {wrong.flat[0]}: must be in [0, {count})")


def rows_of(key: Any, count: int, owner: str) -> NDArray[np.intp]:
    """Row numbers that an index, slice, list or mask selects; an empty list selects none, as an empty mask
    does."""
    refuse_masked(key, f"{owner}: the index")
    if isinstance(key, (list, tuple)):
        key = as_array(key, f"{owner}: the index")
    if isinstance(key, np.ndarray) and key.shape == (0,) and key.dtype != bool:
        key = np.zeros(0, dtype=np.intp)
    try:
        rows = np.atleast_1d(np.arange(count)[key])
    except (IndexError, TypeError, ValueError, OverflowError) as error:
        raise InvalidArgument(f"{owner}[{key!r}]: {error}") from None
    if rows.ndim != 1:
        raise InvalidArgument(f"{owner}: the index has {rows.ndim} dimensions: must have one")
    return rows
