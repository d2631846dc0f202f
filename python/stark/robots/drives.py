"""Drives of several joints of a robot, with targets as arrays."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import given_flag, real_array
from stark.courses import set_courses
from stark.handle import SceneLink, SimulationLink
from stark.joints.handle import Actuator, Joint
from stark.readings import reading
from stark.robots.description import RobotDescription

Floats = NDArray[np.float64]


class DrivenRobot(Protocol):
    """What drives need of a robot."""

    name: str
    description: RobotDescription
    _scene: SceneLink
    _drives: list[Drives]

    @property
    def q(self) -> Floats: ...

    def _holding(self, gravity: Floats) -> Floats: ...

    def _axes(self) -> Any: ...

    def _bound_to(self, simulation: SimulationLink) -> DrivenRobot: ...

    def _is_in(self, simulation: SimulationLink) -> bool: ...


class Drives:
    """Actuators of one kind on some joints of a robot; arrays (k,) are in the order of ``joints``."""

    def __init__(
        self, robot: DrivenRobot, kind: str, rows: list[int], actuators: list[Actuator], shifts: Floats
    ) -> None:
        self._robot, self._actuators, self._shifts = robot, actuators, shifts
        self.kind: str = kind
        """ "servos", "motors" or "efforts"."""
        self.rows: list[int] = rows
        """Where the joints are in q."""
        self._follower: GravityFollower | None = None
        coordinates = robot.description.coordinates
        self._joints = tuple(coordinates[row] for row in rows)

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
        """(k,) q [rad, m] of servos, rates [rad/s, m/s] of motors, efforts [N m, N]; assign (k,) numbers, or
        one for all, that hold from the next step on."""
        found = np.array([actuator.target for actuator in self._actuators]) + self._shifts
        return reading(found, self, "target", assign=True)

    @target.setter
    def target(self, values: ArrayLike) -> None:
        numbers = self._numbers("target", values)
        if self.kind == "efforts":
            caps = self._caps()
            numbers = np.clip(numbers, -caps, caps)
        numbers -= self._shifts
        set_values(self._actuators[0]._core(), self._actuators, "target", numbers)
        if self._robot._scene._courses:
            for actuator, value in zip(self._actuators, numbers.tolist(), strict=True):
                set_courses("actuator", actuator, {"target": value})

    @property
    def feedforward(self) -> Floats:
        """(k,) [N m, N] that servos add to their own effort, within their cap; assign it."""
        self._require_servos("feedforward")
        found = np.array([actuator.feedforward for actuator in self._actuators])
        return reading(found, self, "feedforward", assign=True)

    @feedforward.setter
    def feedforward(self, values: ArrayLike) -> None:
        self._require_servos("feedforward")
        if self.gravity_compensation:
            raise InvalidArgument(
                f"{self._title}: feedforward: is that of the gravity compensation; set "
                f"gravity_compensation = False first"
            )
        for actuator, value in zip(self._actuators, self._numbers("feedforward", values), strict=True):
            actuator.feedforward = float(value)

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
            self._follower = None
            self.feedforward = 0.0
        else:
            self._follower = GravityFollower(self._robot, self.rows, self._actuators)
            followers.append(self._follower)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return f"<stark.robots.Drives: {self.kind} of {', '.join(self.joints)}>"

    # --- details ---

    def _carrier(self) -> int:
        side: Any = self._actuators[-1].joint._given["b"]
        return int(side["body"])

    def _caps(self) -> Floats:
        joints = self._robot.description.joints
        return np.array([_or_infinite(joints[name].effort) for name in self.joints])

    def _numbers(self, what: str, values: ArrayLike) -> Floats:
        return spread(values, len(self), f"{self._title}: {what}", self.joints)

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
            self._gravity = weakref.ref(simulation), np.array(simulation.settings.gravity)
        return self._gravity[1]


def set_values(core: Any, actuators: list[Actuator], name: str, values: Floats) -> None:
    """Of actuators of one scene or simulation."""
    for actuator, value in zip(actuators, values.tolist(), strict=True):
        core.set_actuator_value(actuator._index, name, value)


def add_drives(
    robot: DrivenRobot,
    kind: str,
    rows: list[int],
    values: Mapping[str, ArrayLike | None],
    target: ArrayLike | None,
) -> Drives:
    """Adds "servos", "motors" or "efforts" to a robot; all values are checked before any is added."""
    names = [robot.description.coordinates[row] for row in rows]
    owner = f"robot '{robot.name}': {kind}"
    columns = {
        key: _caps_of(robot, names, owner)
        if value is None
        else spread(value, len(rows), f"{owner}: {key}", names)
        for key, value in values.items()
    }
    axes = [robot._axes()[row] for row in rows]
    shifts = np.array([axis.shift if kind == "servos" else 0.0 for axis in axes])
    start = robot.q[rows] if kind == "servos" else np.zeros(len(rows))
    wanted = start if target is None else spread(target, len(rows), f"{owner}: target", names)
    kinds: dict[str, Callable[..., Actuator]] = {
        "servos": Joint.add_servo,
        "motors": Joint.add_motor,
        "efforts": Joint.add_effort,
    }
    number = len(robot._drives) + 1
    actuators = []
    for k, name in enumerate(names):
        given: dict[str, Any] = {key: float(column[k]) for key, column in columns.items()}
        title = f"{robot.name}.{name}.{kind.removesuffix('s')}{'' if number == 1 else f'_{number}'}"
        actuators.append(kinds[kind](axes[k].joint, float(wanted[k] - shifts[k]), name=title, **given))
    drives = Drives(robot, kind, rows, actuators, shifts)
    if kind == "efforts":
        drives.target = wanted  # cuts it
    robot._drives.append(drives)
    return drives


def spread(values: ArrayLike, count: int, what: str, names: Any) -> Floats:
    """One number for all, or one for each."""
    numbers = real_array(values, what)
    if numbers.shape not in ((), (count,)):
        raise InvalidArgument(
            f"{what} has the shape {numbers.shape}: must be a number or ({count},), for {', '.join(names)}"
        )
    if not np.isfinite(numbers).all():
        raise InvalidArgument(f"{what} = {numbers.tolist()}: must be finite; check where it is computed")
    return numbers if numbers.ndim else np.full(count, float(numbers))


def _caps_of(robot: DrivenRobot, names: list[str], owner: str) -> Floats:
    joints = robot.description.joints
    for name in names:
        if joints[name].effort is None:
            raise InvalidArgument(
                f"{owner}: joint '{name}' has no limit of effort in {robot.description.source}: must have a "
                f"cap; give cap="
            )
    return np.array([joints[name].effort for name in names])


def _or_infinite(value: float | None) -> float:
    return np.inf if value is None else value
