"""``scene.attach``: which points are attached, and what carries them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark import _core
from stark._core import InvalidArgument
from stark.arguments import as_array, given_flag, given_name
from stark.attachments.handle import Attachment
from stark.bodies import Body
from stark.body_kinds import has_frames, has_points, has_pose, row_of
from stark.handle import SceneLink
from stark.joined_points import JoinedPoints
from stark.selections import Points, Stencils, local_points, node_frame, vertex_points, world_points

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

_COINCIDENT = 1e-9  # [m] below which points count as being at the same place


def attach(
    scene: SceneLink,
    a: Any,
    b: Any,
    *,
    distance: float | None,
    pairs: ArrayLike | None,
    break_force: float | None,
    contact: bool,
    enabled: bool,
    name: str | None,
) -> Attachment:
    """Adds an attachment to a scene; InvalidArgument says what is wrong with it."""
    owner = "attachment" if name is None else f"attachment '{name}'"
    contact = given_flag(contact, f"{owner}: contact")
    side_a, side_b = _side(scene, owner, "a", a), _side(scene, owner, "b", b)
    if pairs is not None:
        if distance is not None:
            raise InvalidArgument(f"{owner}: pairs and distance are both given: give one of them")
        points, side_b = _indexed(owner, side_a, side_b, pairs)
    else:
        points = _points_of(owner, side_a, distance)
    if distance is not None and not (_is_number(distance) and 0.0 <= distance < math.inf):
        raise InvalidArgument(f"{owner}: distance = {distance!r} m: must be a finite number >= 0")
    points, description = _carried(owner, points, side_b, distance)
    description |= {"enabled": given_flag(enabled, f"{owner}: enabled"), "contact": contact}
    return _added(scene, owner, points, description, break_force=break_force, name=name)


def sew(
    scene: SceneLink,
    a: Any,
    b: Any,
    *,
    pairs: ArrayLike | None,
    break_force: float | None,
    name: str | None,
) -> tuple[Attachment, Points]:
    """Adds an attachment of pairs that are to meet, and gives its side b; InvalidArgument says what is wrong
    with it."""
    owner = "seam" if name is None else f"seam '{name}'"
    points, others = _side(scene, owner, "a", a), _side(scene, owner, "b", b)
    if pairs is not None:
        points, others = _indexed(owner, points, others, pairs)
    if not isinstance(points, Points) or not isinstance(others, Points):
        raise InvalidArgument(
            f"{owner}: must be two bodies with pairs=, or points of both sides, such as "
            f"front.vertices[left] and back.vertices[right]"
        )
    if len(points) != len(others):
        raise InvalidArgument(
            f"{owner}: {len(points)} points and {len(others)} points: must be as many, as each is sewn to one"
        )
    description = {"b": [others._description()], "enabled": False, "contact": True, "sewn": True}
    return _added(scene, owner, points, description, break_force=break_force, name=name), others


def _added(
    scene: SceneLink,
    owner: str,
    points: Points,
    description: dict[str, Any],
    *,
    break_force: float | None,
    name: str | None,
) -> Attachment:
    given = {
        "name": given_name(name),
        "a": points._description(),
        "break_force": _break_force(owner, break_force),
        "sewn": False,
        **description,
    }
    index = scene._core.add_attachment(given)
    return Attachment(scene, index, points, given)


# --- sides ---


def _side(scene: SceneLink, owner: str, label: str, side: Any) -> Body | Points | None:
    """A body, points, or None for the world."""
    if isinstance(side, str):
        side = scene[side] if side != "world" or "world" in scene else None
    if isinstance(side, Stencils):
        side = _corners(owner, label, side)
    if side is None and label == "b":
        return None
    if isinstance(side, JoinedPoints):
        raise InvalidArgument(
            f"{owner}: side {label} = {side!r}: must be points of one body; those that frames of a rod carry "
            f"are held by joints, scene.add_ball(rod.frame(node, position=...), other), those of several "
            f"bodies by an attachment for each"
        )
    if not isinstance(side, (Body, Points)):
        rest = ", or None for the world" if label == "b" else ""
        raise InvalidArgument(
            f"{owner}: side {label} = {side!r}: must be a body or points of one, such as "
            f"cloth.vertices[[0, 5]]{rest}"
        )
    if isinstance(side, Points) and (side.is_direction or side._kind == "node_direction"):
        raise InvalidArgument(f"{owner}: side {label}: directions cannot be attached: must be points")
    body = side.body if isinstance(side, Points) else side
    if body is not None and body._scene is not scene:
        raise InvalidArgument(
            f"{owner}: side {label}: '{body.name}' belongs to another scene: must be a body of this one"
        )
    return side


def _corners(owner: str, label: str, stencils: Stencils) -> Points:
    """The vertices of stencils, each once."""
    body = stencils.columns[0].body
    if body is None or any(c.body is not body or c._kind != "vertices" for c in stencils.columns):
        raise InvalidArgument(f"{owner}: side {label} = {stencils!r}: must be of vertices of one body")
    return vertex_points(body, np.unique([c._columns["vertices"] for c in stencils.columns]).astype(np.int32))


def _all_vertices(body: Body) -> Points:
    """Those of its surface; of rigid bodies as points fixed to them."""
    if has_pose(body):
        return local_points(body, np.asarray(body.mesh.vertices))
    if row_of(body).has_triangles:
        return vertex_points(body, np.unique(body.triangles).astype(np.int32))
    return body.vertices


def _points_of(owner: str, side: Body | Points | None, distance: float | None) -> Points:
    assert side is not None
    if isinstance(side, Points):
        return side
    if distance is None:
        raise InvalidArgument(
            f"{owner}: side a is all of '{side.name}': say which of its points: give distance= [m], pairs=, "
            f"or points such as {side.name}.vertices[[0, 5]]"
        )
    return _all_vertices(side)


def _indexed(
    owner: str, a: Body | Points | None, b: Body | Points | None, pairs: ArrayLike
) -> tuple[Points, Points]:
    """Vertices of two bodies by index."""
    if not isinstance(a, Body) or not isinstance(b, Body):
        raise InvalidArgument(f"{owner}: pairs are indices of vertices: both sides must be bodies")
    rows = as_array(pairs, f"{owner}: pairs")
    if rows.ndim != 2 or rows.shape[1] != 2 or rows.dtype.kind not in "iu":
        raise InvalidArgument(
            f"{owner}: pairs of shape {rows.shape} and type {rows.dtype}: must be integers of shape (n, 2)"
        )
    chosen = []
    for body, column in zip((a, b), rows.T, strict=True):
        count = len(body.mesh.vertices)
        wrong = column[(column < 0) | (column >= count)]
        if wrong.size:
            raise InvalidArgument(
                f"{owner}: pairs: vertex {wrong[0]} of '{body.name}': must be in [0, {count})"
            )
        if has_pose(body):
            chosen.append(local_points(body, np.asarray(body.mesh.vertices)[column]))
        else:
            chosen.append(vertex_points(body, column.astype(np.int32)))
    return chosen[0], chosen[1]


# --- what carries them ---


def _carried(
    owner: str, points: Points, b: Body | Points | None, distance: float | None
) -> tuple[Points, dict[str, Any]]:
    """The points that are attached, and what carries them as the core reads it."""
    for name, side in (("a", points), ("b", b)):
        if isinstance(side, Points) and not len(side):
            raise InvalidArgument(
                f"{owner}: side {name} has 0 points: must have at least one; check the selection of points"
            )
    places = points.positions
    if b is None:
        return points, {"b": [world_points(places)._description()]}
    if isinstance(b, Points):
        rows, partners = _partners(owner, places, b, distance)
        points, places, b = points[rows], places[rows], b[partners]
        if np.linalg.norm(b.positions - places, axis=1).max() <= _COINCIDENT:
            return points, {"b": [b._description()]}
        return points, _on_partners(owner, b, places)
    if points.body == b and has_points(b):
        raise InvalidArgument(f"{owner}: both sides are '{b.name}': give pairs= or points for side b")
    near, carriers, gaps = _nearest(b, places)
    if distance is not None:
        rows = np.flatnonzero(gaps <= distance)
        if rows.size == 0:
            raise InvalidArgument(
                f"{owner}: no point is within distance = {distance:g} m of '{b.name}': the nearest is "
                f"{gaps.min():.3g} m away; raise distance, or move the bodies together"
            )
        points, places, near = points[rows], places[rows], near[rows]
    return points, carriers(near, places)


def _partners(owner: str, places: Floats, b: Points, distance: float | None) -> tuple[Any, Any]:
    """Rows of both sides that belong together."""
    count = len(places)
    if distance is None:
        if len(b) not in (1, count):
            raise InvalidArgument(
                f"{owner}: {count} points on {len(b)} points: must be as many, or one; give distance= [m] "
                f"for the nearest ones"
            )
        return np.arange(count), np.arange(count) if len(b) == count else np.zeros(count, dtype=np.intp)
    targets = b.positions
    nearest = np.array([int(np.argmin(np.einsum("ij,ij->i", targets - p, targets - p))) for p in places])
    gaps = np.linalg.norm(targets[nearest] - places, axis=1)
    rows = np.flatnonzero(gaps <= distance)
    if rows.size == 0:
        raise InvalidArgument(
            f"{owner}: no two points are within distance = {distance:g} m: the nearest are {gaps.min():.3g} "
            f"m apart; raise distance, or move the bodies together"
        )
    return rows, nearest[rows]


def _on_partners(owner: str, b: Points, places: Floats) -> dict[str, Any]:
    """What carries places that are apart from the points of b: their body, node or a triangle at them."""
    body = b.body
    if body is None:
        raise InvalidArgument(
            f"{owner}: points of the world are up to "
            f"{np.linalg.norm(b.positions - places, axis=1).max():.3g} m from side a: must be at the same "
            f"places; leave them to scene.attach(a, None)"
        )
    assert isinstance(body, Body)
    if has_pose(body):
        return _on_rigid(body, places)
    if has_frames(body):
        nodes = b._columns.get("vertices", np.full(len(b), b._columns.get("node", 0)))
        return _on_nodes(body, nodes, places)
    if b._kind == "embedded":
        return _on_patches(body, b._columns["supports"][:, :3], places)
    triangles = body.triangles
    first = np.full(len(body.mesh.vertices), -1, dtype=np.int64)  # a triangle of each vertex
    first[triangles[::-1].ravel()] = np.repeat(np.arange(len(triangles))[::-1], 3)
    chosen = first[b._columns["vertices"]]
    if (chosen < 0).any():
        inner = b._columns["vertices"][np.flatnonzero(chosen < 0)[0]]
        raise InvalidArgument(
            f"{owner}: vertex {inner} of '{body.name}' is inside, apart from the point that it carries: must "
            f"be of the surface, or at the same place"
        )
    return _on_patches(body, triangles[chosen], places)


def _nearest(body: Body, places: Floats) -> tuple[Any, Any, Floats]:
    """Nearest carrier of each place, what makes a description of some of them, distances [m]."""
    if has_frames(body):
        gaps = np.linalg.norm(places[:, None] - _start(body)[None], axis=2)
        nodes = gaps.argmin(axis=1)
        return nodes, lambda rows, x: _on_nodes(body, rows, x), gaps.min(axis=1)
    triangles = np.ascontiguousarray(body.triangles, dtype=np.int32)
    chosen, gaps = _core.find_closest_triangles(np.ascontiguousarray(places), _start(body), triangles)
    if has_pose(body):
        return chosen, lambda _, x: _on_rigid(body, x), gaps
    return chosen, lambda rows, x: _on_patches(body, triangles[rows], x), gaps


def _start(body: Body) -> Floats:
    return body._scene._core.initial_positions(body._index)


def _on_rigid(body: Body, places: Floats) -> dict[str, Any]:
    position, rotation = body._scene._core.pose(body._index)
    return {"b": [local_points(body, (places - position) @ rotation)._description()]}


def _on_nodes(rod: Body, nodes: Any, places: Floats) -> dict[str, Any]:
    frames = rod._scene._core.initial_frames(rod._index).reshape(-1, 3, 3)
    origins = _start(rod)
    carriers = [
        node_frame(rod, int(node), frames[node].T @ (place - origins[node]), None).columns[0]
        for node, place in zip(nodes, places, strict=True)
    ]
    return {"b": [carrier._description() for carrier in carriers]}


def _on_patches(body: Body, patches: Integers, places: Floats) -> dict[str, Any]:
    rows = np.ascontiguousarray(patches, dtype=np.int32)
    assert len(rows) == len(places)
    return {"b": [], "patch_body": body._index, "patches": rows}


def _break_force(owner: str, force: float | None) -> float:
    if force is None:
        return math.inf
    if not _is_number(force) or not force > 0.0:
        raise InvalidArgument(
            f"{owner}: break_force = {force!r} N: must be a number > 0; leave it out for pairs that do not "
            f"break"
        )
    return float(force)


def _is_number(value: Any) -> bool:
    return (
        not isinstance(value, (list, tuple)) and np.ndim(value) == 0 and np.asarray(value).dtype.kind in "iuf"
    )
