"""Surfaces of rigid bodies that move along themselves: conveyor belts, turntables, tracks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.courses import at_start, set_courses
from stark.handle import BodyHandle, SimulationLink
from stark.readings import reading
from stark.rotations import vector

_NAMES = ("surface_velocity", "surface_spin", "surface_center")
Vector = NDArray[np.float64]


class MovingSurface(BodyHandle):
    """What bodies with such a surface have in common."""

    @property
    def surface_velocity(self) -> Vector | None:
        """Velocity of the material of the surface against the body (3,) [m/s], in the frame of its mesh; None
        where the surface rests. What touches it slips against this material, so friction carries it along:
        a conveyor belt is a fixed box whose surface moves.

        Its part in the plane of each contact counts. Assign it, or a function of the time [s], before the
        simulation is made; then it may change at any time and is a part of ``sim.state``. Each step takes
        the value at its end. The body itself stays where it is and feels the reaction: a dynamic one drives
        off. ``report.energy["belts"]`` is the work of the drive [J]. Raises InvalidArgument for other than
        three finite numbers."""
        return self._motion_part(0)

    @surface_velocity.setter
    def surface_velocity(self, value: Any) -> None:
        self._set_motion_part(0, value)

    @property
    def surface_spin(self) -> Vector | None:
        """Angular velocity of the material of the surface (3,) [rad/s], in the frame of the mesh, about an
        axis through ``surface_center``: a turntable, a roller, a wheel that does not turn itself. It adds to
        ``surface_velocity`` and is assigned in the same way."""
        return self._motion_part(1)

    @surface_spin.setter
    def surface_spin(self, value: Any) -> None:
        self._set_motion_part(1, value)

    @property
    def surface_center(self) -> Vector | None:
        """A point of the axis of ``surface_spin`` (3,) [m], in the frame of the mesh; by default its origin.
        Simulations keep the value that it has when they are made."""
        return self._motion_part(2)

    @surface_center.setter
    def surface_center(self, value: ArrayLike) -> None:
        self._require_of_scene("surface_center")
        self._give(2, vector(value, f"'{self.name}': surface_center"))
        self._scene._warn_of_simulation(self, "surface_center", "assign it")

    # --- details ---

    def _require_of_scene(self, what: str) -> None:
        raise NotImplementedError  # of Body

    def _motion_part(self, part: int) -> Vector | None:
        simulation, given = self._simulation(), self._scene._core.surface_motion(self._index)
        if simulation is not None and self._moves_in(simulation):
            given = simulation._core.surface_motion(self._index)
        return None if given is None else reading(np.array(given[part]), self, _NAMES[part], assign=True)

    def _moves_in(self, simulation: SimulationLink) -> bool:
        return simulation._core.surface_motion(self._index) is not None

    def _set_motion_part(self, part: int, value: Any) -> None:
        name, simulation = _NAMES[part], self._simulation()
        numbers = vector(at_start(value, f"'{self.name}': {name}"), f"'{self.name}': {name}")
        if simulation is None:
            self._give(part, numbers)
        elif not self._moves_in(simulation):
            raise InvalidArgument(
                f"'{self.name}': {name} was not given before the simulation was created: give it before, as "
                f"(0, 0, 0) if the surface is to move later"
            )
        elif not callable(value):
            self._follow(simulation, name, numbers)
        set_courses("body", self, {name: value})

    def _give(self, part: int, numbers: Vector) -> None:
        """To the scene, for simulations to begin with."""
        known = self._scene._core.surface_motion(self._index)
        motion = [np.zeros(3)] * 3 if known is None else list(known)
        motion[part] = numbers
        self._scene._core.set_surface_motion(self._index, *motion)

    def _follow(self, simulation: SimulationLink, name: str, value: Any) -> None:
        known = simulation._core.surface_motion(self._index)
        assert known is not None  # asked when the function was given
        motion = list(known[:2])
        motion[_NAMES.index(name)] = vector(value, f"'{self.name}': {name}")
        simulation._core.set_surface_motion(self._index, *motion)
