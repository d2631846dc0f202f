"""Joints of a scene and the actuators on their coordinates. Each names the other, so they share a file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import given_coordinate, nearest, real_number
from stark.caller import warn
from stark.courses import TimeValue, at_start, set_courses
from stark.handle import Handle, SceneLink, SimulationLink
from stark.joints.other_names import ELSEWHERE
from stark.joints.stops import checked_stops
from stark.readings import named_readings, reading
from stark.rotations import LARGEST, warn_of_degrees

if TYPE_CHECKING:
    # Formulas are imported when they are needed: half of the time that `import stark` would take.
    from stark.actuators.definition import ActuatorFormula
    from stark.joints.definition import JointFormula

Floats = NDArray[np.float64]


class Wrench(NamedTuple):
    """Force [N] and torque [N m], world axes."""

    force: Floats
    torque: Floats


class JointActuators(Handle):
    """What ``stark.Joint`` knows about actuators.

    All act along a coordinate of the joint: its only one, or ``coordinate="angle"``. Efforts are torques
    [N m] along angles and forces [N] along displacements, positive where they raise the coordinate: they act
    on side b, their opposites on side a. Options of all: ``coordinate``, ``name``, ``enabled``."""

    _coordinates: tuple[tuple[str, str], ...]  # names and units

    def _is_angle(self, coordinate: str | None = None) -> bool:
        return {unit for name, unit in self._coordinates if coordinate in (None, name)} == {"rad"}

    def add_actuator(
        self,
        kind: str | ActuatorFormula,
        *,
        coordinate: str | None = None,
        name: str | None = None,
        enabled: bool = True,
        **values: TimeValue,
    ) -> Actuator:
        """Adds an actuator of any kind: the name of a built-in one or a function with ``@stark.actuator``;
        ``values`` are those that the kind has, numbers or functions of the time [s]."""
        on = self, given_coordinate(coordinate, f"{self._title}: add_actuator: coordinate")
        added: Actuator = self._scene.add_actuator(kind, on, name=name, enabled=enabled, **values)
        return added

    def add_motor(self, target: TimeValue = 0.0, *, cap: float, delta: float, **options: Any) -> Actuator:
        """Drives the rate to ``target`` [rad/s, m/s] with at most ``cap`` [N m, N]; closer than ``delta``
        [rad/s, m/s] to it the effort is in proportion to the difference."""
        return self.add_actuator("velocity_motor", target=target, cap=cap, delta=delta, **options)

    def add_servo(
        self,
        target: TimeValue = 0.0,
        *,
        stiffness: float,
        damping: float,
        cap: float,
        integral: float = 0.0,
        **options: Any,
    ) -> Actuator:
        """Drives the coordinate to ``target`` [rad, m], full turns included, with a PID controller of at most
        ``cap`` [N m, N]. ``stiffness``: effort per error; ``damping``: per rate; ``integral``: per error and
        second. ``target_rate`` and ``feedforward`` are further values."""
        if self._is_angle(options.get("coordinate")):
            warn_of_degrees(f"{self._title}: add_servo: target", target)
        return self.add_actuator(
            "position_servo",
            target=target,
            stiffness=stiffness,
            damping=damping,
            integral=integral,
            cap=cap,
            **options,
        )

    def add_effort(self, target: TimeValue = 0.0, **options: Any) -> Actuator:
        """A given torque [N m] or force [N]: ``target``."""
        return self.add_actuator("effort", target=target, **options)

    def add_spring(
        self, stiffness: float, damping: float = 0.0, rest: TimeValue = 0.0, **options: Any
    ) -> Actuator:
        """Linear spring with linear damper; ``rest``: the coordinate where the spring rests [rad, m]."""
        return self.add_actuator("spring_damper", stiffness=stiffness, damping=damping, rest=rest, **options)

    def add_friction(
        self, cap: float, stick_rate: float = 1e-3, viscous: float = 0.0, **options: Any
    ) -> Actuator:
        """Dry friction of at most ``cap`` [N m, N], which it reaches at ``stick_rate`` [rad/s, m/s] (a joint
        that sticks creeps slower than that), and viscous friction [N m s/rad, N s/m]."""
        return self.add_actuator("joint_friction", cap=cap, stick_rate=stick_rate, viscous=viscous, **options)

    def add_brake(
        self, cap: TimeValue, give: float = 1e-4, engaged: TimeValue = 1.0, **options: Any
    ) -> Actuator:
        """Holds the coordinate where it is when the brake is engaged, without creep, with at most ``cap``
        [N m, N]; slips beyond. ``give`` [rad, m]: how far it gives way at ``cap``, which comes back.
        ``engaged``: 1 holds, 0 lets go, from the next step on; it holds what it finds at the start of the
        step in which it is engaged [theory eq. 36a]."""
        return self.add_actuator("brake", cap=cap, give=give, engaged=engaged, **options)

    def add_armature(self, inertia: float, **options: Any) -> Actuator:
        """Inertia of the coordinate [kg m^2, kg] that is in neither body, such as that of a geared rotor."""
        return self.add_actuator("armature", inertia=inertia, **options)

    def add_limit(
        self, lower: TimeValue | None = None, upper: TimeValue | None = None, **options: Any
    ) -> Actuator:
        """Stops at ``lower`` and ``upper`` [rad, m], or at one of them; held within the tolerances of joints,
        whatever pushes."""
        given = checked_stops(self._title, lower, upper, self._is_angle())
        kind = "limit" if len(given) == 2 else f"{next(iter(given))}_limit"
        return self.add_actuator(kind, **given, **options)

    def add_gear(
        self,
        other: Joint,
        ratio: float,
        *,
        offset: float = 0.0,
        coordinate: str | None = None,
        other_coordinate: str | None = None,
        name: str | None = None,
        enabled: bool = True,
    ) -> Actuator:
        """Couples two joints: this coordinate = ``ratio`` times that of ``other`` + ``offset``; held within
        the tolerances of joints. Gears, belts, racks, mimic joints; two coordinates of one cylindrical joint
        make a screw. Raises InvalidArgument where both are the same one."""
        title = f"{self._title}: add_gear"
        coordinate = given_coordinate(coordinate, f"{title}: coordinate")
        other_coordinate = given_coordinate(other_coordinate, f"{title}: other_coordinate")
        if self._is_geared_to_itself(other, coordinate, other_coordinate):
            raise InvalidArgument(
                f"{title}: both coordinates are the same one: must be two; give another "
                "joint, or coordinate= and other_coordinate= of this one"
            )
        gear: Actuator = self._scene.add_actuator(
            "gear",
            [(self, coordinate), (other, other_coordinate)],
            name=name,
            enabled=enabled,
            ratio=ratio,
            offset=offset,
        )
        return gear

    def _is_geared_to_itself(self, other: Any, coordinate: str, other_coordinate: str) -> bool:
        if not isinstance(other, Joint) or other._scene is not self._scene or other._index != self._index:
            return False
        return len(other._coordinates) == 1 or coordinate == other_coordinate

    @property
    def actuators(self) -> tuple[Actuator, ...]:
        """Actuators on coordinates of this joint, in the order of adding."""
        known: list[Actuator] = self._scene._actuators_on(self._index)
        if self._of is not None:
            count = self._of._core.actuator_count
            known = [a._bound_to(self._of) for a in known if a._index < count]
        return tuple(known)


class Joint(JointActuators):
    """A joint of a scene. Its coordinates are attributes: ``hinge.angle``, ``slider.displacement``. When one
    is assigned, what hangs on side b of the joint is placed so, at once and as one (docs/state.md)."""

    _formula: JointFormula
    _enabled_at_start: bool
    _given: Mapping[str, Any]  # sides a and b and values, as the core was given them

    def __init__(
        self, scene: SceneLink, index: int, formula: JointFormula, enabled: bool, given: Mapping[str, Any]
    ) -> None:
        super().__init__(scene, index)
        self.__dict__.update(
            _formula=formula, _coordinates=formula.coordinates, _enabled_at_start=enabled, _given=given
        )

    @property
    def name(self) -> str:
        """Name, unique in its scene."""
        return self._scene._core.joint_name(self._index)

    @property
    def kind(self) -> str:
        """Name of the definition: "hinge", or that of the decorated function."""
        return self._formula.name

    @property
    def formula(self) -> JointFormula:
        """The definition."""
        return self._formula

    @property
    def coordinates(self) -> dict[str, float]:
        """Coordinates by name [m, rad]; angles are counted over full turns from time 0 on. Assign some or all
        of them to place what hangs on the joint; rates stay."""
        found = self._require_simulation("coordinates")._core.joint_coordinates(self._index)
        return named_readings(self._named(found), self, "coordinates", assign=True)

    @coordinates.setter
    def coordinates(self, values: Mapping[str, float]) -> None:
        numbers = self._numbers("coordinates", values, dict(self.coordinates))
        simulation = self._require_simulation("coordinates")
        simulation._to_place("coordinates").place_joint(self._index, numbers)

    @property
    def rates(self) -> dict[str, float]:
        """Rates of the coordinates in the last step, by name [m/s, rad/s]. Assign some or all of them to give
        what hangs on the joint other velocities."""
        found = self._require_simulation("rates")._core.joint_rates(self._index)
        return named_readings(self._named(found), self, "rates", assign=True)

    @rates.setter
    def rates(self, values: Mapping[str, float]) -> None:
        numbers = self._numbers("rates", values, dict(self.rates))
        self._require_simulation("rates")._to_place("rates").push_joint(self._index, numbers)

    @property
    def residuals(self) -> Floats:
        """What is left of the residuals that it holds [m, rad], in the order of the definition."""
        found = self._require_simulation("residuals")._core.joint_residuals(self._index)
        return reading(found, self, "residuals")

    @property
    def reaction(self) -> Wrench:
        """Force and torque of the joint on what carries frame b in the last step, about the origin of that
        frame; what carries frame a gets the opposite. After a rewind, of the multipliers of the state, which
        differ by what residuals below a hundredth of the tolerance hold."""
        force, torque = self._require_simulation("reaction")._core.joint_reaction(self._index)
        return Wrench(reading(force, self, "reaction.force"), reading(torque, self, "reaction.torque"))

    @property
    def break_force(self) -> float:
        """[N], infinite for a joint that no force breaks."""
        return float(self._given["break_force"])

    @property
    def break_torque(self) -> float:
        """[N m], about the origin of frame b; infinite for a joint that no torque breaks."""
        return float(self._given["break_torque"])

    @property
    def broken(self) -> bool:
        """Whether its reaction exceeded what it stands: it never holds again, but after a rewind."""
        return self._require_simulation("broken")._core.joint_broken(self._index)

    @property
    def enabled(self) -> bool:
        """Whether it holds; assign False to release it and True to hold it again, from the next step on,
        unless it is broken. Raises InvalidArgument where its frames are apart by then, as at time 0."""
        simulation = self._simulation()
        return self._enabled_at_start if simulation is None else simulation._core.joint_enabled(self._index)

    @enabled.setter
    def enabled(self, value: bool) -> None:
        if not isinstance(value, (bool, np.bool_)):
            raise InvalidArgument(f"joint '{self.name}': enabled = {value!r}: must be True or False")
        core = self._require_simulation("enabled")._core
        if value and core.joint_broken(self._index):
            warn(f"joint '{self.name}' is broken and stays released; go back to a state from before")
        elif value:
            core.check_joint_agrees(self._index)
        core.set_joint_enabled(self._index, bool(value))

    def pull_together(self) -> None:
        """Holds it again wherever its frames are, unless it is broken: the next step brings them together at
        the speed of the gap over the time step, with the energy of that, which comes from nowhere."""
        self._require_simulation("pull_together")._core.set_joint_enabled(self._index, True)

    def hold_here(self) -> None:
        """Holds both sides as they are now; only fixed and ball joints added with ``enabled=False`` can."""
        self._require_simulation("hold_here")._core.hold_joint_here(self._index)

    def __getattr__(self, name: str) -> float:
        if name.startswith("_"):  # asked for while a copy has no attributes yet
            raise AttributeError(name)
        for k, (known, _) in enumerate(self._coordinates):
            if name == known:
                return float(self._require_simulation(name)._core.joint_coordinates(self._index)[k])
        coordinates = [coordinate for coordinate, _ in self._coordinates]
        near = nearest(name, coordinates + [known for known in dir(self) if not known.startswith("_")])
        hint = f"; write {ELSEWHERE[name]}" if name in ELSEWHERE else near and f"; did you mean '{near}'?"
        raise AttributeError(
            f"joint of the kind '{self._formula.name}' has no attribute '{name}'; its coordinates: "
            f"{', '.join(coordinates) or 'none'}{hint}"
        )

    def __setattr__(self, name: str, value: Any) -> None:
        # A plain attribute would hide the coordinate of that name, and misspelt ones would do nothing.
        known = [coordinate for coordinate, _ in self._coordinates]
        if name in known:
            self._require_simulation(f"{name} = ...")
            self.coordinates = {name: value}
        elif name in ("enabled", "coordinates", "rates"):
            object.__setattr__(self, name, value)
        else:
            raise AttributeError(
                f"joint '{self.name}': '{name}' cannot be set; {', '.join([*known, 'coordinates', 'rates'])} "
                f"and enabled are what can be assigned"
            )

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(name for name, _ in self._coordinates)]

    def __repr__(self) -> str:
        return f"<stark.Joint '{self.name}' ({self.kind})>"

    def _numbers(self, what: str, given: Any, present: dict[str, float]) -> Floats:
        """Present numbers by name, some replaced by those that are given."""
        names = ", ".join(present) or "none, as joints of its kind have no coordinates"
        if not isinstance(given, Mapping):
            raise InvalidArgument(f"{self._title}: {what} = {given!r}: must be numbers by name: {names}")
        for name, value in given.items():
            if name not in present:
                raise InvalidArgument(
                    f"{self._title}: {what}: has no coordinate {name!r}: must be one of {names}"
                )
            present[name] = real_number(value, f"joint '{self.name}': {what}: {name}")
            if LARGEST <= abs(present[name]) < np.inf:  # the core says what is not finite
                raise InvalidArgument(f"{self._title}: {what}: {name} = {value}: must not be beyond 1e150")
            if what == "coordinates" and self._is_angle(name):
                warn_of_degrees(f"{self._title}: {name}", value)
        return np.array(list(present.values()), dtype=np.float64)

    def _named(self, values: Floats) -> dict[str, float]:
        return {name: float(v) for (name, _), v in zip(self._coordinates, values, strict=True)}

    @property
    def _title(self) -> str:
        return f"joint '{self.name}'"

    def _count_in(self, simulation: SimulationLink) -> int:
        return simulation._core.joint_count


class Actuator(Handle):
    """An actuator of a scene. Its values are attributes: ``motor.target = 2.0`` holds from the next step on;
    before a simulation is made it is the value to start with. Values are part of ``sim.state``. A function of
    the time [s] is followed: each step takes its value at the end of the step, until another is assigned."""

    _formula: ActuatorFormula
    _on: tuple[tuple[Joint, str, str], ...]  # joint, name and unit of its coordinate
    _units: dict[str, str]

    def __init__(
        self, scene: SceneLink, index: int, formula: ActuatorFormula, on: tuple[tuple[Joint, str, str], ...]
    ) -> None:
        super().__init__(scene, index)
        rows = formula.core.parameters([unit for _, _, unit in on])
        units = {row["name"]: row["unit"] for row in rows}
        self.__dict__.update(_formula=formula, _on=on, _units=units)

    @property
    def name(self) -> str:
        """Name, unique in its scene."""
        return self._scene._core.actuator_name(self._index)

    @property
    def kind(self) -> str:
        """Name of the definition: "velocity_motor", or that of the decorated function."""
        return self._formula.name

    @property
    def formula(self) -> ActuatorFormula:
        """The definition."""
        return self._formula

    @property
    def joint(self) -> Joint:
        """The joint that it acts on, of a gear the first one."""
        return self._on[0][0]

    @property
    def coordinates(self) -> tuple[tuple[Joint, str], ...]:
        """Joint and name of each coordinate that it acts on."""
        return tuple((joint, name) for joint, name, _ in self._on)

    @property
    def parameters(self) -> dict[str, float]:
        """Its values by name, a copy."""
        return named_readings({name: self._read(name) for name in self._units}, self, "parameters")

    @property
    def units(self) -> dict[str, str]:
        """Units of its values by name."""
        return dict(self._units)

    @property
    def effort(self) -> float:
        """Force [N] or torque [N m] along its coordinate in the last step, of a gear the first one, positive
        where it raises the coordinate. It acts on side b of the joint, its opposite on side a."""
        return float(self._require_simulation("effort")._core.actuator_effort(self._index))

    @property
    def torque(self) -> float:
        """``effort`` along an angle [N m]."""
        return self._effort_along("rad", "torque", "force")

    @property
    def force(self) -> float:
        """``effort`` along a displacement or a distance [N]."""
        return self._effort_along("m", "force", "torque")

    @property
    def power(self) -> float:
        """Power that it fed into the motion in the last step [W]: effort times rate."""
        return float(self._require_simulation("power")._core.actuator_power(self._index))

    @property
    def enabled(self) -> bool:
        """Whether it acts; assign it to switch. Gears and stops that do not hold are refused."""
        return bool(self._core().actuator_enabled(self._index))

    @enabled.setter
    def enabled(self, value: bool) -> None:
        if not isinstance(value, (bool, np.bool_)):
            raise InvalidArgument(f"actuator '{self.name}': enabled = {value!r}: must be True or False")
        self._core().set_actuator_enabled(self._index, bool(value))

    def __getattr__(self, name: str) -> float:
        if not name.startswith("_") and name in self._units:
            return self._read(name)
        raise AttributeError(f"actuator '{self.name}' has no attribute '{name}'; {self._known()}")

    def __setattr__(self, name: str, value: Any) -> None:
        if name == "enabled":
            object.__setattr__(self, name, value)
        elif name in self._units:
            number = real_number(at_start(value, f"{self._title}: {name}"), self._labelled(name))
            warn_of_degrees(f"{self._title}: {name}", value if self._units[name] == "rad" else None)
            if not callable(value) or self._simulation() is None:
                self._core().set_actuator_value(self._index, name, number)
            set_courses("actuator", self, {name: value})
        else:
            raise AttributeError(f"actuator '{self.name}' has no value '{name}'; {self._known()}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._units]

    def __repr__(self) -> str:
        where = ", ".join(f"{joint.name}.{name}" for joint, name, _ in self._on)
        return f"<stark.Actuator '{self.name}' ({self.kind}) on {where}>"

    # --- details ---

    def _follow(self, simulation: SimulationLink, name: str, value: Any) -> None:
        number = real_number(value, self._labelled(name))
        simulation._core.set_actuator_value(self._index, name, number)

    def _read(self, name: str) -> float:
        return float(self._core().actuator_value(self._index, name))

    def _labelled(self, name: str) -> str:
        return f"{self._title}: {name}" + (f" [{self._units[name]}]" if self._units[name] else "")

    def _known(self) -> str:
        return f"its values are {', '.join(self._units)}" if self._units else "it has no values"

    def _effort_along(self, unit: str, what: str, other: str) -> float:
        _, coordinate, mine = self._on[0]
        if mine != unit:
            raise InvalidArgument(
                f"{self._title} acts along '{coordinate}' [{mine}]: has no {what}; use {other} or effort"
            )
        return self.effort

    @property
    def _title(self) -> str:
        return f"actuator '{self.name}'"

    def _count_in(self, simulation: SimulationLink) -> int:
        return simulation._core.actuator_count

    def _core(self) -> Any:
        """The simulation, or the scene while there is none."""
        simulation = self._simulation()
        return self._scene._core if simulation is None else simulation._core

    def _bound_to(self, simulation: SimulationLink) -> Self:
        handle = super()._bound_to(simulation)
        on = tuple((joint._bound_to(simulation), name, unit) for joint, name, unit in self._on)
        handle.__dict__.update(_on=on)
        return handle
