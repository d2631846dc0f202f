"""Joints of UsdPhysics: where their frames are in bodies, which axes move, and what they are in a tree."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.robots.description import Gains, RobotJoint
from stark.robots.report import Report
from stark.robots.usd_stage import Stage, applied, turn

Floats = NDArray[np.float64]

_AXES = {"X": 0, "Y": 1, "Z": 2}
#: Names of the axes of a joint without a kind: three that slide, three that turn.
_FREE = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")


@dataclass(frozen=True, eq=False)
class Side:
    """The frame of a joint in one of its bodies, or in the world where ``body`` is "" [m]."""

    body: str
    position: Floats
    rotation: Floats


@dataclass(frozen=True)
class Axis:
    """One that moves: ``number`` 0 to 2, turning or sliding, with what the file says of it in SI units."""

    number: int
    slides: bool
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    servo: Gains | None = None
    velocity: float | None = None
    armature: float = 0.0


@dataclass(frozen=True, eq=False)
class UsdJoint:
    """``axes`` move in this order, as seen from the first body; none for a fixed joint."""

    path: str
    name: str
    sides: tuple[Side, Side]
    axes: tuple[Axis, ...]
    is_outside: bool
    """Whether the file keeps it out of the tree of joints."""

    @property
    def is_fixed(self) -> bool:
        return not self.axes

    @property
    def bodies(self) -> tuple[str, ...]:
        """Paths of its bodies, one or two."""
        return tuple(side.body for side in self.sides if side.body)

    @property
    def ends(self) -> tuple[str, str]:
        """Paths of its bodies, "" for the world."""
        return self.sides[0].body, self.sides[1].body

    def to_tree(
        self, parent: str, parent_name: str, child_name: str, report: Report
    ) -> tuple[list[RobotJoint], list[str]]:
        """From ``parent`` (path) outwards: one joint, or one for each axis with links between, whose names
        are given, too."""
        is_turned = self.sides[0].body != parent
        at_parent, at_child = reversed(self.sides) if is_turned else self.sides
        rotation = at_parent.rotation @ at_child.rotation.T
        place = at_parent.position - rotation @ at_child.position, rotation
        if self.is_fixed:
            return [RobotJoint(self.name, "fixed", parent_name, child_name, *place)], []
        axes = self.axes[::-1] if is_turned else self.axes
        names = [self.name] if len(axes) == 1 else [f"{self.name}_{_free_name(axis)}" for axis in axes]
        between = [f"{child_name}_after_{name}" for name in names[:-1]]
        if between:
            report.add(
                "kept",
                f"joint '{self.name}'",
                f"as {len(axes)} joints in a row, with links without mass between",
            )
        chain = [parent_name, *between, child_name]
        made = []
        for k, axis in enumerate(axes):
            direction = at_child.rotation[:, axis.number] * (-1.0 if is_turned else 1.0)
            limited = axis.lower is not None or axis.upper is not None
            if axis.effort is None:
                report.add("assumed", f"joint '{names[k]}'", "no limit of effort: none")
            kind = "prismatic" if axis.slides else ("revolute" if limited else "continuous")
            made.append(
                RobotJoint(
                    names[k],
                    kind,
                    chain[k],
                    chain[k + 1],
                    *(place if k == 0 else (np.zeros(3), np.eye(3))),
                    axis=direction / np.linalg.norm(direction),
                    anchor=at_child.position,
                    lower=axis.lower,
                    upper=axis.upper,
                    effort=axis.effort,
                    servo=axis.servo,
                    velocity=axis.velocity,
                    armature=axis.armature,
                )
            )
        return made, between


def _free_name(axis: Axis) -> str:
    return _FREE[axis.number + (0 if axis.slides else 3)]


def joints_of(stage: Stage, prims: list[Any], owner: Callable[[Any], str]) -> list[UsdJoint]:
    """Joints that are enabled and act on bodies. ``owner``: path of the body of a prim, "" for the world."""
    rows = [prim for prim in prims if prim.IsA(stage.pxr.UsdPhysics.Joint)]
    names = [str(prim.GetName()) for prim in rows]
    found = []
    for prim, name in zip(rows, names, strict=True):
        if names.count(name) > 1:
            name = str(prim.GetPath())[1:].replace("/", "_")
        joint = _Reading(stage, prim, name).joint(owner)
        if joint is not None:
            found.append(joint)
    return found


class _Reading:
    """Of one joint."""

    def __init__(self, stage: Stage, prim: Any, name: str) -> None:
        self.stage, self.prim, self.name = stage, prim, name
        self.physics = stage.pxr.UsdPhysics
        self.title = f"joint '{name}'"

    def joint(self, owner: Callable[[Any], str]) -> UsdJoint | None:
        joint = self.physics.Joint(self.prim)
        if joint.GetJointEnabledAttr().Get() is False:
            self.stage.report.add("dropped", self.title, "jointEnabled is false")
            return None
        sides = self._side(joint, 0, owner), self._side(joint, 1, owner)
        if sides[0].body == sides[1].body:
            where = f"joins '{sides[0].body}' with itself" if sides[0].body else "acts on no body"
            self.stage.report.add("dropped", self.title, where)
            return None
        for what in ("BreakForce", "BreakTorque"):
            limit = getattr(joint, f"Get{what}Attr")().Get()
            if limit is not None and limit < 1e30:
                self.stage.report.add("dropped", self.title, f"{what} {limit:g}")
        outside = bool(joint.GetExcludeFromArticulationAttr().Get())
        return UsdJoint(str(self.prim.GetPath()), self.name, sides, self._axes(), outside)

    def _side(self, joint: Any, k: int, owner: Callable[[Any], str]) -> Side:
        targets = (joint.GetBody0Rel() if k == 0 else joint.GetBody1Rel()).GetTargets()
        position = (joint.GetLocalPos0Attr() if k == 0 else joint.GetLocalPos1Attr()).Get()
        rotation = turn((joint.GetLocalRot0Attr() if k == 0 else joint.GetLocalRot1Attr()).Get())
        if not targets:
            up = self.stage.up
            return Side("", self.stage.metre * up @ np.array(position, dtype=np.float64), up @ rotation)
        prim = self.stage.usd.GetPrimAtPath(targets[0])
        if not prim:
            raise InvalidArgument(
                f"{self.stage.report.source}: {self.title}: body{k} = {targets[0]}: must be a prim of the "
                f"stage; add it or correct the path"
            )
        frame, body = self.stage.frame(prim), owner(prim)
        place, axes = frame.of_point(position), frame.rotation @ rotation
        if not body:
            return Side("", place, axes)
        on = self.stage.frame(self.stage.usd.GetPrimAtPath(body), of_body=True)
        return Side(body, on.rotation.T @ (place - on.position), on.rotation.T @ axes)

    # --- axes ---

    def _axes(self) -> tuple[Axis, ...]:
        physics, prim = self.physics, self.prim
        if prim.IsA(physics.FixedJoint):
            return ()
        if prim.IsA(physics.RevoluteJoint) or prim.IsA(physics.PrismaticJoint):
            slides = bool(prim.IsA(physics.PrismaticJoint))
            joint = physics.PrismaticJoint(prim) if slides else physics.RevoluteJoint(prim)
            bounds = joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get()
            number = _AXES[str(joint.GetAxisAttr().Get())]
            return (self._axis(number, slides, bounds, "linear" if slides else "angular"),)
        if prim.IsA(physics.SphericalJoint) or prim.IsA(physics.DistanceJoint):
            raise InvalidArgument(
                f"{self.stage.report.source}: {self.title}: is a {prim.GetTypeName()}: must be "
                f"fixed, revolute, prismatic or one with free axes; use three axes that turn, or join the "
                f"parts by scene.add_ball or add_distance_limit after they are added"
            )
        free = []
        for k, name in enumerate(_FREE):
            limit = physics.LimitAPI(prim, name) if prim.HasAPI(physics.LimitAPI, name) else None
            bounds = (None, None) if limit is None else (limit.GetLowAttr().Get(), limit.GetHighAttr().Get())
            if bounds[0] is not None and bounds[1] is not None and bounds[0] > bounds[1]:
                continue  # USD: locked
            free.append(self._axis(k % 3, k < 3, bounds, name))
        if len(free) == len(_FREE):
            raise InvalidArgument(
                f"{self.stage.report.source}: {self.title}: leaves all six axes free: must hold one at "
                f"least; remove it"
            )
        return tuple(free)

    def _axis(self, number: int, slides: bool, bounds: tuple[Any, Any], drive: str) -> Axis:
        unit = self.stage.metre if slides else math.pi / 180.0
        lower, upper = (
            None if value is None or not math.isfinite(value) or abs(value) > 1e30 else float(value) * unit
            for value in bounds
        )
        mass, metre = self.stage.kilogram, self.stage.metre
        velocity = self._number("physxJoint:maxJointVelocity")
        armature = self._number("physxJoint:armature") or 0.0
        if self._number("physxJoint:jointFriction"):
            self.stage.report.add("dropped", self.title, "jointFriction: give joint.add_friction")
        if any("Mimic" in schema for schema in applied(self.prim)):
            self.stage.report.add(
                "dropped", self.title, "mimics another joint: use joint.add_gear", warn=True
            )
        return Axis(
            number,
            slides,
            lower,
            upper,
            *self._drive(drive, slides),
            None if velocity is None else velocity * unit,
            armature * (mass if slides else mass * metre**2),
        )

    def _drive(self, name: str, slides: bool) -> tuple[float | None, Gains | None]:
        """Of an axis: the limit of its effort [N, N m] and the gains of its servo."""
        physics, report = self.physics, self.stage.report
        mass, metre = self.stage.kilogram, self.stage.metre
        unit = mass * metre if slides else mass * metre**2
        if not self.prim.HasAPI(physics.DriveAPI, name):
            return None, None
        drive = physics.DriveAPI(self.prim, name)
        k, d = (float(get().Get() or 0.0) for get in (drive.GetStiffnessAttr, drive.GetDampingAttr))
        per = mass if slides else unit * 180.0 / math.pi  # stiffness of a turn is given per degree
        given = f"stiffness {k * per:g} and damping {d * per:g} of drive '{name}' in SI units"
        gains = None
        if k > 0.0 and drive.GetTypeAttr().Get() != "acceleration":
            gains = Gains(k * per, d * per)
            report.add("kept", self.title, f"{given}: robot.add_servos() takes them where none are given")
        else:
            report.add("dropped", self.title, f"{given}: use robot.add_servos, add_motors, add_efforts")
        limit = drive.GetMaxForceAttr().Get()
        if limit is None or not math.isfinite(limit) or limit > 1e30:
            return None, gains
        report.add("kept", self.title, f"limit of effort {limit * unit:g}")
        return float(limit) * unit, gains

    def _number(self, name: str) -> float | None:
        attribute = self.prim.GetAttribute(name)
        value = attribute.Get() if attribute else None
        return None if value is None or not math.isfinite(value) or abs(value) > 1e30 else float(value)
