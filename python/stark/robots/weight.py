"""What carries the weight of a robot: all joints and links at once, as before each step of a simulation."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stark import _core
from stark.robots.description import RobotDescription
from stark.robots.kinematics import WORLD, Placement
from stark.robots.link import RobotLink

Floats = NDArray[np.float64]

_SUM = np.ones(3)  # v @ _SUM: sums of rows


class Weight:
    """Of the links of a robot: each joint carries what hangs on it, by the moment about its axis."""

    def __init__(self, robot: RobotDescription, offsets: Mapping[str, Placement] | None = None) -> None:
        """``offsets``: of the frames of links in the frames that ``efforts`` is given; none: it is given
        theirs."""
        self._links = tuple(robot.links)
        place = {name: k for k, name in enumerate(self._links)}
        at = [WORLD if offsets is None else offsets[name] for name in robot.links]
        inertias = [link.inertia for link in robot.links.values()]
        mass = np.array([0.0 if inertia is None else inertia.mass for inertia in inertias])
        centers = [np.zeros(3) if inertia is None else inertia.center for inertia in inertias]
        centers = [frame.at(c, np.eye(3)).position for frame, c in zip(at, centers, strict=True)]
        hanging = np.eye(len(place))  # rows: a link and all that hangs on it
        for joint in reversed(robot.outwards):
            hanging[place[joint.parent]] += hanging[place[joint.child]]
        carried = hanging @ mass
        # By link, as columns: first moment, axis and a point of the axis of the joint that carries it.
        self._columns = np.zeros((len(at), 3, 3))
        self._columns[:, :, 0] = mass[:, None] * np.array(centers).reshape(-1, 3)
        rows = {name: k for k, name in enumerate(robot.coordinates)}
        self._holds = np.zeros((len(rows), len(at)))  # efforts along q from those along the axes of links
        turns, self._slid = np.zeros(len(at)), np.zeros(len(at))
        for joint in robot.outwards:
            if not joint.is_moving:
                continue
            k = place[joint.child]
            self._columns[k, :, 1] = at[k].rotation @ joint.axis
            self._columns[k, :, 2] = at[k].at(joint.anchor, np.eye(3)).position
            if joint.kind == "prismatic":
                self._slid[k] = carried[k]
            else:
                turns[k] = 1.0
            driver, ratio, _ = robot.drive_of(joint)
            self._holds[rows[driver], k] -= ratio
        self._has_slides = bool(self._slid.any())
        # Moments of what hangs on a link about its axis, from frames, first moments and points of axes.
        by_axis = np.diag(carried)
        self._moments = turns[:, None] * np.hstack((hanging * mass - by_axis, hanging, -by_axis))

    def efforts(self, positions: Floats, rotations: Floats, gravity: Floats) -> Floats:
        """(n,) [N m, N] along q that hold all links at rest under ``gravity`` (3,) [m/s^2], with frames at
        ``positions`` (k, 3) [m] and ``rotations`` (k, 3, 3), in the order of ``robot.links``."""
        columns = rotations @ self._columns
        axes = columns[:, :, 1]
        moments = self._moments @ np.concatenate((positions, columns[:, :, 0], columns[:, :, 2]))
        x, y, z = gravity.tolist()
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])  # m @ across: m x gravity
        along = ((moments @ across) * axes) @ _SUM
        if self._has_slides:
            along += self._slid * (axes @ gravity)
        return np.asarray(self._holds @ along)

    def efforts_at(self, frames: Mapping[str, Placement], gravity: Floats) -> Floats:
        """The same, with frames by the names of links."""
        placed = [frames[name] for name in self._links]
        positions, rotations = (np.array([frame[k] for frame in placed]) for k in range(2))
        return self.efforts(positions, rotations, gravity)


class CarriedWeight:
    """The weight of a robot in a scene, of which links are parts of bodies or of the world."""

    def __init__(self, robot: RobotDescription, links: Mapping[str, RobotLink]) -> None:
        self._robot = robot
        self._weight = Weight(robot, {name: link.offset for name, link in links.items()})
        bodies = [links[name].body for name in robot.links]
        self._bodies = [body._index for body in bodies if body is not None]
        self._rows = [k for k, body in enumerate(bodies) if body is not None]
        self._count = len(bodies)

    @cached_property
    def of_links(self) -> Weight:
        """For frames of links, wherever they would be."""
        return Weight(self._robot)

    def efforts(self, core: _core.Scene | _core.Simulation, gravity: Floats) -> Floats:
        """(n,) [N m, N] that hold it where its bodies are."""
        if isinstance(core, _core.Simulation):
            positions, rotations = core.poses(self._bodies)
            rotations = rotations.reshape(-1, 3, 3)
        else:
            found = [core.pose(body) for body in self._bodies]
            positions, rotations = (np.array([pose[k] for pose in found]) for k in range(2))
        if len(self._rows) == self._count:
            return self._weight.efforts(positions, rotations, gravity)
        all_positions, all_rotations = np.zeros((self._count, 3)), np.zeros((self._count, 3, 3))
        all_rotations[:] = np.eye(3)
        if self._rows:
            all_positions[self._rows], all_rotations[self._rows] = positions, rotations
        return self._weight.efforts(all_positions, all_rotations, gravity)
