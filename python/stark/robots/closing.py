"""Loops of links: the q at which what closes them does.

Gauss-Newton with the least step of the coordinates that may move (Nocedal and Wright, Numerical Optimization
(2006), 10.3) on the geometric Jacobian; Siciliano et al., Robotics (2009), 2.8.3 on closed chains."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.robots.base import placing
from stark.robots.description import Closure, RobotDescription
from stark.robots.inverse import Bounds, rotation_vector
from stark.robots.kinematics import Placement, Values, jacobian, limits_of, placements
from stark.robots.link import RobotLink

Floats = NDArray[np.float64]
Frames = Callable[[Floats], Mapping[str, Placement]]
"""Of all links, by name, at some q."""


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
#: Way of the coordinates that are given, from one q at which loops are closed to the next [rad, m].
_PIECE = 0.1
#: Of a coordinate in one step [rad, m].
_LARGEST_STEP = 0.3
#: Singular values over the largest one below which a direction does not count.
_SINGULAR = 1e-7
#: Halvings of a step that does not come nearer.
_HALVINGS = 12


def close(
    robot: RobotDescription, start: Floats, q: Floats, held: Collection[int], frames: Frames, owner: str
) -> Floats:
    """The q (n,) at which all loops are closed, on the way from ``start``: rows that are ``held`` become
    those of ``q``, others follow. InvalidArgument says which loop stays open, and how far."""
    if not robot.closures:
        return q
    rows = list(held)
    free = np.setdiff1d(np.arange(len(q)), rows)
    way = q[rows] - start[rows]
    pieces = max(1, math.ceil(float(np.abs(way).max(initial=0.0)) / _PIECE))
    found = start.copy() if len(free) > 0 else q
    for piece in range(1, pieces + 1):
        found[rows] = start[rows] + way * (piece / pieces) if piece < pieces else q[rows]
        found, gaps = _closed(robot, found, free, frames)
    parts = np.split(gaps, len(robot.closures))
    worst = int(np.argmax([np.abs(part).max() for part in parts]))
    if np.abs(parts[worst]).max() > _TOLERANCE:
        _refuse(owner, list(robot.closures.values())[worst], parts[worst])
    return found


def _closed(
    robot: RobotDescription, q: Floats, free: NDArray[np.intp], frames: Frames
) -> tuple[Floats, Floats]:
    """The nearest q that is found with all loops closed, and the gaps that are left."""
    bounds, gaps = limits_of(robot), _gaps(robot, frames(q))
    for _ in range(_ITERATIONS):
        if np.abs(gaps).max() <= _CLOSED or len(free) == 0:
            break
        moved = _nearer(robot, q, free, bounds, frames, gaps)
        if moved is None:
            break
        q, gaps = moved
    return q, gaps


def place_closed(robot: LoopedRobot, core: Any, q: Floats, values: Values) -> None:
    """Places all bodies that a q moves, with loops closed: by the coordinates that ``values`` leaves out."""
    description, title = robot.description, f"robot '{robot.name}': q"
    base, free = robot._rests()

    def frames(q: Floats) -> dict[str, Placement]:
        return placements(description, q, base, free)

    rows = enumerate(description.coordinates)
    held = [k for k, name in rows if not isinstance(values, Mapping) or name in values]
    placed = frames(close(description, np.array(robot.q), q, held, frames, title))
    done: set[int] = set()
    with placing(core):
        for name, link in robot.links.items():
            if link.body is None or link.body.motion != "dynamic" or link.body._index in done:
                continue
            done.add(link.body._index)
            place = placed[name].at(*link.offset.inverse())
            core.place(link.body._index, place.position, place.rotation)


def _nearer(
    robot: RobotDescription, q: Floats, free: NDArray[np.intp], bounds: Bounds, frames: Frames, gaps: Floats
) -> tuple[Floats, Floats] | None:
    """q and gaps after a step; None where none comes nearer. Coordinates at a limit that would leave it are
    held."""
    rows = _jacobian(robot, frames(q))
    lower, upper = bounds
    while len(free) > 0:
        step = np.zeros_like(q)
        step[free] = np.linalg.lstsq(rows[:, free], -gaps, rcond=_SINGULAR)[0]
        leaving = ((q <= lower) & (step < 0.0)) | ((q >= upper) & (step > 0.0))
        if not leaving[free].any():
            break
        free = free[~leaving[free]]
    else:
        return None
    share = min(1.0, _LARGEST_STEP / max(float(np.abs(step).max()), 1e-300))
    for _ in range(_HALVINGS):
        tried = np.clip(q + share * step, lower, upper)
        left = _gaps(robot, frames(tried))
        if left @ left < gaps @ gaps:
            return tried, left
        share *= 0.5
    return None


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


def _jacobian(robot: RobotDescription, frames: Mapping[str, Placement]) -> Floats:
    """Derivatives of the gaps by q, those of rotations to the first order of the gap."""
    parts = []
    for closure in robot.closures.values():
        ends = _ends(closure, frames)
        a, b = (
            jacobian(robot, dict(frames), link, end.position)
            for link, end in zip(closure.links, ends, strict=True)
        )
        rows = b - a
        if closure.kind == "ball":
            rows[3:] = 0.0
        parts.append(rows)
    return np.concatenate(parts)


def _refuse(owner: str, closure: Closure, gap: Floats) -> None:
    away = f"{np.linalg.norm(gap[:3]):.3g} m"
    if closure.kind == "fixed":
        away += f" and {np.linalg.norm(gap[3:]):.3g} rad"
    a, b = closure.links
    raise InvalidArgument(
        f"{owner}: '{closure.name}' holds '{a}' and '{b}' together, which stay {away} apart: the loop must "
        f"be closed; give fewer coordinates by name, so that others close it, or other ones"
    )
