"""How heavy a robot is to its joints: mass matrix and efforts of motions, as controllers compute them.

Recursive Newton-Euler equations in the axes of the world; Siciliano et al., Robotics (2009), 7.5."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark.attributes import AnsweredAttributes
from stark.handle import SimulationLink
from stark.robots import kinematics
from stark.robots.description import RobotDescription, RobotJoint
from stark.robots.kinematics import Placement, Values
from stark.robots.weight import CarriedWeight
from stark.rotations import vector
from stark.settings import Settings

Floats = NDArray[np.float64]


class RobotDynamics(AnsweredAttributes):
    """What ``stark.robots.Robot`` knows of its masses. Efforts are along q, the base rests, floating and ball
    joints rest in it, and loops that are closed count as open."""

    _weight: CarriedWeight

    if TYPE_CHECKING:  # what Robot has

        @property
        def name(self) -> str: ...
        @property
        def description(self) -> RobotDescription: ...
        @property
        def q(self) -> Floats: ...
        @property
        def qd(self) -> Floats: ...
        def forward_kinematics(self, q: Values) -> dict[str, Placement]: ...
        def _simulation(self) -> SimulationLink | None: ...
        def _holding(self, gravity: Floats) -> Floats: ...

    def gravity_efforts(self, q: Values | None = None, gravity: ArrayLike | None = None) -> Floats:
        """Efforts (n,) [N m, N] that hold the robot at rest against its weight, the base held; at the present
        q and in the gravity [m/s^2] of the simulation if left out, or that of default settings."""
        acceleration = self._gravity(gravity)
        if q is None:
            return self._holding(acceleration)
        return self._weight.of_links.efforts_at(self.forward_kinematics(q), acceleration)

    def mass_matrix(self, q: Values | None = None) -> Floats:
        """(n, n) [kg m^2, kg m, kg]: the efforts along q that each acceleration of q takes at rest, armatures
        of joints included, the base held; at the present q if left out."""
        return mass_matrix(self.description, self.forward_kinematics(self.q if q is None else q))

    def inverse_dynamics(
        self, qdd: Values, q: Values | None = None, qd: Values | None = None, gravity: ArrayLike | None = None
    ) -> Floats:
        """Efforts (n,) [N m, N] that the motion with the accelerations ``qdd`` [rad/s^2, m/s^2] at ``q``
        and the rates ``qd`` takes, against weight and inertia, the base held: ``mass_matrix(q) @ qdd``,
        what the rates do, and ``gravity_efforts(q)``. Damping, friction, springs and stops of joints come
        on top. Present q and rates, and the gravity [m/s^2] of the simulation, if left out; numbers by
        joint are 0 for others."""
        acceleration = self._gravity(gravity)
        return efforts_of(
            self.description,
            self.forward_kinematics(self.q if q is None else q),
            kinematics.numbers_of(self.description, self.qd if qd is None else qd, "qd"),
            kinematics.numbers_of(self.description, qdd, "qdd"),
            acceleration,
        )

    def _gravity(self, given: ArrayLike | None) -> Floats:
        if given is None:
            simulation = self._simulation()
            given = (Settings() if simulation is None else simulation.settings).gravity
        return vector(given, f"robot '{self.name}': gravity")


def mass_matrix(robot: RobotDescription, frames: Mapping[str, Placement]) -> Floats:
    """(n, n), with frames of links in the world by name."""
    rows = {name: k for k, name in enumerate(robot.coordinates)}
    total = np.zeros((len(rows), len(rows)))
    for name, link in robot.links.items():
        if link.inertia is None:
            continue
        center = frames[name].at(link.inertia.center, np.eye(3)).position
        columns = kinematics.jacobian(robot, frames, name, center)
        turning = frames[name].rotation.T @ columns[3:]
        total += link.inertia.mass * columns[:3].T @ columns[:3] + turning.T @ link.inertia.tensor @ turning
    for joint in robot.outwards:
        if joint.is_moving:
            driver, ratio, _ = robot.drive_of(joint)
            total[rows[driver], rows[driver]] += ratio**2 * joint.armature
    return total


class _Motion(NamedTuple):
    """Of a link, world axes: angular velocity [rad/s], its change [rad/s^2], acceleration of the origin of
    its frame [m/s^2]."""

    spin: Floats
    turning: Floats
    acceleration: Floats

    def at(self, arm: Floats) -> Floats:
        """Acceleration of a point that is so far from the origin [m/s^2]."""
        centripetal = kinematics.cross(self.spin, kinematics.cross(self.spin, arm))
        return np.asarray(self.acceleration + kinematics.cross(self.turning, arm) + centripetal)


def efforts_of(
    robot: RobotDescription, frames: Mapping[str, Placement], qd: Floats, qdd: Floats, gravity: Floats
) -> Floats:
    """(n,) [N m, N] that a motion takes, with frames of links in the world by name."""
    rows = {name: k for k, name in enumerate(robot.coordinates)}
    motions = {robot.root: _Motion(np.zeros(3), np.zeros(3), -gravity)}  # a lift that falls upwards
    # Force and moment about the origin of the world that each link takes, with all that hangs on it.
    forces = {name: np.zeros((2, 3)) for name in robot.links}
    for joint in robot.outwards:
        motions[joint.child] = _carried(robot, frames, joint, motions[joint.parent], rows, qd, qdd)
    for name, motion in motions.items():
        forces[name] += _forces(robot, frames[name], name, motion)
    efforts = np.zeros(len(rows))
    for joint in reversed(robot.outwards):
        force, moment = forces[joint.child]
        forces[joint.parent] += forces[joint.child]
        if not joint.is_moving:
            continue
        driver, ratio, _ = robot.drive_of(joint)
        row, frame = rows[driver], frames[joint.child]
        axis = frame.rotation @ joint.axis
        place = frame.at(joint.anchor, np.eye(3)).position
        along = force if joint.kind == "prismatic" else moment - kinematics.cross(place, force)
        efforts[row] += ratio * (axis @ along) + ratio**2 * joint.armature * qdd[row]
    return efforts


def _carried(
    robot: RobotDescription,
    frames: Mapping[str, Placement],
    joint: RobotJoint,
    parent: _Motion,
    rows: Mapping[str, int],
    qd: Floats,
    qdd: Floats,
) -> _Motion:
    """Motion of the child of a joint."""
    frame, from_parent = frames[joint.child], frames[joint.parent].position
    if not joint.is_moving:
        return _Motion(parent.spin, parent.turning, parent.at(frame.position - from_parent))
    driver, ratio, _ = robot.drive_of(joint)
    axis = frame.rotation @ joint.axis
    rate, change = ratio * qd[rows[driver]] * axis, ratio * qdd[rows[driver]] * axis
    if joint.kind == "prismatic":
        carried = parent.at(frame.position - from_parent)
        return _Motion(
            parent.spin, parent.turning, carried + 2.0 * kinematics.cross(parent.spin, rate) + change
        )
    place = frame.at(joint.anchor, np.eye(3)).position
    turning = parent.turning + change + kinematics.cross(parent.spin, rate)
    about = _Motion(parent.spin + rate, turning, parent.at(place - from_parent))
    return about._replace(acceleration=about.at(frame.position - place))


def _forces(robot: RobotDescription, frame: Placement, name: str, motion: _Motion) -> Floats:
    """Force and moment about the origin of the world (2, 3) [N, N m] that the masses of a link take."""
    inertia = robot.links[name].inertia
    if inertia is None:
        return np.zeros((2, 3))
    center = frame.at(inertia.center, np.eye(3)).position
    tensor = frame.rotation @ inertia.tensor @ frame.rotation.T
    force = inertia.mass * motion.at(center - frame.position)
    moment = tensor @ motion.turning + kinematics.cross(motion.spin, tensor @ motion.spin)
    return np.array([force, moment + kinematics.cross(center, force)])
