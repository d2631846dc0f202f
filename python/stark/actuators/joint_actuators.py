"""The actuator methods of a joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stark._core import InvalidArgument
from stark.arguments import real_number

if TYPE_CHECKING:
    from stark.actuators.definition import ActuatorFormula
    from stark.actuators.handle import Actuator
    from stark.joints.handle import Joint
    from stark.scene import Scene
    from stark.simulation import Simulation


class JointActuators:
    """What ``stark.Joint`` knows about actuators.

    All act along a coordinate of the joint: its only one, or ``coordinate="angle"``. Efforts are torques
    [N m] along angles and forces [N] along displacements, positive where they raise the coordinate: they act
    on side b, their opposites on side a. Options of all: ``coordinate``, ``name``, ``enabled``."""

    _scene: Scene
    _index: int
    _simulation: Simulation | None

    def add_actuator(
        self,
        kind: str | ActuatorFormula,
        *,
        coordinate: str | None = None,
        name: str | None = None,
        enabled: bool = True,
        **values: float,
    ) -> Actuator:
        """Adds an actuator of any kind: the name of a built-in one or a function with ``@stark.actuator``;
        ``values`` are those that the kind has."""
        on = self if coordinate is None else (self, coordinate)
        return self._scene.add_actuator(kind, on, name=name, enabled=enabled, **values)  # type: ignore[arg-type]

    def add_motor(self, target: float = 0.0, *, cap: float, delta: float, **options: Any) -> Actuator:
        """Drives the rate to ``target`` [rad/s, m/s] with at most ``cap`` [N m, N]; closer than ``delta``
        [rad/s, m/s] to it the effort is in proportion to the difference."""
        return self.add_actuator("velocity_motor", target=target, cap=cap, delta=delta, **options)

    def add_servo(
        self,
        target: float = 0.0,
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
        return self.add_actuator(
            "position_servo",
            target=target,
            stiffness=stiffness,
            damping=damping,
            integral=integral,
            cap=cap,
            **options,
        )

    def add_effort(self, target: float = 0.0, **options: Any) -> Actuator:
        """A given torque [N m] or force [N]: ``target``."""
        return self.add_actuator("effort", target=target, **options)

    def add_spring(
        self, stiffness: float, *, damping: float = 0.0, rest: float = 0.0, **options: Any
    ) -> Actuator:
        """Linear spring with linear damper; ``rest``: the coordinate where the spring rests [rad, m]."""
        return self.add_actuator("spring_damper", stiffness=stiffness, damping=damping, rest=rest, **options)

    def add_friction(
        self, cap: float, *, stick_rate: float = 1e-3, viscous: float = 0.0, **options: Any
    ) -> Actuator:
        """Dry friction of at most ``cap`` [N m, N], which it reaches at ``stick_rate`` [rad/s, m/s] (a joint
        that sticks creeps slower than that), and viscous friction [N m s/rad, N s/m]."""
        return self.add_actuator("joint_friction", cap=cap, stick_rate=stick_rate, viscous=viscous, **options)

    def add_armature(self, inertia: float, **options: Any) -> Actuator:
        """Inertia of the coordinate [kg m^2, kg] that is in neither body, such as that of a geared rotor."""
        return self.add_actuator("armature", inertia=inertia, **options)

    def add_limit(self, lower: float | None = None, upper: float | None = None, **options: Any) -> Actuator:
        """Stops at ``lower`` and ``upper`` [rad, m], or at one of them; held within the tolerances of joints,
        whatever pushes."""
        bounds = (("lower", lower), ("upper", upper))
        given = {k: real_number(value, f"add_limit: {k}") for k, value in bounds if value is not None}
        if not given:
            raise InvalidArgument("add_limit: neither lower nor upper is given: give one of them or both")
        if len(given) == 2 and not given["lower"] < given["upper"]:
            raise InvalidArgument(f"add_limit: lower = {lower}, upper = {upper}: lower must be below upper")
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
        the tolerances of joints. Gears, belts, racks, mimic joints."""
        on = [(self, coordinate or ""), (other, other_coordinate or "")]
        return self._scene.add_actuator("gear", on, name=name, enabled=enabled, ratio=ratio, offset=offset)

    @property
    def actuators(self) -> tuple[Actuator, ...]:
        """Actuators on coordinates of this joint, in the order of adding."""
        known = self._scene.actuators if self._simulation is None else self._simulation.actuators
        return tuple(a for a in known if any(joint._index == self._index for joint, _ in a.coordinates))
