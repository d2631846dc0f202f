"""Drives of several joints of a robot, with targets as arrays."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import Error, InvalidArgument
from stark.arguments import given_flag
from stark.attributes import AnsweredAttributes
from stark.caller import warn
from stark.courses import TimeValue, at_start, set_courses
from stark.handle import SceneLink, SimulationLink
from stark.joints.handle import Actuator, Joint
from stark.motion import Motion, through_same_knots
from stark.readings import reading
from stark.robots.description import RobotDescription
from stark.robots.loops import in_loops
from stark.robots.targets import JointValues, by_joint, spread

Floats = NDArray[np.float64]

#: What can be assigned, by the kind of drives.
_VALUES = {
    "servos": ("target", "target_rate", "stiffness", "damping", "cap", "feedforward"),
    "motors": ("target", "cap", "delta"),
    "efforts": ("target",),
}
_LIMIT_ROUNDING = 1e-9  # [rad, m]


class DrivenRobot(Protocol):
    """What drives need of a robot."""

    _scene: SceneLink
    _drives: list[Drives]
    _joints: Mapping[str, Joint]
    _start: Floats  # q at the start of each simulation

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> RobotDescription: ...

    @property
    def q(self) -> Floats: ...

    @property
    def limits(self) -> tuple[Floats, Floats]: ...

    def _holding(self, gravity: Floats) -> Floats: ...

    def _axes(self) -> Any: ...

    def _bound_to(self, simulation: SimulationLink) -> DrivenRobot: ...

    def _is_in(self, simulation: SimulationLink) -> bool: ...


class Drives(AnsweredAttributes):
    """Actuators of one kind on some joints of a robot; arrays (k,) are in the order of ``joints``. Values
    take (k,) numbers, one for all, some by joint (others stay), or a function of the time [s] that gives (k,)
    numbers or one."""

    _given_by: ClassVar[Mapping[str, str]] = {
        "joints": "robot.add_servos(joints, ...), another group",
        "effort": "drives.target, of efforts",
    }

    def __init__(
        self, robot: DrivenRobot, kind: str, rows: list[int], actuators: list[Actuator], shifts: Floats
    ) -> None:
        self._robot, self._actuators, self._shifts = robot, actuators, shifts
        self._kind, self._rows = kind, rows
        coordinates = robot.description.coordinates
        self._joints = tuple(coordinates[row] for row in rows)
        lower, upper = robot.limits
        self._limits = lower[rows], upper[rows]
        self._warned_of: set[int] = set()  # joints whose target was beyond their limits

    @property
    def kind(self) -> str:
        """ "servos", "motors" or "efforts"."""
        return self._kind

    @property
    def rows(self) -> list[int]:
        """Where the joints are in q."""
        return list(self._rows)

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self._joints

    @property
    def actuators(self) -> tuple[Actuator, ...]:
        """The actuators, one a joint."""
        return tuple(self._actuators)

    @property
    def target(self) -> Floats:
        """(k,) q [rad, m] of servos, rates [rad/s, m/s] of motors, efforts [N m, N]; assign others, which
        hold from the next step on."""
        return reading(self._numbers("target") + self._shifts, self, "target", assign=True)

    @target.setter
    def target(self, values: JointValues) -> None:
        self._assign("target", values)

    @property
    def target_rate(self) -> Floats:
        """(k,) [rad/s, m/s] of servos, 0 at first: the rate of the target, which their damping does not
        brake; assign others."""
        return self._values("target_rate")

    @target_rate.setter
    def target_rate(self, values: JointValues) -> None:
        self._assign("target_rate", values)

    @property
    def stiffness(self) -> Floats:
        """(k,) [N m/rad, N/m] of servos; assign others."""
        return self._values("stiffness")

    @stiffness.setter
    def stiffness(self, values: JointValues) -> None:
        self._assign("stiffness", values)

    @property
    def damping(self) -> Floats:
        """(k,) [N m s/rad, N s/m] of servos; assign others."""
        return self._values("damping")

    @damping.setter
    def damping(self, values: JointValues) -> None:
        self._assign("damping", values)

    @property
    def cap(self) -> Floats:
        """(k,) [N m, N]: the largest efforts of servos and motors; assign others."""
        return self._values("cap")

    @cap.setter
    def cap(self, values: JointValues) -> None:
        self._assign("cap", values)

    @property
    def delta(self) -> Floats:
        """(k,) [rad/s, m/s] of motors: closer to the target the effort is in proportion; assign others."""
        return self._values("delta")

    @delta.setter
    def delta(self, values: JointValues) -> None:
        self._assign("delta", values)

    @property
    def feedforward(self) -> Floats:
        """(k,) [N m, N] that servos add to their own effort, within their cap; assign it."""
        self._require_servos("feedforward")
        return self._values("feedforward")

    @feedforward.setter
    def feedforward(self, values: JointValues) -> None:
        self._require_servos("feedforward")
        if self.gravity_compensation:
            raise InvalidArgument(
                f"{self._title}: feedforward: is that of the gravity compensation; set "
                f"gravity_compensation = False first"
            )
        self._assign("feedforward", values)

    @property
    def effort(self) -> Floats:
        """(k,) [N m, N] that acted in the last step."""
        return reading(np.array([actuator.effort for actuator in self._actuators]), self, "effort")

    @property
    def enabled(self) -> bool:
        """Whether all act; assign it to switch all."""
        return all(actuator.enabled for actuator in self._actuators)

    @enabled.setter
    def enabled(self, value: bool) -> None:
        for actuator in self._actuators:
            actuator.enabled = value

    @property
    def gravity_compensation(self) -> bool:
        """Whether servos have as feedforward what carries the weight of the robot, computed before each step
        from where it is then."""
        return self._follower is not None

    @gravity_compensation.setter
    def gravity_compensation(self, value: bool) -> None:
        self._require_servos("gravity_compensation")
        wanted = given_flag(value, f"{self._title}: gravity_compensation")
        if wanted == self.gravity_compensation:
            return
        # Dynamic bodies follow nothing else; that of the last joint is one.
        followers = self._robot._scene._followers.setdefault(self._carrier(), [])
        if self._follower is not None:
            followers.remove(self._follower)
            self.feedforward = 0.0
        else:
            # Of the scene, not of one simulation, which the scene would keep alive.
            own = next(drives for drives in self._robot._drives if drives._rows is self._rows)
            followers.append(GravityFollower(own._robot, own._rows, own._actuators))

    @property
    def _follower(self) -> GravityFollower | None:
        """What the scene has of it, which may be put back to what it was (stark.gym)."""
        known = self._robot._scene._followers.get(self._carrier(), [])
        own = (f for f in known if isinstance(f, GravityFollower) and f._rows is self._rows)
        return next(own, None)

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        return f"<stark.robots.Drives: {self.kind} of {', '.join(self.joints)}>"

    # --- details ---

    def _carrier(self) -> int:
        side: Any = self._actuators[-1].joint._given["b"]
        return int(side["body"])

    @cached_property
    def _caps(self) -> Floats:
        joints = self._robot.description.joints
        return np.array([_or_infinite(joints[name].effort) for name in self.joints])

    def _numbers(self, name: str) -> Floats:
        return np.array([actuator._read(name) for actuator in self._actuators])

    def _values(self, name: str) -> Floats:
        self._require_value(name)
        return reading(self._numbers(name), self, name, assign=True)

    def _assign(self, name: str, values: JointValues) -> None:
        """Numbers or functions of the time, of some joints or of all; where one is refused, none is set."""
        self._require_value(name)
        given = by_joint(values, self._joints, f"{self._title}: {name}")
        ready = {k: self._prepared(k, value) for k, value in given.items()} if name == "target" else given
        core, is_simulated = self._actuators[0]._core(), self._actuators[0]._simulation() is not None
        before = {k: self._actuators[k]._read(name) for k in ready}
        try:
            for k, value in ready.items():
                if not (callable(value) and is_simulated):  # the next step asks for it
                    core.set_actuator_value(self._actuators[k]._index, name, float(at_start(value, name)))
        except Error:
            for k, number in before.items():
                core.set_actuator_value(self._actuators[k]._index, name, number)
            raise
        if self._robot._scene._courses or any(map(callable, ready.values())):
            for k, value in ready.items():
                set_courses("actuator", self._actuators[k], {name: value})
        if name == "target" and self._kind == "servos":
            self._warn_of_limits(given)

    def _prepared(self, k: int, target: TimeValue) -> TimeValue:
        """A target along the coordinate of the scene; efforts are cut at the limits of the file."""
        if callable(target):
            motion = self._prepared_motion(k, target)
            return motion or (lambda time: self._prepared(k, float(target(time))))
        if self._kind == "efforts":
            return float(np.clip(target, -self._caps[k], self._caps[k]))
        return target - float(self._shifts[k])

    def _prepared_motion(self, k: int, target: Callable[[float], Any]) -> Motion | None:
        """The same of a motion through knots; None where it is none, or a limit of effort cuts it."""
        shift = 0.0 if self._kind == "efforts" else float(self._shifts[k])
        motion = through_same_knots(target, lambda values: values - shift)
        if motion is None or self._kind != "efforts" or np.isinf(self._caps[k]):
            return motion
        knots: dict[str, Any] = motion._knots or {}
        inside = knots["kind"] == "linear" and (np.abs(knots["values"]) <= self._caps[k]).all()
        return motion if inside else None

    def _warn_of_limits(self, targets: Mapping[int, TimeValue]) -> None:
        """Once a joint: its stops keep it from this target."""
        for k, value in targets.items():
            lower, upper = self._limits[0][k], self._limits[1][k]
            target = float(at_start(value, "target"))
            if lower - _LIMIT_ROUNDING <= target <= upper + _LIMIT_ROUNDING or k in self._warned_of:
                continue
            self._warned_of.add(k)
            warn(
                f"{self._title}: target of '{self._joints[k]}' = {target:.6g} is beyond its limits, "
                f"{lower:.6g} to {upper:.6g}: the servo presses it against its stop; give targets within "
                f"robot.limits"
            )

    def _require_value(self, name: str) -> None:
        known = _VALUES[self._kind]
        if name not in known:
            owners = " and ".join(kind for kind, values in _VALUES.items() if name in values)
            raise InvalidArgument(
                f"{self._title}: {name}: only {owners} have it; {self._kind} have {', '.join(known)}"
            )

    def _require_servos(self, what: str) -> None:
        if self.kind != "servos":
            raise InvalidArgument(
                f"{self._title}: {what}: only servos have it; add robot.gravity_efforts() to the target of "
                f"efforts"
            )

    @property
    def _title(self) -> str:
        return f"robot '{self._robot.name}': {self.kind}"

    def _bound_to(self, robot: DrivenRobot, simulation: SimulationLink) -> Drives:
        bound = object.__new__(Drives)
        actuators = [actuator._bound_to(simulation) for actuator in self._actuators]
        bound.__dict__.update(self.__dict__, _robot=robot, _actuators=actuators)
        return bound


class GravityFollower:
    """Sets the feedforward of servos before each step of a simulation."""

    def __init__(self, robot: DrivenRobot, rows: list[int], actuators: list[Actuator]) -> None:
        self._robot, self._rows, self._actuators = robot, rows, actuators
        self._gravity: tuple[weakref.ref[SimulationLink], Floats] | None = None  # of the last simulation

    @property
    def title(self) -> str:
        return f"the gravity compensation of robot '{self._robot.name}'"

    def apply(self, simulation: SimulationLink, time: float, duration: float) -> None:
        """Of the coming step, from where the robot is at its start."""
        if self._actuators[-1]._index >= simulation._core.actuator_count:
            return
        efforts = self._robot._bound_to(simulation)._holding(self._gravity_of(simulation))[self._rows]
        set_values(simulation._core, self._actuators, "feedforward", efforts)

    def jump(self) -> str:
        """They move nothing to a place."""
        return ""

    def _gravity_of(self, simulation: SimulationLink) -> Floats:
        """[m/s^2]; settings of a simulation stay as they are."""
        if self._gravity is None or self._gravity[0]() is not simulation:
            self._refuse_loops(simulation)
            self._gravity = weakref.ref(simulation), np.array(simulation.settings.gravity)
        return self._gravity[1]

    def _refuse_loops(self, simulation: SimulationLink) -> None:
        """Joints of closed loops without gravity compensation: their part of the weight would be missing."""
        robot = self._robot
        followed = {row for drives in robot._drives if drives._follower is not None for row in drives._rows}
        description = robot.description
        names = description.coordinates
        passive = [
            joint.name
            for joint in description.joints.values()
            if joint.is_moving and names.index(description.drive_of(joint)[0]) not in followed
        ]
        loops = in_loops(passive, robot._joints, simulation)
        if loops:
            raise InvalidArgument(
                f"robot '{robot.name}': servos: gravity_compensation: '{next(iter(loops.values()))}' closes "
                f"a loop with {', '.join(map(repr, loops))}, which has no such servos: it is the weight of "
                f"an open tree, and must have all joints of a loop; set gravity_compensation = False and "
                f"assign feedforward, or drive the other joints so, too"
            )


def set_values(core: Any, actuators: list[Actuator], name: str, values: Floats) -> None:
    """Of actuators of one scene or simulation."""
    for actuator, value in zip(actuators, values.tolist(), strict=True):
        core.set_actuator_value(actuator._index, name, value)


def add_drives(
    robot: DrivenRobot,
    kind: str,
    rows: list[int],
    values: Mapping[str, ArrayLike | None],
    target: JointValues | None,
) -> Drives:
    """Adds "servos", "motors" or "efforts" to a robot; all values are checked before any is added."""
    names = [robot.description.coordinates[row] for row in rows]
    owner = f"robot '{robot.name}': {kind}"
    columns = {
        key: _of_file(robot, names, owner, key)
        if value is None
        else spread(value, len(rows), f"{owner}: {key}", names)
        for key, value in values.items()
    }
    if "cap" in columns:
        _warn_of_friction(robot, owner, dict(zip(names, columns["cap"].tolist(), strict=True)))
    axes = [robot._axes()[row] for row in rows]
    shifts = np.array([axis.shift if kind == "servos" else 0.0 for axis in axes])
    now = robot._start if robot._scene._latest_simulation() is None else robot.q
    start = now[rows] if kind == "servos" else np.zeros(len(rows))
    goals = {} if target is None else by_joint(target, names, f"{owner}: target")
    first = np.array([at_start(goals.get(k, value), owner) for k, value in enumerate(start.tolist())])
    with robot._scene._adding_a_whole():
        actuators = _added(
            robot, kind, dict(zip(names, (a.joint for a in axes), strict=True)), first - shifts, columns
        )
    robot._scene._warn_of_late(f"robot '{robot.name}': a group of {kind}")
    drives = Drives(robot, kind, rows, actuators, shifts)
    if target is not None:
        drives._assign("target", target)  # cuts efforts, follows functions, warns of limits
    robot._drives.append(drives)
    return drives


def _added(
    robot: DrivenRobot, kind: str, joints: Mapping[str, Joint], targets: Floats, columns: Mapping[str, Floats]
) -> list[Actuator]:
    """One a joint."""
    add: dict[str, Callable[..., Actuator]] = {
        "servos": Joint.add_servo,
        "motors": Joint.add_motor,
        "efforts": Joint.add_effort,
    }
    number = len(robot._drives) + 1
    suffix = kind.removesuffix("s") + ("" if number == 1 else f"_{number}")
    actuators = []
    for k, (name, joint) in enumerate(joints.items()):
        given: dict[str, Any] = {key: float(column[k]) for key, column in columns.items()}
        actuators.append(add[kind](joint, float(targets[k]), name=f"{robot.name}.{name}.{suffix}", **given))
    return actuators


def _warn_of_friction(robot: DrivenRobot, owner: str, caps: Mapping[str, float]) -> None:
    """Of drives that the dry friction of their joints holds fast, as the numbers of some files have it."""
    joints = [robot.description.joints[name] for name in caps]
    stuck = [
        f"'{joint.name}' ({caps[joint.name]:g} of {joint.friction:g})"
        for joint in joints
        if 0.0 < caps[joint.name] <= joint.friction
    ]
    if stuck:
        warn(
            f"{owner}: the cap is not above the dry friction of the file [N m, N]: the drive alone does not "
            f"move {', '.join(stuck)}; give a larger cap=, or correct the friction"
        )


def _of_file(robot: DrivenRobot, names: list[str], owner: str, key: str) -> Floats:
    """Caps or gains that the file says."""
    found = []
    for name in names:
        joint = robot.description.joints[name]
        value = joint.effort if key == "cap" else getattr(joint.servo, key, None)
        if value is None:
            has, must = ("limit of effort", "cap") if key == "cap" else ("servo", key)
            raise InvalidArgument(
                f"{owner}: joint '{name}' has no {has} in {robot.description.source}: must have a {must}; "
                f"give {key}="
            )
        found.append(float(value))
    return np.array(found)


def _or_infinite(value: float | None) -> float:
    return np.inf if value is None else value
