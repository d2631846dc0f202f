"""Actuators of a scene: live values, efforts, power."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stark._core import InvalidArgument
from stark.arguments import added_later, needs_simulation, real_number

if TYPE_CHECKING:
    from stark.actuators.definition import ActuatorFormula
    from stark.joints.handle import Joint
    from stark.scene import Scene
    from stark.simulation import Simulation

    On = tuple[tuple[Joint, str, str], ...]  # joint, name and unit of its coordinate


class Actuator:
    """An actuator of a scene. Its values are attributes: ``motor.target = 2.0`` holds from the next step on;
    before a simulation is made it is the value to start with. Values are part of ``sim.state``."""

    _scene: Scene
    _index: int
    _formula: ActuatorFormula
    _on: On
    _simulation: Simulation | None

    def __init__(
        self,
        scene: Scene,
        index: int,
        formula: ActuatorFormula,
        on: On,
        simulation: Simulation | None = None,
    ) -> None:
        units = [unit for _, _, unit in on]
        for name, value in (
            ("_scene", scene),
            ("_index", index),
            ("_formula", formula),
            ("_on", on),
            ("_units", {row["name"]: row["unit"] for row in formula.core.parameters(units)}),
            ("_simulation", simulation),
        ):
            object.__setattr__(self, name, value)

    @property
    def name(self) -> str:
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
        return {name: self._read(name) for name in self._units}

    @property
    def units(self) -> dict[str, str]:
        """Units of its values by name."""
        return dict(self._units)

    @property
    def effort(self) -> float:
        """Force [N] or torque [N m] along its coordinate in the last step, positive where it raises the
        coordinate. It acts on side b of the joint, its opposite on side a. Of a gear: along the first
        coordinate."""
        return float(self._live("effort").actuator_effort(self._index))

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
        return float(self._live("power").actuator_power(self._index))

    @property
    def enabled(self) -> bool:
        """Whether it acts; assign it to switch. Actuators of released joints rest."""
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
            number = number_of(f"actuator '{self.name}'", name, self._units[name], value)
            self._core().set_actuator_value(self._index, name, number)
        else:
            raise AttributeError(f"actuator '{self.name}' has no value '{name}'; {self._known()}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._units]

    def __repr__(self) -> str:
        where = ", ".join(f"{joint.name}.{name}" for joint, name, _ in self._on)
        return f"<stark.Actuator '{self.name}' ({self.kind}) on {where}>"

    # --- details ---

    def _read(self, name: str) -> float:
        return float(self._core().actuator_value(self._index, name))

    def _known(self) -> str:
        return f"its values are {', '.join(self._units)}" if self._units else "it has no values"

    def _effort_along(self, unit: str, what: str, other: str) -> float:
        _, coordinate, mine = self._on[0]
        if mine != unit:
            raise InvalidArgument(
                f"actuator '{self.name}' acts along '{coordinate}' [{mine}]: has no {what}; use {other} or "
                f"effort"
            )
        return self.effort

    def _core(self) -> Any:
        """The simulation, or the scene while there is none."""
        simulation = self._simulation or self._scene._latest_simulation()
        if simulation is None or self._index >= simulation._core.actuator_count:
            return self._scene._core
        return simulation._core

    def _live(self, what: str) -> Any:
        core = self._core()
        if core is self._scene._core:
            exists = (self._simulation or self._scene._latest_simulation()) is not None
            raise (added_later if exists else needs_simulation)(f"actuator '{self.name}'", what)
        return core

    def _bound_to(self, simulation: Simulation) -> Actuator:
        on = tuple((joint._bound_to(simulation), name, unit) for joint, name, unit in self._on)
        return Actuator(self._scene, self._index, self._formula, on, simulation)


def number_of(owner: str, name: str, unit: str, value: Any) -> float:
    """A real number, or InvalidArgument that names it; its range is for the core to check."""
    return real_number(value, f"{owner}: {name} [{unit}]")


RESERVED = frozenset(name for name in vars(Actuator) if not name.startswith("_"))
"""Names that values cannot have."""
