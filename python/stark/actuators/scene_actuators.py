"""The actuator methods of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stark.courses import TimeValue
from stark.handle import SceneLink
from stark.named import NamedTuple

if TYPE_CHECKING:
    from stark.actuators.definition import ActuatorFormula
    from stark.joints.handle import Actuator


class SceneActuators(SceneLink):
    """What ``stark.Scene`` knows about actuators."""

    _listed_actuators: tuple[list[Actuator], dict[int, list[Actuator]]]  # those that are in it, by joint

    def add_actuator(
        self,
        kind: str | ActuatorFormula,
        on: Any,
        *,
        name: str | None = None,
        enabled: bool = True,
        **values: TimeValue,
    ) -> Actuator:
        """Adds an actuator of any kind: the name of a built-in one or a function with ``@stark.actuator``.

        ``on`` is a joint with one coordinate, ``(joint, "angle")``, or a list of two of them for a gear.
        ``values`` are those that the kind has, numbers or functions of the time [s]. Joints have short forms:
        ``hinge.add_motor(...)``."""
        from stark.actuators.adding import add_actuator

        actuator = add_actuator(
            self,
            kind,
            on,
            name=name,
            enabled=enabled,
            values=values,
        )
        self._actuators.append(actuator)
        self._warn_of_late(f"actuator '{actuator.name}'")
        return actuator

    def _actuators_on(self, joint: int) -> list[Actuator]:
        """Those on coordinates of a joint, by its index, in the order of adding."""
        listed, by_joint = self._listed_actuators
        known = self._actuators
        if len(listed) > len(known) or (listed and listed[-1] is not known[len(listed) - 1]):
            listed, by_joint = [], {}  # some were taken back
        for actuator in known[len(listed) :]:
            listed.append(actuator)
            for index in {on._index for on, _ in actuator.coordinates}:
                by_joint.setdefault(index, []).append(actuator)
        self._listed_actuators = listed, by_joint
        return by_joint.get(joint, [])

    @property
    def actuators(self) -> NamedTuple[Actuator]:
        """Actuators in the order of adding."""
        return NamedTuple("actuator", self._actuators, self)
