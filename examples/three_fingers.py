"""A robot without a file: a hand of three fingers of three joints each, about the z axis, that hangs down."""

from __future__ import annotations

import numpy as np

import stark
from stark.robots import Geometry, Inertia, Link, RobotDescription, RobotJoint

FINGERS, JOINTS = ("east", "north", "west"), ("swing", "knuckle", "bend")
SPREAD, UPPER, LOWER, TIP = 0.055, 0.065, 0.055, 0.010  # from the axis, of the parts, of the tips [m]
CAP = 3.0  # of the drives [N m]
STEEL, GRAPHITE = (0.86, 0.87, 0.89), (0.30, 0.32, 0.36)
AXES = np.array([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
LIMITS = ((-0.8, 0.8), (-1.2, 1.2), (0.0, 2.0))  # [rad]


def description() -> RobotDescription:
    """Fingers swing about the radius, then bend towards the axis at the knuckle and in the middle."""
    palm = Geometry("cylinder", (SPREAD + 0.012, 0.012), np.array([0.0, 0.0, 0.017]), color=GRAPHITE)
    links, joints = [Link("palm", collisions=(palm,))], []
    for k, finger in enumerate(FINGERS):
        turn = stark.rotation(axis="z", angle=2.0 * np.pi * k / 3.0)
        knob = Geometry("sphere", (0.010,), color=GRAPHITE)
        tip = Geometry("sphere", (TIP,), np.array([0.0, 0.0, -LOWER]), color=STEEL)
        links += [
            Link(f"{finger}_base", Inertia(0.02, np.zeros(3), 2e-6 * np.eye(3)), (), (knob,)),
            _part(f"{finger}_upper", UPPER, 0.008, 0.04),
            _part(f"{finger}_lower", LOWER, 0.006, 0.03, tip),
        ]
        chain = ("palm", *(link.name for link in links[-3:]))
        places = (turn @ (SPREAD, 0.0, 0.0), np.zeros(3), np.array([0.0, 0.0, -UPPER]))
        for j, joint in enumerate(JOINTS):
            low, top = LIMITS[j]
            joints.append(
                RobotJoint(
                    f"{finger}_{joint}", "revolute", chain[j], chain[j + 1], places[j],
                    turn if j == 0 else np.eye(3), AXES[j], lower=low, upper=top, effort=CAP,
                )
            )  # fmt: skip
    return RobotDescription("hand", links, joints)


def _part(name: str, length: float, radius: float, mass: float, *shapes: Geometry) -> Link:
    """From its joint down to the next one: a rod with round ends."""
    middle = np.array([0.0, 0.0, -0.5 * length])
    along, across = 0.5 * mass * radius**2, mass * (length**2 / 12.0 + radius**2 / 4.0)
    inertia = Inertia(mass, middle, np.diag([across, across, along]))
    return Link(name, inertia, (), (Geometry("capsule", (radius, length), middle, color=STEEL), *shapes))
