"""``stark.Scene.add_robot`` returns it: coordinates, links, joints and drives of a robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import added_later, given_flag, needs_simulation
from stark.bodies import Cloth, RigidBody, Rod, Solid
from stark.handle import SceneLink, SimulationLink
from stark.joints.handle import Joint
from stark.named import NamedDict
from stark.readings import reading
from stark.robots import kinematics
from stark.robots.base import base_velocity, place_base, placing, push_base
from stark.robots.choosing import Choice, chosen_rows
from stark.robots.closing import free_places, place_closed
from stark.robots.description import RobotDescription
from stark.robots.drives import Drives, add_drives
from stark.robots.dynamics import RobotDynamics
from stark.robots.inverse import Goal, Reach, Search, count_of, positive
from stark.robots.kinematics import Placement, Values
from stark.robots.link import RobotLink
from stark.robots.posture import settled
from stark.robots.report import Report
from stark.robots.targets import JointValues
from stark.robots.weight import CarriedWeight
from stark.rotations import as_matrix, vector

Floats = NDArray[np.float64]


class Axis(NamedTuple):
    """A joint with a coordinate in the scene: that of the robot is the one in the scene + ``shift``."""

    joint: Joint
    shift: float


class Robot(RobotDynamics):
    """A robot in a scene. q, qd and tau are arrays (n,) in the order of ``coordinates``: joints that turn or
    slide and mimic no other one. It reads the newest simulation of the scene that is alive; those of
    ``sim.robots`` read that one."""

    def __init__(
        self,
        scene: SceneLink,
        name: str,
        description: RobotDescription,
        report: Report,
        links: Mapping[str, RobotLink],
        joints: Mapping[str, Joint],
        shifts: Mapping[str, float],
        start: Floats,
        flexes: Mapping[str, Cloth | Rod | Solid] = MappingProxyType({}),
        closures: Mapping[str, Joint] = MappingProxyType({}),
    ) -> None:
        self._scene, self._of = scene, None
        self._links, self._joints, self._shifts, self._start = links, joints, dict(shifts), start
        self._flexes, self._closures = flexes, closures
        self._drives: list[Drives] = []
        self._named: dict[str, tuple[str, ...]] = {}
        self._name, self._description, self._report = name, description, report
        self._weight = CarriedWeight(description, links)

    _of: SimulationLink | None
    _elsewhere: ClassVar[Mapping[str, str]] = {
        "qpos": "robot.q",
        "qvel": "robot.qd",
        "dof": "len(robot.coordinates)",
        "joint_names": "robot.coordinates",
        "link_names": "list(robot.links)",
        "torque": "robot.tau, efforts of the drives",
    }
    _given_by: ClassVar[Mapping[str, str]] = {
        "tau": "drives.target, of robot.add_efforts()",
        "name": "scene.add_robot(..., name=...)",
    }

    @property
    def name(self) -> str:
        """Name, unique among the robots of its scene."""
        return self._name

    @property
    def description(self) -> RobotDescription:
        """What the file says, with the inertias that the bodies have."""
        return self._description

    @property
    def report(self) -> Report:
        """What was kept, assumed, dropped, and what is suspicious; ``print(robot.report)``."""
        return self._report

    # --- parts ---

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the joints that q, qd and tau are of."""
        return self.description.coordinates

    @property
    def links(self) -> Mapping[str, RobotLink]:
        """All links by name: frames, bodies, meshes."""
        if self._of is None:
            return MappingProxyType(NamedDict("link", self._links))
        of = self._of
        bound = {
            name: link if link.body is None else replace(link, body=link.body._bound_to(of))
            for name, link in self._links.items()
        }
        return MappingProxyType(bound)

    @property
    def flexes(self) -> Mapping[str, Cloth | Rod | Solid]:
        """Deformable parts by name: bodies of the scene."""
        if self._of is None:
            return MappingProxyType(dict(self._flexes))
        of = self._of
        return MappingProxyType({name: body._bound_to(of) for name, body in self._flexes.items()})

    @property
    def joints(self) -> Mapping[str, Joint]:
        """Joints of the scene by the names of the file; those that merged links have none."""
        return self._named_joints(self._joints)

    @property
    def closures(self) -> Mapping[str, Joint]:
        """Joints of the scene that close loops of links, by the names of the file."""
        return self._named_joints(self._closures)

    def _named_joints(self, joints: Mapping[str, Joint]) -> Mapping[str, Joint]:
        of = self._of
        if of is not None:
            joints = {name: joint._bound_to(of) for name, joint in joints.items()}
        return MappingProxyType(NamedDict("joint", joints))

    @property
    def bodies(self) -> tuple[RigidBody, ...]:
        """Its bodies, each once, from the base outwards."""
        found = {link.body._index: link.body for link in self.links.values() if link.body is not None}
        return tuple(found.values())

    @property
    def drives(self) -> tuple[Drives, ...]:
        """Groups of drives, in the order of adding."""
        of = self._of
        return (
            tuple(self._drives)
            if of is None
            else tuple(drives._bound_to(self, of) for drives in self._drives)
        )

    @property
    def groups(self) -> Mapping[str, tuple[str, ...]]:
        """Joints by the names of ``add_group``."""
        return MappingProxyType(self._named)

    def add_group(self, name: str, joints: Choice) -> tuple[str, ...]:
        """Gives joints a name in common: ``robot.add_group("arm", "panda_joint*")``, then
        ``robot.add_servos("arm", ...)``, ``robot.inverse_kinematics(..., joints="arm")``. Returns the joints,
        in the order of q. Raises InvalidArgument for names of joints and of other groups, and for unknown
        joints."""
        owner = f"robot '{self.name}': group"
        if not isinstance(name, str) or not name or name in self._named or name in self.coordinates:
            raise InvalidArgument(
                f"{owner} = {name!r}: must be a text that no joint or other group is called; choose another"
            )
        self._named[name] = tuple(self.coordinates[row] for row in sorted(self._rows(joints)))
        return self._named[name]

    # --- coordinates ---

    @property
    def q(self) -> Floats:
        """Coordinates (n,) [rad, m], those of the start before there is a simulation. Assign (n,) numbers or
        some by joint to place the robot in its simulation, mimicking joints included; rates stay."""
        simulation = self._simulation()
        if simulation is None:
            return reading(self._start.copy(), self, "q", assign=True)
        core = simulation._core
        found = [core.joint_coordinates(joint._index)[0].item() + shift for joint, shift in self._axes()]
        return reading(np.array(found), self, "q", assign=True)

    @q.setter
    def q(self, values: Values) -> None:
        numbers = self._given("q", values, self.q)
        core = self._require("q = ...")._to_place("q")
        if self.description.closures:
            place_closed(self, core, numbers, values)
            return
        with placing(core):
            for name, value in kinematics.joint_values(self.description, numbers).items():
                core.place_joint(self._joints[name]._index, np.array([value - self._shifts[name]]))

    @property
    def qd(self) -> Floats:
        """Rates (n,) [rad/s, m/s] in the last step. Assign (n,) numbers or some by joint to give the robot
        other velocities."""
        core = self._require("qd")._core
        found = np.array([core.joint_rates(joint._index)[0] for joint, _ in self._axes()])
        return reading(found, self, "qd", assign=True)

    @qd.setter
    def qd(self, values: Values) -> None:
        numbers = self._given("qd", values, self.qd)
        core = self._require("qd = ...")._to_place("qd")
        rates = dict(zip(self.coordinates, numbers, strict=True))
        with placing(core):
            for joint in self.description.joints.values():
                if joint.is_moving:
                    driver, ratio, _ = self.description.drive_of(joint)
                    core.push_joint(self._joints[joint.name]._index, np.array([ratio * rates[driver]]))

    @property
    def tau(self) -> Floats:
        """Efforts (n,) [N m, N] of all its drives in the last step; not those of damping, friction, stops."""
        self._require("tau")
        total = np.zeros(len(self.coordinates))
        for drives in self.drives:
            total[drives.rows] += drives.effort
        return reading(total, self, "tau")

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Lower and upper limits of q, (n,) each [rad, m]; infinite where there are none. Those of joints
        that mimic others are among them."""
        return kinematics.limits_of(self.description)

    # --- base ---

    @property
    def pose(self) -> tuple[Floats, Floats]:
        """Origin (3,) [m] and rotation (3, 3) of the frame of the base in the world. Assign (position,
        rotation), a matrix or a quaternion, to place a floating robot as one: q and rates stay, velocities
        turn with it. Raises InvalidArgument where the base is fixed or scripted, InitialIntersection where
        surfaces would meet."""
        position, rotation = self.links[self.description.root].pose
        remedy = "write robot.pose = (position, rotation)"
        return (
            reading(np.array(position), self, "pose", assign=remedy),
            reading(np.array(rotation), self, "pose", assign=remedy),
        )

    @pose.setter
    def pose(self, value: tuple[ArrayLike, ArrayLike]) -> None:
        place_base(self, value)

    @property
    def velocity(self) -> Floats:
        """Of the origin of the frame of the base (3,) [m/s]. Assign it to give all of a floating robot
        another velocity: rates stay."""
        self._require("velocity")
        return reading(base_velocity(self)[0], self, "velocity", assign=True)

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        push_base(self, "velocity", velocity=value)

    @property
    def angular_velocity(self) -> Floats:
        """Of the base (3,) [rad/s], world axes. Assign it to let all of a floating robot turn about the
        origin of the frame of the base, whose velocity stays, as do rates."""
        self._require("angular_velocity")
        return reading(base_velocity(self)[1], self, "angular_velocity", assign=True)

    @angular_velocity.setter
    def angular_velocity(self, value: ArrayLike) -> None:
        push_base(self, "angular_velocity", angular_velocity=value)

    # --- drives ---

    def add_servos(
        self,
        joints: Choice = None,
        *,
        stiffness: ArrayLike | None = None,
        damping: ArrayLike | None = None,
        cap: ArrayLike | None = None,
        target: JointValues | None = None,
        gravity_compensation: bool = False,
    ) -> Drives:
        """Servos that hold some joints at targets of q: ``stiffness`` [N m/rad, N/m], ``damping`` [N m s/rad,
        N s/m], ``cap`` [N m, N], each a number or one for each joint. Left out, they are the gains of the
        servos and the effort limits of the file; ``target`` is where the joints start.
        ``gravity_compensation``: each step has what carries the weight of the robot where it starts as
        feedforward. ``joints``: names or patterns ("finger_*"); all if left out. Raises InvalidArgument for
        unknown joints and those of which neither the file nor the call says one of these."""
        values = {"stiffness": stiffness, "damping": damping, "cap": cap}
        carries = given_flag(gravity_compensation, f"{self._title}: gravity_compensation")
        drives = add_drives(self, "servos", self._rows(joints), values, target)
        if carries:
            drives.gravity_compensation = True
        return drives

    def add_motors(
        self,
        joints: Choice = None,
        *,
        delta: ArrayLike = 0.01,
        cap: ArrayLike | None = None,
        target: JointValues | None = None,
    ) -> Drives:
        """Motors that drive some joints at target rates [rad/s, m/s], 0 at first; closer than ``delta``
        [rad/s, m/s] the effort is in proportion to the difference. Other arguments as in ``add_servos``."""
        return add_drives(self, "motors", self._rows(joints), {"delta": delta, "cap": cap}, target)

    def add_efforts(self, joints: Choice = None, *, target: JointValues | None = None) -> Drives:
        """Given efforts [N m, N] on some joints, 0 at first, cut at the effort limits of the file where there
        are some. ``joints`` as in ``add_servos``."""
        return add_drives(self, "efforts", self._rows(joints), {}, target)

    # --- kinematics ---

    def forward_kinematics(self, q: Values) -> dict[str, Placement]:
        """Frames of all links in the world for a q (n,) or numbers by joint (others as they are), by name:
        ``position`` (3,) [m], ``rotation`` (3, 3). The base and what floats are where they are now."""
        numbers = self._given("q", q, self.q)
        return kinematics.placements(self.description, numbers, *self._rests())

    def jacobian(
        self,
        link: str,
        point: ArrayLike = (0.0, 0.0, 0.0),
        q: Values | None = None,
        *,
        with_base: bool = False,
    ) -> Floats:
        """(6, n): velocity [m/s] (rows 0 to 2) of a ``point`` [m] in the frame of a link and angular velocity
        [rad/s] (rows 3 to 5), in world axes, for each rate of q, while the base rests. At the present q if
        left out. ``with_base``: (6, 6 + n), first for ``velocity`` and ``angular_velocity`` of the robot,
        those of its base in world axes. Floating and ball joints rest. Raises InvalidArgument for unknown
        links."""
        self._require_link(link)
        frames = self.forward_kinematics(self.q if q is None else q)
        place = frames[link].at(vector(point, f"robot '{self.name}': point"), np.eye(3)).position
        columns = kinematics.jacobian(self.description, frames, link, place)
        if not given_flag(with_base, f"robot '{self.name}': jacobian: with_base"):
            return columns
        return np.hstack([kinematics.base_columns(self.description, frames, link, place), columns])

    def inverse_kinematics(
        self,
        link: str,
        position: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
        *,
        point: ArrayLike = (0.0, 0.0, 0.0),
        joints: Choice = None,
        start: Values | None = None,
        prefer: Values | None = None,
        nearest: bool = False,
        position_tolerance: float = 1e-6,
        rotation_tolerance: float = 1e-6,
        length: float = 0.3,
        attempts: int = 16,
        iterations: int = 200,
    ) -> Reach:
        """q within the limits that brings a ``point`` [m] of a link to ``position`` (3,) [m], the link to
        ``rotation`` (matrix or quaternion), or both; the base and floating joints are where they are now.
        ``joints``: names, patterns or groups of those that may move; others keep ``start``, which is the
        present q if left out. The q next to the start is looked for first, then from random ones,
        ``attempts`` in all, the same at every call, of at most ``iterations`` each. Damped least squares
        (Siciliano et al. 2009, 3.7); ``length`` [m] is what an error of one radian counts as. Where more
        joints move than the goal needs, ``prefer`` is a posture, q: what was found slides along the goal to
        where it is next to that, by the sum of squares of all coordinates, and the posture is the start,
        too, if that is left out. ``.q`` can be
        assigned to ``robot.q`` or be the target of servos; ``.position_error`` [m] and ``.rotation_error``
        [rad] are what is left.

        Raises InvalidArgument where more than the tolerances [m], [rad] are left, with what is left and the
        joints at their limits; with ``nearest=True`` the best is returned instead."""
        owner = f"robot '{self.name}': inverse_kinematics of '{link}'"
        self._require_link(link)
        if position is None and rotation is None:
            raise InvalidArgument(f"{owner}: position and rotation are left out: must be given, one at least")
        search = Search(
            Goal(
                None if position is None else vector(position, f"{owner}: position"),
                None if rotation is None else as_matrix(rotation, f"{owner}: rotation"),
                positive(length, f"{owner}: length", "m"),
            ),
            positive(position_tolerance, f"{owner}: position_tolerance", "m"),
            positive(rotation_tolerance, f"{owner}: rotation_tolerance", "rad"),
            count_of(attempts, f"{owner}: attempts"),
            count_of(iterations, f"{owner}: iterations"),
        )
        place, takes_nearest = vector(point, f"{owner}: point"), given_flag(nearest, f"{owner}: nearest")
        wanted = None if prefer is None else self._given("prefer", prefer, self.q)
        first = self.q if wanted is None else wanted
        begin = self._given("start", first if start is None else start, self.q)
        lower, upper = self.limits
        begin = np.clip(begin, lower, upper)
        held = np.setdiff1d(np.arange(len(begin)), self._rows(joints))
        lower[held] = upper[held] = begin[held]
        base, free = self._rests()

        def frame_and_jacobian(q: Floats) -> tuple[Placement, Floats]:
            frames = kinematics.placements(self.description, q, base, free)
            tip = frames[link].at(place, np.eye(3))
            return tip, kinematics.jacobian(self.description, frames, link, tip.position)

        found = search.run(frame_and_jacobian, begin, (lower, upper), self.coordinates)
        if search.is_met(found):
            if wanted is None:
                return found
            return settled(search, found, wanted, frame_and_jacobian, (lower, upper), self.coordinates)
        if not takes_nearest:
            movable = frame_and_jacobian(begin)[1][:, upper > lower]
            raise InvalidArgument(search.refusal(owner, found, is_carried=bool(movable.any())))
        return found

    @property
    def _title(self) -> str:
        return f"robot '{self.name}'"

    def __repr__(self) -> str:
        return f"<stark.Robot '{self.name}': {len(self._links)} links, {len(self.coordinates)} coordinates>"

    # --- details ---

    def _axes(self) -> list[Axis]:
        """In the order of q."""
        return [Axis(self._joints[name], self._shifts[name]) for name in self.coordinates]

    def _frame(self, name: str) -> Placement:
        """Of a link, now."""
        link = self._links[name]
        if link.body is None:
            return link.offset
        body = link.body if self._of is None else link.body._bound_to(self._of)
        return Placement(*body.pose).at(*link.offset)

    def _holding(self, gravity: Floats) -> Floats:
        """Efforts (n,) [N m, N] that hold it where it is."""
        simulation = self._simulation()
        return self._weight.efforts((self._scene if simulation is None else simulation)._core, gravity)

    def _rests(self) -> tuple[Placement, dict[str, Placement]]:
        """Frames that no coordinate places, now: that of the base, those of children of floating joints, and
        of ball joints in the parent."""
        return self._frame(self.description.root), free_places(self.description, self._frame)

    def _given(self, what: str, values: Values, present: Floats) -> Floats:
        if isinstance(values, Mapping):
            kinematics.numbers_of(self.description, values, what)
            values = {**dict(zip(self.coordinates, present, strict=True)), **values}
        return kinematics.numbers_of(self.description, values, what)

    def _rows(self, joints: Choice) -> list[int]:
        """Places in q of some joints."""
        return chosen_rows(self._title, joints, self.coordinates, self._named)

    def _require_link(self, link: str) -> None:
        if not isinstance(link, str) or link not in self._links:
            raise InvalidArgument(
                f"robot '{self.name}': link '{link}': must be one of {', '.join(self._links)}"
            )

    def _simulation(self) -> SimulationLink | None:
        simulation = self._scene._latest_simulation() if self._of is None else self._of
        if simulation is None:  # never made, or gone: then q is not that of the start
            for body in self.bodies[:1]:
                body._if_gone()
        return simulation if simulation is not None and self._is_in(simulation) else None

    def _is_in(self, simulation: SimulationLink) -> bool:
        bodies = [link.body._index for link in self._links.values() if link.body is not None]
        return max(bodies, default=-1) < simulation._core.body_count

    def _require(self, what: str) -> SimulationLink:
        simulation = self._simulation()
        if simulation is None:
            late = self._scene._latest_simulation() is not None
            raise (added_later if late else needs_simulation)(f"robot '{self.name}'", what)
        return simulation

    def _bound_to(self, simulation: SimulationLink) -> Robot:
        robot: Robot = object.__new__(type(self))
        robot.__dict__.update(self.__dict__, _of=simulation)
        return robot
