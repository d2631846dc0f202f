"""Robots of a document: what their handles know beside the bodies, joints and actuators of the scene.

Shapes stay with the file that the robot came from: links of a loaded robot have no ``visual`` and
``collision`` meshes of their own; their bodies have the surfaces that touch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from stark.body_kinds import has_pose
from stark.robots.description import Closure, Gains, Inertia, Link, Mimic, RobotDescription, RobotJoint
from stark.robots.drives import Drives
from stark.robots.handle import Robot
from stark.robots.kinematics import Placement
from stark.robots.link import RobotLink
from stark.robots.report import Finding, Report

from .errors import DocumentError

#: Of joints, as they are.
_PLAIN = (
    *("name", "kind", "parent", "child", "position", "rotation", "axis", "anchor", "reference", "lower"),
    *("upper", "effort", "velocity", "damping", "friction", "armature", "stiffness", "rest"),
)


def described(robot: Robot) -> dict[str, Any]:
    """A robot of a scene as the data of a document."""
    description = robot.description
    return {
        "name": robot.name,
        "source": description.source,
        "base": description.base,
        "position": description.placement[0],
        "rotation": description.placement[1],
        "links": [_link(robot._links[name]) for name in description.links],
        "joints": [_joint(robot, joint) for joint in description.joints.values()],
        "closures": [_closure(robot, closure) for closure in description.closures.values()],
        "excluded": [list(pair) for pair in description.excluded],
        "start": robot._start,
        "report": [
            {"kind": finding.kind, "part": finding.part, "text": finding.text}
            for finding in robot.report.findings
        ],
        "drives": [
            {
                "kind": drives.kind,
                "rows": np.array(drives.rows, dtype=np.int32),
                "actuators": np.array([a._index for a in drives.actuators], dtype=np.int32),
                "shifts": drives._shifts,
                "gravity_compensation": drives.gravity_compensation,
            }
            for drives in robot._drives
        ],
        "flexes": [{"name": name, "body": body._index} for name, body in robot._flexes.items()],
    }


def _link(link: RobotLink) -> dict[str, Any]:
    given = link.description.inertia
    inertia = None
    if given is not None:
        inertia = {"mass": given.mass, "center_of_mass": given.center, "tensor": given.tensor}
    return {
        "name": link.name,
        "inertia": inertia,
        "body": None if link.body is None else link.body._index,
        "position": link.offset.position,
        "rotation": link.offset.rotation,
    }


def _joint(robot: Robot, joint: RobotJoint) -> dict[str, Any]:
    mimic = joint.mimic
    known = robot._joints.get(joint.name)
    return {
        **{name: getattr(joint, name) for name in _PLAIN},
        "mimic": None
        if mimic is None
        else {"joint": mimic.joint, "ratio": mimic.ratio, "offset": mimic.offset},
        "servo": None
        if joint.servo is None
        else {"stiffness": joint.servo.stiffness, "damping": joint.servo.damping},
        "number": None if known is None else known._index,
        "shift": robot._shifts.get(joint.name, 0.0),
    }


def _closure(robot: Robot, closure: Closure) -> dict[str, Any]:
    return {
        "name": closure.name,
        "kind": closure.kind,
        "links": list(closure.links),
        "positions": np.array([position for position, _ in closure.frames]),
        "rotations": np.array([rotation for _, rotation in closure.frames]),
        "number": robot._closures[closure.name]._index,
    }


def add_robot(scene: Any, row: Mapping[str, Any], where: str) -> None:
    """Adds the handle of a robot, whose bodies, joints and actuators are in the scene already."""
    if any(robot.name == row["name"] for robot in scene._robots):
        raise DocumentError(f"{where}: there are two robots '{row['name'][:80]}': names must be unique")
    description, links = _description(scene, row, where)
    known = [joint for joint in row["joints"] if joint["number"] is not None]
    for joint in known:
        if (
            joint["number"] >= len(scene._joints)
            or len(scene._joints[joint["number"]].formula.coordinates) > 1
        ):
            raise DocumentError(
                f"{where}: joint {joint['number']}: must be one of the scene, of one coordinate"
            )
    joints = {joint["name"]: scene._joints[joint["number"]] for joint in known}
    shifts = {joint["name"]: joint["shift"] for joint in known}
    moving = [joint.name for joint in description.outwards if joint.is_moving]
    if any(name not in joints or not joints[name].formula.coordinates for name in moving):
        raise DocumentError(f"{where}: joints that move must be joints of the scene with a coordinate")
    if len(row["start"]) != len(description.coordinates):
        raise DocumentError(f"{where}.start: must have {len(description.coordinates)} numbers")
    flexes = {flex["name"]: _flex(scene, flex["body"], where) for flex in row["flexes"]}
    if any(closure["number"] >= len(scene._joints) for closure in row["closures"]):
        raise DocumentError(f"{where}: closures must be joints of the scene")
    closures = {closure["name"]: scene._joints[closure["number"]] for closure in row["closures"]}
    robot = Robot(
        *(scene, row["name"], description, description.report, links, joints, shifts),
        row["start"],
        flexes,
        closures,
    )
    for k, drives in enumerate(row["drives"]):
        _add_drives(scene, robot, drives, f"{where}.drives[{k}]")
    scene._robots.append(robot)


def _flex(scene: Any, number: int, where: str) -> Any:
    if number >= len(scene.bodies) or has_pose(scene.bodies[number]):
        raise DocumentError(f"{where}: flexes: body must be a cloth, a solid or a rod of the scene")
    return scene.bodies[number]


def _description(
    scene: Any, row: Mapping[str, Any], where: str
) -> tuple[RobotDescription, dict[str, RobotLink]]:
    links: dict[str, RobotLink] = {}
    for link in row["links"]:
        body = None
        if link["body"] is not None:
            if link["body"] >= len(scene.bodies) or not has_pose(scene.bodies[link["body"]]):
                raise DocumentError(
                    f"{where}: link '{link['name'][:80]}': body must be a rigid one of the scene"
                )
            body = scene.bodies[link["body"]]
        inertia = None if link["inertia"] is None else Inertia(*link["inertia"].values())
        offset = Placement(link["position"], link["rotation"])
        links[link["name"]] = RobotLink(
            link["name"], Link(link["name"], inertia), body, offset, row["source"]
        )
    report = Report(row["source"], [Finding(f["kind"], f["part"], f["text"]) for f in row["report"]])
    joints = [
        RobotJoint(
            **{name: joint[name] for name in _PLAIN},
            mimic=None if joint["mimic"] is None else Mimic(**joint["mimic"]),
            servo=None if joint["servo"] is None else Gains(**joint["servo"]),
        )
        for joint in row["joints"]
    ]
    if any(len(closure["links"]) != 2 for closure in row["closures"]):
        raise DocumentError(f"{where}: closures must have two links")
    if len(links) < len(row["links"]) or any(len(pair) != 2 for pair in row["excluded"]):
        raise DocumentError(f"{where}: names of links must be unique, excluded ones pairs")
    description = RobotDescription(
        row["name"],
        [link.description for link in links.values()],
        joints,
        excluded=[(a, b) for a, b in row["excluded"]],
        base=row["base"],
        placement=(row["position"], row["rotation"]),
        report=report,
        closures=[_loaded(closure) for closure in row["closures"]],
    )
    return description, links


def _loaded(row: Mapping[str, Any]) -> Closure:
    first, second = zip(row["positions"], row["rotations"], strict=True)
    a, b = row["links"]
    return Closure(row["name"], row["kind"], (a, b), (first, second))


def _add_drives(scene: Any, robot: Robot, row: Mapping[str, Any], where: str) -> None:
    rows, numbers, count = row["rows"], row["actuators"], len(robot.coordinates)
    kinds = {"servos": "position_servo", "motors": "velocity_motor", "efforts": "effort"}
    inside = len(rows) and 0 <= rows.min() <= rows.max() < count and numbers.size and numbers.min() >= 0
    if (
        not inside
        or numbers.max() >= len(scene._actuators)
        or not len(rows) == len(numbers) == len(row["shifts"])
    ):
        raise DocumentError(f"{where}: must have an actuator of the scene and a shift for each coordinate")
    actuators = [scene._actuators[k] for k in numbers.tolist()]
    if any(actuator.kind != kinds[row["kind"]] for actuator in actuators):
        raise DocumentError(f"{where}: actuators of {row['kind']} must be of the kind '{kinds[row['kind']]}'")
    drives = Drives(robot, row["kind"], rows.tolist(), actuators, row["shifts"])
    robot._drives.append(drives)
    if row["gravity_compensation"]:
        if "body" not in actuators[-1].joint._given["b"]:
            raise DocumentError(f"{where}: what the last joint carries must be a body")
        drives.gravity_compensation = True
