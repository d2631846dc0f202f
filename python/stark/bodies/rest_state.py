"""Rest states that change: growth, temperature, active stress, natural curvature of bodies.

A field has a value for each element. It is given to a body of the scene before the simulation is made, and
may change between steps, also in place; functions of the time [s] are followed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import real_array
from stark.caller import warn
from stark.courses import at_start, refuse_lost_change, set_courses
from stark.handle import BodyHandle, SimulationLink
from stark.scene_record import Call

Floats = NDArray[np.float64]


class Value:
    """Numbers of a field, an entry for each element."""

    __slots__ = ("array", "given", "written")

    def __init__(self, array: Floats) -> None:
        self.array: Floats = array.copy()  #: may be changed in place
        self.written: Floats = array.copy()  #: what was last written to it
        self.given: Floats = array.copy()  #: what the scene of the core has, with which simulations start

    def write(self, array: Floats) -> None:
        """In place: arrays that were handed out stay live."""
        self.array[...] = array
        self.written[...] = array


def _tensors(array: Floats) -> Floats:
    """Plain numbers as multiples of the identity."""
    return array if array.ndim > 1 else np.where(np.eye(3, dtype=bool), array[:, None, None], 0.0)


class RestState(BodyHandle):
    """What bodies with a rest state have in common."""

    _shared: dict[str, Any]

    def _require_of_scene(self, what: str) -> None:
        raise NotImplementedError  # of Body

    def _element_count(self) -> int:
        raise NotImplementedError

    @property
    def growth(self) -> Floats:
        """Stretch of the rest shape, a value for each element; 1 where it was never given.

        Solids: numbers (n,), the same in all directions, or tensors (n, 3, 3) in the axes of the mesh. Cloth:
        numbers (n,), in both directions of the sheet. Rods: numbers (n,), of the length. Assign a number, a
        tensor, an array, or a function of the time [s], before the simulation is made; then it may change at
        any time, also in place. What has grown has the same mass."""
        return self._rest_value("growth")

    @growth.setter
    def growth(self, value: Any) -> None:
        self._set_rest_value("growth", value)

    @property
    def temperature(self) -> Floats:
        """Temperature of each element above that of the rest shape (n,) [K]. The rest shape is stretched by
        1 + ``thermal_expansion`` of the material times temperature. Assign it as ``growth``."""
        return self._rest_value("temperature")

    @temperature.setter
    def temperature(self, value: Any) -> None:
        self._set_rest_value("temperature", value)

    # --- details ---

    def _rest_shapes(self, name: str) -> tuple[tuple[int, ...], ...]:
        """Shapes that a value of one element may have."""
        return ((),)

    @property
    def _rest_values(self) -> dict[str, Value]:
        """By name, in the order in which they were given."""
        values: dict[str, Value] = self._shared.setdefault("rest_state", {})
        return values

    def _rest_value(self, name: str) -> Floats:
        """Of fields that were never given what they stand for, as an array that cannot be written to."""
        value = self._rest_values.get(name)
        if value is not None:
            return value.array
        array = np.full((self._element_count(), *self._rest_shapes(name)[0]), float(name == "growth"))
        array.setflags(write=False)
        return array

    def _set_rest_value(self, name: str, given: Any) -> None:
        self._write_rest_value(name, at_start(given, f"'{self.name}': {name}") if callable(given) else given)
        set_courses("body", self, {name: given})

    def _follow(self, simulation: SimulationLink, name: str, value: Any) -> None:
        known = self._rest_values[name]
        refuse_lost_change(f"'{self.name}'", name, known.array, known.written)
        self._write_rest_value(name, value)

    def _write_rest_value(self, name: str, given: ArrayLike) -> None:
        array, known = self._expanded(name, given), self._rest_values.get(name)
        if known is not None and known.array.ndim == 3:
            array = _tensors(array)
        core, numbers = self._scene._core, {name: (self._rest_numbers(name, array), True)}
        if known is None or known.array.shape != array.shape:
            self._require_of_scene(name)
            expansion = getattr(self._shared["material"], "thermal_expansion", 1.0)
            if known is None and name == "temperature" and not np.any(expansion):
                warn(
                    f"'{self.name}': temperature: changes nothing, as thermal_expansion of the material is "
                    f"0: must be given, material.replace(thermal_expansion=...) [1/K]"
                )
            if known is not None and self._simulation() is not None:
                raise InvalidArgument(
                    f"'{self.name}': {name} has the shape {known.array.shape}: must keep it while there is a "
                    f"simulation, got {array.shape}; give tensors before the simulation is made"
                )
            core.set_rest_state(self._index, numbers)
            self._rest_values[name] = Value(array)
            self._scene._warn_of_simulation(self, name, f"assign {name} once")
            return
        core.check_rest_state(self._index, numbers)
        known.write(array)

    def _rest_numbers(self, name: str, array: Floats) -> Floats:
        """As the core takes them."""
        tensors = _tensors(array) if (3, 3) in self._rest_shapes(name) else array
        return np.ascontiguousarray(tensors.reshape(-1))

    def _expanded(self, name: str, given: ArrayLike) -> Floats:
        """With an entry for each element."""
        array, count = real_array(given, f"'{self.name}': {name}"), self._element_count()
        if not np.isfinite(array).all():
            raise InvalidArgument(f"'{self.name}': {name} = {given!r}: must be of finite numbers")
        for shape in self._rest_shapes(name):
            if array.shape == (count, *shape):
                return array
            if array.shape == shape:
                return np.broadcast_to(array, (count, *shape)).copy()
        known = " or ".join(str((count, *shape)) for shape in self._rest_shapes(name))
        raise InvalidArgument(
            f"'{self.name}': {name} has the shape {array.shape}: must be {known}, a value for each element, "
            f"or one for all"
        )


class ActiveFibres(RestState):
    """The part of a rest state that solids and cloth have: fibres that pull."""

    @property
    def fiber_direction(self) -> Floats:
        """Directions of the fibres of ``active_stress`` at rest, in the axes of the mesh (n, 3), of any
        length; zero where they were never given. Of cloth, what of them lies in the triangle. Assign one for
        all or one for each element."""
        return self._rest_value("fiber_direction")

    @fiber_direction.setter
    def fiber_direction(self, value: Any) -> None:
        self._set_rest_value("fiber_direction", value)

    @property
    def active_stress(self) -> Floats:
        """Stress of a muscle along ``fiber_direction`` (n,) [Pa], positive where it pulls: force over the
        area at rest, of cloth its thickness times its width, whatever the length of the fibres. Assign it as
        ``growth``, once there is a ``fiber_direction``."""
        return self._rest_value("active_stress")

    @active_stress.setter
    def active_stress(self, value: Any) -> None:
        self._set_rest_value("active_stress", value)

    def _rest_shapes(self, name: str) -> tuple[tuple[int, ...], ...]:
        return ((3,),) if name == "fiber_direction" else super()._rest_shapes(name)


class LiveRestState:
    """What one simulation knows of the rest state of a body; as LiveValues of an energy."""

    def __init__(self, body: RestState) -> None:
        self.body = body
        self._known = {name: value.given.copy() for name, value in body._rest_values.items()}

    @property
    def name(self) -> str:
        return f"rest state of {self.body.name}"

    def push(self, core: Any) -> None:
        """Hands what changed since the last call to the simulation."""
        for name, known in self._known.items():
            array = self.body._rest_values[name].array
            if not np.array_equal(array, known):
                core.set_rest_state(self.body._index, name, self.body._rest_numbers(name, array))
                known[...] = array

    def present(self) -> dict[str, Floats]:
        """Copies of the values that the next step takes."""
        return {name: self.body._rest_values[name].array.copy() for name in self._known}

    def pushed(self) -> dict[str, Floats]:
        """The values that the last step took."""
        return {name: known.copy() for name, known in self._known.items()}

    def calls(self) -> list[Call]:
        """On the scene of the core, which give its body those values."""
        fields = {name: (self.body._rest_numbers(name, known), True) for name, known in self._known.items()}
        return [("set_rest_state", (self.body._index, fields))]

    def check(self, owner: str, given: Mapping[str, Floats]) -> None:
        """Raises InvalidArgument for values out of range."""
        for name, array in given.items():
            numbers = self.body._rest_numbers(name, array)
            self.body._scene._core.check_rest_state(self.body._index, {name: (numbers, True)})

    def assign(self, given: Mapping[str, Floats]) -> None:
        """Makes these the values of the body, for every simulation of its scene."""
        for name, array in given.items():
            self.body._rest_values[name].write(array)
