"""Loops of links: the q, and places on floating and ball joints, at which what closes them does.

Gauss-Newton with the least step of the coordinates that may move (Nocedal and Wright, Numerical Optimization
(2006), 10.3) on the geometric Jacobian; Siciliano et al., Robotics (2009), 2.8.3 on closed chains."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.robots.base import placing
from stark.robots.description import Closure, RobotDescription
from stark.robots.inverse import rotation_vector
from stark.robots.kinematics import Placement, Values, cross, jacobian, limits_of, placements, turned
from stark.robots.link import RobotLink

Floats = NDArray[np.float64]


class Posture(NamedTuple):
    """Where a robot is whose base is given."""

    q: Floats
    free: Mapping[str, Placement]  # as of kinematics.placements: on floating and ball joints


Frames = Callable[[Posture], Mapping[str, Placement]]
"""Of all links, by name."""


class LoopedRobot(Protocol):
    """What loops need of a robot."""

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> RobotDescription: ...

    @property
    def links(self) -> Mapping[str, RobotLink]: ...

    @property
    def q(self) -> Floats: ...

    def _rests(self) -> tuple[Placement, dict[str, Placement]]: ...


#: What is left of a closed loop [m, rad], well below the tolerances of joints.
_CLOSED = 1e-9
#: That a scene takes as closed [m, rad].
_TOLERANCE = 1e-6
_ITERATIONS = 200
#: Kinds of joints that let links go where no coordinate tells.
_FREE = ("floating", "ball")
#: Way of the coordinates that are given, from one q at which loops are closed to the next [rad, m].
_PIECE = 0.1
#: Of a coordinate in one step [rad, m].
_LARGEST_STEP = 0.3
#: Singular values over the largest one below which a direction does not count.
_SINGULAR = 1e-7
#: Halvings of a step that does not come nearer.
_HALVINGS = 12


def close(
    robot: RobotDescription,
    start: Posture,
    q: Floats,
    held: Collection[int],
    frames: Frames,
    owner: str,
) -> Posture:
    """The posture at which all loops are closed, on the way from ``start``: rows of q that are ``held``
    become those of ``q``, others follow, and so do links on floating and ball joints. InvalidArgument says
    which loop stays open, and how far."""
    if not robot.closures:
        return Posture(q, start.free)
    rows = list(held)
    following = np.setdiff1d(np.arange(len(q)), rows)
    way = q[rows] - start.q[rows]
    pieces = max(1, math.ceil(float(np.abs(way).max(initial=0.0)) / _PIECE))
    found = Posture(start.q.copy() if len(following) > 0 else q.copy(), start.free)
    for piece in range(1, pieces + 1):
        found.q[rows] = start.q[rows] + way * (piece / pieces) if piece < pieces else q[rows]
        found, gaps = _closed(robot, found, following, frames)
    parts = np.split(gaps, len(robot.closures))
    worst = int(np.argmax([np.abs(part).max() for part in parts]))
    if np.abs(parts[worst]).max() > _TOLERANCE:
        _refuse(owner, list(robot.closures.values())[worst], parts[worst])
    return found


def free_places(robot: RobotDescription, frame: Callable[[str], Placement]) -> dict[str, Placement]:
    """Of links on floating joints in the world, and on ball joints in their parents, by joint. ``frame``: of
    a link in the world."""
    free = {}
    for joint in robot.joints.values():
        if joint.kind == "floating":
            free[joint.name] = frame(joint.child)
        elif joint.kind == "ball":
            free[joint.name] = frame(joint.child).seen_from(frame(joint.parent))
    return free


def _closed(
    robot: RobotDescription, posture: Posture, following: NDArray[np.intp], frames: Frames
) -> tuple[Posture, Floats]:
    """The nearest posture that is found with all loops closed, and the gaps that are left."""
    gaps = _gaps(robot, frames(posture))
    for _ in range(_ITERATIONS):
        if np.abs(gaps).max() <= _CLOSED or len(following) + len(posture.free) == 0:
            break
        moved = _nearer(robot, posture, following, frames, gaps)
        if moved is None:
            break
        posture, gaps = moved
    return posture, gaps


def place_closed(robot: LoopedRobot, core: Any, q: Floats, values: Values) -> None:
    """Places all bodies that a q moves, with loops closed: by the coordinates that ``values`` leaves out."""
    description, title = robot.description, f"robot '{robot.name}': q"
    base, free = robot._rests()

    def frames(posture: Posture) -> dict[str, Placement]:
        return placements(description, posture.q, base, posture.free)

    rows = enumerate(description.coordinates)
    held = [k for k, name in rows if not isinstance(values, Mapping) or name in values]
    start = Posture(np.array(robot.q), free)
    placed = frames(close(description, start, q, held, frames, title))
    done: set[int] = set()
    with placing(core):
        for name, link in robot.links.items():
            if link.body is None or link.body.motion != "dynamic" or link.body._index in done:
                continue
            done.add(link.body._index)
            place = placed[name].at(*link.offset.inverse())
            core.place(link.body._index, place.position, place.rotation)


def _nearer(
    robot: RobotDescription, posture: Posture, following: NDArray[np.intp], frames: Frames, gaps: Floats
) -> tuple[Posture, Floats] | None:
    """A posture and its gaps after a step; None where none comes nearer. Coordinates at a limit that would
    leave it are held."""
    q, free = posture
    links = frames(posture)
    n, rows = len(q), _jacobian(robot, links, list(free))
    lower, upper = limits_of(robot)
    movable = np.concatenate((following, np.arange(n, rows.shape[1])))
    while len(movable) > 0:
        step = np.zeros(rows.shape[1])
        step[movable] = np.linalg.lstsq(rows[:, movable], -gaps, rcond=_SINGULAR)[0]
        leaving = np.zeros(len(step), dtype=bool)
        leaving[:n] = ((q <= lower) & (step[:n] < 0.0)) | ((q >= upper) & (step[:n] > 0.0))
        if not leaving[movable].any():
            break
        movable = movable[~leaving[movable]]
    else:
        return None
    share = min(1.0, _LARGEST_STEP / max(float(np.abs(step).max()), 1e-300))
    for _ in range(_HALVINGS):
        moved = share * step
        places = _moved(robot, links, free, moved[n:])
        tried = Posture(np.clip(q + moved[:n], lower, upper), places)
        left = _gaps(robot, frames(tried))
        if left @ left < gaps @ gaps:
            return tried, left
        share *= 0.5
    return None


def _moved(
    robot: RobotDescription, links: Mapping[str, Placement], free: Mapping[str, Placement], step: Floats
) -> dict[str, Placement]:
    """Free places after a step of 6 numbers each [m, rad] in the world, those of ball joints 0, turns."""
    places = {}
    for name, (way, turn) in zip(free, step.reshape(-1, 2, 3), strict=True):
        joint, angle = robot.joints[name], float(np.linalg.norm(turn))
        frame = links[joint.child]
        rotation = (turned(turn / angle, angle) if angle > 0.0 else np.eye(3)) @ frame.rotation
        pivot = frame.position + frame.rotation @ joint.anchor + way
        place = Placement(pivot - rotation @ joint.anchor, rotation)
        places[name] = place.seen_from(links[joint.parent]) if joint.kind == "ball" else place
    return places


def _ends(closure: Closure, frames: Mapping[str, Placement]) -> tuple[Placement, Placement]:
    a, b = (frames[link].at(*frame) for link, frame in zip(closure.links, closure.frames, strict=True))
    return a, b


def _gaps(robot: RobotDescription, frames: Mapping[str, Placement]) -> Floats:
    """Six numbers a closure [m, rad]: of side b from side a; rotations of ball joints are free, 0."""
    parts: list[Floats] = []
    for closure in robot.closures.values():
        a, b = _ends(closure, frames)
        turn = np.zeros(3) if closure.kind == "ball" else rotation_vector(b.rotation @ a.rotation.T)
        parts += [b.position - a.position, turn]
    return np.concatenate(parts)


def _jacobian(robot: RobotDescription, links: Mapping[str, Placement], free: Sequence[str]) -> Floats:
    """Derivatives of the gaps by q and the free places, as of _moved, those of rotations to the first order
    of the gap."""
    parts = []
    for closure in robot.closures.values():
        a, b = (
            np.hstack(
                (
                    jacobian(robot, links, link, end.position),
                    _free_columns(robot, links, link, end.position, free),
                )
            )
            for link, end in zip(closure.links, _ends(closure, links), strict=True)
        )
        rows = b - a
        if closure.kind == "ball":
            rows[3:] = 0.0
        parts.append(rows)
    return np.concatenate(parts)


def _free_columns(
    robot: RobotDescription, links: Mapping[str, Placement], link: str, point: Floats, free: Sequence[str]
) -> Floats:
    """As of kinematics.jacobian, for what floating and ball joints let go: (6, 6 of each)."""
    columns = np.zeros((6, 6 * len(free)))
    parent_joint = {joint.child: joint for joint in robot.outwards}
    while link in parent_joint:
        joint = parent_joint[link]
        if joint.kind in _FREE:
            k, frame = 6 * free.index(joint.name), links[link]
            arm = point - frame.position - frame.rotation @ joint.anchor
            for axis in range(3):
                unit = np.eye(3)[axis]
                columns[:3, k + 3 + axis] = cross(unit, arm)
                columns[3:, k + 3 + axis] = unit
                if joint.kind == "floating":
                    columns[:3, k + axis] = unit
        if joint.kind == "floating":
            break
        link = joint.parent
    return columns


def _refuse(owner: str, closure: Closure, gap: Floats) -> None:
    away = f"{np.linalg.norm(gap[:3]):.3g} m"
    if closure.kind == "fixed":
        away += f" and {np.linalg.norm(gap[3:]):.3g} rad"
    a, b = closure.links
    raise InvalidArgument(
        f"{owner}: '{closure.name}' holds '{a}' and '{b}' together, which stay {away} apart: the loop must "
        f"be closed; give fewer coordinates by name, so that others close it, or other ones"
    )
