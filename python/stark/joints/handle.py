"""Joints of a scene: coordinates, reactions, enabling."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.actuators.joint_actuators import JointActuators
from stark.arguments import added_later, needs_simulation

if TYPE_CHECKING:
    from stark.joints.definition import JointFormula
    from stark.scene import Scene
    from stark.simulation import Simulation

Floats = NDArray[np.float64]


class Wrench(NamedTuple):
    """Force [N] and torque [N m], world axes."""

    force: Floats
    torque: Floats


class Joint(JointActuators):
    """A joint of a scene. Its coordinates are attributes: ``hinge.angle``, ``slider.displacement``."""

    _scene: Scene
    _index: int
    _formula: JointFormula
    _enabled_at_start: bool
    _given: Mapping[str, Any]  # sides a and b and values, as the core was given them
    _simulation: Simulation | None

    def __init__(
        self, scene: Scene, index: int, formula: JointFormula, enabled: bool, given: Mapping[str, Any]
    ) -> None:
        for attribute, value in (
            ("_scene", scene),
            ("_index", index),
            ("_formula", formula),
            ("_enabled_at_start", enabled),
            ("_given", given),
            ("_simulation", None),
        ):
            object.__setattr__(self, attribute, value)

    @property
    def name(self) -> str:
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
        """Coordinates by name [m, rad]; angles are counted over full turns from time 0 on."""
        return self._named(self._core("coordinates").joint_coordinates(self._index))

    @property
    def rates(self) -> dict[str, float]:
        """Rates of the coordinates in the last step, by name [m/s, rad/s]."""
        return self._named(self._core("rates").joint_rates(self._index))

    @property
    def residuals(self) -> Floats:
        """What is left of the residuals that it holds [m, rad], in the order of the definition."""
        return self._core("residuals").joint_residuals(self._index)

    @property
    def reaction(self) -> Wrench:
        """Force and torque of the joint on what carries frame b in the last step, about the origin of that
        frame; what carries frame a gets the opposite. After a rewind, of the multipliers of the state, which
        differ by what residuals below a hundredth of the tolerance hold."""
        return Wrench(*self._core("reaction").joint_reaction(self._index))

    @property
    def enabled(self) -> bool:
        """Whether it holds; assign False to release it and True to hold it again, from the next step on."""
        simulation = self._simulation or self._scene._latest_simulation()
        return self._enabled_at_start if simulation is None else simulation._core.joint_enabled(self._index)

    @enabled.setter
    def enabled(self, value: bool) -> None:
        if not isinstance(value, (bool, np.bool_)):
            raise InvalidArgument(f"joint '{self.name}': enabled = {value!r}: must be True or False")
        self._core("enabled").set_joint_enabled(self._index, bool(value))

    def __getattr__(self, name: str) -> float:
        if name.startswith("_"):  # asked for while a copy has no attributes yet
            raise AttributeError(name)
        if name in (known := [n for n, _ in self._formula.coordinates]):
            return float(self._core(name).joint_coordinates(self._index)[known.index(name)])
        raise AttributeError(f"joint of the kind '{self._formula.name}' has no attribute '{name}'")

    def __setattr__(self, name: str, value: Any) -> None:
        # A plain attribute would hide the coordinate of that name, and misspelt ones would do nothing.
        if name != "enabled":
            raise AttributeError(
                f"joint '{self.name}': '{name}' cannot be set; enabled is what can be assigned"
            )
        object.__setattr__(self, name, value)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(name for name, _ in self._formula.coordinates)]

    def __repr__(self) -> str:
        return f"<stark.Joint '{self.name}' ({self.kind})>"

    # --- details ---

    def _named(self, values: Floats) -> dict[str, float]:
        return {name: float(v) for (name, _), v in zip(self._formula.coordinates, values, strict=True)}

    def _core(self, what: str) -> Any:
        simulation = self._simulation or self._scene._latest_simulation()
        if simulation is None:
            raise needs_simulation(f"joint '{self.name}'", what)
        if self._index >= simulation._core.joint_count:
            raise added_later(f"joint '{self.name}'", what)
        return simulation._core

    def _bound_to(self, simulation: Simulation) -> Joint:
        handle = Joint(self._scene, self._index, self._formula, self._enabled_at_start, self._given)
        object.__setattr__(handle, "_simulation", simulation)
        return handle
