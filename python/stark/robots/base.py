"""The base of a robot in a simulation: placed and pushed with all that hangs on it; q and rates are kept."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.bodies import Cloth, RigidBody, Rod, Solid
from stark.handle import SimulationLink, placed_together
from stark.robots.description import RobotDescription
from stark.robots.kinematics import Placement
from stark.robots.link import RobotLink, moving_point
from stark.rotations import as_matrix, vector

Floats = NDArray[np.float64]


class BasedRobot(Protocol):
    """What the base needs of a robot."""

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> RobotDescription: ...

    @property
    def links(self) -> Mapping[str, RobotLink]: ...

    @property
    def flexes(self) -> Mapping[str, Cloth | Rod | Solid]: ...

    def _require(self, what: str) -> SimulationLink: ...


def placing(core: Any) -> AbstractContextManager[None]:
    """All that is placed in the block holds together, or nothing changes. Inside of a block of the user,
    that one checks."""
    return nullcontext() if core.is_placing else placed_together(core)


def place_base(robot: BasedRobot, value: tuple[ArrayLike, ArrayLike]) -> None:
    """Moves the robot as one to where the frame of its base has this position [m] and rotation."""
    root, core = _floating(robot, "pose"), robot._require("pose = ...")._to_place("pose")
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise InvalidArgument(f"robot '{robot.name}': pose = {value!r}: must be (position [m], rotation)")
    goal = Placement(
        vector(value[0], f"robot '{robot.name}': position"),
        as_matrix(value[1], f"robot '{robot.name}': rotation"),
    )
    present = Placement(*robot.links[root].pose)
    turn = goal.rotation @ present.rotation.T
    shift = goal.position - turn @ present.position
    bodies, flexes = _carried(robot, root)
    core.place_together([body._index for body in (*bodies, *flexes)], turn, shift)


def base_velocity(robot: BasedRobot) -> tuple[Floats, Floats]:
    """Of the origin of the frame of the base [m/s], and its angular velocity [rad/s]."""
    link = robot.links[robot.description.root]
    return link.velocity, link.angular_velocity


def push_base(
    robot: BasedRobot, what: str, velocity: ArrayLike | None = None, angular_velocity: ArrayLike | None = None
) -> None:
    """Gives the base a velocity [m/s] of its origin, or an angular one [rad/s]; the rest moves along."""
    root, core = _floating(robot, what), robot._require(f"{what} = ...")._to_place(what)
    old, old_angular = base_velocity(robot)
    owner = f"robot '{robot.name}': {what}"
    gain = np.zeros(3) if velocity is None else vector(velocity, owner) - old
    spin = np.zeros(3) if angular_velocity is None else vector(angular_velocity, owner) - old_angular
    origin = robot.links[root].position
    bodies, flexes = _carried(robot, root)
    with placing(core):
        for body in bodies:
            body.velocity = body.velocity + gain + np.cross(spin, moving_point(body) - origin)
            body.angular_velocity = body.angular_velocity + spin
        for flex in flexes:
            flex.velocities = flex.velocities + gain + np.cross(spin, flex.positions - origin)


def _floating(robot: BasedRobot, what: str) -> str:
    """The root, if nothing holds it."""
    root = robot.description.root
    body = robot.links[root].body
    if body is None or body.motion != "dynamic":
        how = "fixed" if body is None or body.motion == "fixed" else "scripted"
        remedy = (
            "add it with base='floating' or 'scripted'"
            if how == "fixed"
            else f"move robot.links['{root}'].body"
        )
        raise InvalidArgument(f"robot '{robot.name}': {what}: its base is {how}: must be floating; {remedy}")
    return root


def _carried(robot: BasedRobot, root: str) -> tuple[list[RigidBody], list[Cloth | Rod | Solid]]:
    """What hangs on the base by joints that do not float: bodies, each once, and flexes."""
    names = {root}
    for joint in robot.description.outwards:
        if joint.parent in names and joint.kind != "floating":
            names.add(joint.child)
    links = robot.links
    bodies = {body._index: body for name in links if name in names and (body := links[name].body) is not None}
    flexes = {flex.name: flex.link for flex in robot.description.flexes.values()}
    return list(bodies.values()), [flex for name, flex in robot.flexes.items() if flexes.get(name) in names]
