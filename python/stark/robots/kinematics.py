"""Where the links of a description are, and how they move with q.

Recursive kinematics of a tree; Siciliano et al., Robotics (2009), 3.1 for the Jacobian."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import real_array, real_number
from stark.robots.description import RobotDescription, RobotJoint
from stark.robots.report import Report

Floats = NDArray[np.float64]
Values: TypeAlias = ArrayLike | Mapping[str, float]


class Placement(NamedTuple):
    """Of a frame in the world, or in another one: origin (3,) [m] and axes as columns (3, 3)."""

    position: Floats
    rotation: Floats

    def at(self, position: Floats, rotation: Floats) -> Placement:
        """A frame that is given in this one, in the world."""
        return Placement(self.position + self.rotation @ position, self.rotation @ rotation)

    def inverse(self) -> Placement:
        """The frame that this one is given in, in this one."""
        return Placement(-self.rotation.T @ self.position, self.rotation.T)

    def seen_from(self, other: Placement) -> Placement:
        """This frame in another one."""
        axes = other.rotation.T
        return Placement(axes @ (self.position - other.position), axes @ self.rotation)


WORLD = Placement(np.zeros(3), np.eye(3))


def numbers_of(robot: RobotDescription, q: Values, what: str = "q") -> Floats:
    """q as an array (n,) in the order of ``robot.coordinates`` [rad, m], from an array or numbers by joint;
    what is left out of them is 0. InvalidArgument names what is wrong."""
    names = robot.coordinates
    owner = f"robot '{robot.name}': {what}"
    if not isinstance(q, Mapping):
        values = real_array(q, owner)
        if values.shape != (len(names),):
            raise InvalidArgument(
                f"{owner} has the shape {values.shape}: must be ({len(names)},), for {', '.join(names)}"
            )
    else:
        values = np.zeros(len(names))
        for name, value in q.items():
            if name not in names:
                raise InvalidArgument(
                    f"{owner}['{name}']: must be a joint with a coordinate of its own: {', '.join(names)}"
                )
            values[names.index(name)] = real_number(value, f"{owner}['{name}']")
    if not np.isfinite(values).all():
        raise InvalidArgument(f"{owner} = {values.tolist()}: must be finite; check where it is computed")
    return values


def joint_values(robot: RobotDescription, q: Floats) -> dict[str, float]:
    """Coordinates of all joints that have one, mimicking ones included, by name."""
    place = {name: k for k, name in enumerate(robot.coordinates)}
    found = {}
    for joint in robot.joints.values():
        if joint.is_moving:
            driver, ratio, offset = robot.drive_of(joint)
            found[joint.name] = ratio * float(q[place[driver]]) + offset
    return found


def limits_of(description: RobotDescription, report: Report | None = None) -> tuple[Floats, Floats]:
    """Lower and upper limits of q, (n,) each [rad, m], those of joints that mimic others among them."""
    names = description.coordinates
    lower, upper = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    for joint in description.joints.values():
        if not joint.is_moving:
            continue
        driver, ratio, offset = description.drive_of(joint)
        k = names.index(driver)
        if ratio == 0.0:
            continue
        bounds = sorted(
            (bound - offset) / ratio
            for bound in (
                -np.inf if joint.lower is None else joint.lower,
                np.inf if joint.upper is None else joint.upper,
            )
        )
        lower[k], upper[k] = max(lower[k], bounds[0]), min(upper[k], bounds[1])
    for k in np.flatnonzero(~(lower < upper)).tolist():
        # Nobody checks the limits of mimicking joints; ratio -1 with those of the driver is common.
        own = description.joints[names[k]]
        lower[k] = -np.inf if own.lower is None else own.lower
        upper[k] = np.inf if own.upper is None else own.upper
        if report is not None:
            report.add(
                "suspicious",
                f"joint '{names[k]}'",
                "limits of joints that mimic it leave it no way: those are not kept, its own are",
            )
    return lower, upper


def motion_of(joint: RobotJoint, value: float) -> Placement:
    """Of the child in its frame at the reference."""
    moved = value - joint.reference
    if joint.kind == "prismatic":
        return Placement(moved * joint.axis, np.eye(3))
    if not joint.is_moving or moved == 0.0:
        return WORLD
    turn = turned(joint.axis, moved)
    return Placement(joint.anchor - turn @ joint.anchor, turn)


def placements(
    robot: RobotDescription,
    q: Floats,
    base: Placement = WORLD,
    free: Mapping[str, Placement] | None = None,
) -> dict[str, Placement]:
    """Frames of all links in the world, by name. ``free``: frames of the children of floating joints in the
    world, of those of ball joints in the parent, by joint; where they are at the start if left out."""
    values = joint_values(robot, q)
    found = {robot.root: base}
    for joint in robot.outwards:
        if free is not None and joint.name in free:
            place = free[joint.name]
            found[joint.child] = found[joint.parent].at(*place) if joint.kind == "ball" else place
            continue
        at_reference = found[joint.parent].at(joint.position, joint.rotation)
        found[joint.child] = at_reference.at(*motion_of(joint, values.get(joint.name, 0.0)))
    return found


def jacobian(robot: RobotDescription, links: Mapping[str, Placement], link: str, point: Floats) -> Floats:
    """Velocity (rows 0 to 2) [m/s] of a ``point`` of a link, in the world, and angular velocity (rows 3 to 5)
    [rad/s] of the link for each rate of q: (6, n). The base, floating and ball joints rest."""
    names = robot.coordinates
    columns = np.zeros((6, len(names)))
    parent_joint = {joint.child: joint for joint in robot.outwards}
    while link in parent_joint:
        joint = parent_joint[link]
        if joint.is_moving:
            driver, ratio, _ = robot.drive_of(joint)
            frame = links[link]
            axis = frame.rotation @ joint.axis
            column = columns[:, names.index(driver)]
            if joint.kind == "prismatic":
                column[:3] += ratio * axis
            else:
                column[:3] += ratio * cross(axis, point - frame.position - frame.rotation @ joint.anchor)
                column[3:] += ratio * axis
        link = joint.parent
    return columns


def base_columns(robot: RobotDescription, links: Mapping[str, Placement], link: str, point: Floats) -> Floats:
    """The same for each velocity of the origin of the base, then each angular velocity of the base, in world
    axes: (6, 6). Links beyond a floating joint do not move with the base."""
    columns = np.eye(6)
    x, y, z = point - links[robot.root].position
    columns[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    parent_joint = {joint.child: joint for joint in robot.outwards}
    while link in parent_joint:
        if parent_joint[link].kind == "floating":
            return np.zeros((6, 6))
        link = parent_joint[link].parent
    return columns


def cross(a: Floats, b: Floats) -> Floats:
    """As np.cross, faster."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def turned(axis: Floats, angle: float) -> Floats:
    """As stark.rotation, for a unit axis, without its checks."""
    x, y, z = axis
    s, c = math.sin(angle), 2.0 * math.sin(0.5 * angle) ** 2
    return np.array(
        [
            [1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y],
            [c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x],
            [c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)],
        ]
    )
