"""Values of loads, energies and actuators that are functions of time: ``motor.target = lambda t: ...``.

They belong to the scene, as motions do: every simulation of it follows. Values are those of the end of each
step that is about to be taken; a step that the solver halves begins with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.handle import SceneLink, SimulationLink
from stark.motion import Motion, as_motion

TimeValue: TypeAlias = float | Callable[[float], Any]
"""A number, or a function of the time [s]."""

Key: TypeAlias = tuple[str, int, str]  # kind, index and name of the value


class Valued(Protocol):
    """A handle with values."""

    _scene: SceneLink
    _index: int

    @property
    def name(self) -> str: ...

    def _count_in(self, simulation: SimulationLink) -> int: ...

    def _follow(self, simulation: SimulationLink, name: str, value: Any) -> None:
        """Makes a number or array the value in the coming step."""


class Course:
    """A value over time."""

    def __init__(self, handle: Valued, name: str, value: Motion) -> None:
        self._handle, self._name, self._value = handle, name, value

    @property
    def name(self) -> str:
        return self._handle.name

    def apply(self, simulation: SimulationLink, time: float) -> None:
        """Sets the value for the step that ends at a time [s], if the simulation has its object."""
        if self._handle._index < self._handle._count_in(simulation):
            self._handle._follow(simulation, self._name, self._value(time))


def at_start(value: Any, owner: str) -> Any:
    """What a value is at time 0."""
    if not callable(value):
        return value
    try:
        return as_motion(value, owner)(0.0)
    except TypeError as error:
        raise InvalidArgument(
            f"{owner} = {value!r}: must be a number, or a function of the time [s]: at 0 s it raises {error}"
        ) from error


def starts(values: Mapping[str, Any], owner: str) -> dict[str, Any]:
    """The same of values by name."""
    return {name: at_start(value, f"{owner}: {name}") for name, value in values.items()}


def refuse_lost_change(owner: str, name: str, array: NDArray[Any], written: NDArray[Any]) -> None:
    """Raises InvalidArgument where an array that follows a function has been changed in place since the
    function, or an assignment, wrote it: the coming step would replace the change without a word."""
    if array.tobytes() == written.tobytes():
        return
    place = tuple(int(k) for k in np.argwhere(array != written)[0])
    where = f"[{', '.join(map(str, place))}]" if place else ""
    raise InvalidArgument(
        f"{owner}: {name}{where} = {array[place]:g} was changed in place, but follows a function of time, "
        f"whose next value would replace the change: must be left to the function, or assigned as a whole, "
        f"which ends the function: handle.{name} = array"
    )


def set_courses(kind: str, handle: Valued, values: Mapping[str, Any]) -> None:
    """From now on values that are functions of time are followed; those that are not, no more."""
    courses = handle._scene._courses
    for name, value in values.items():
        courses.pop((kind, handle._index, name), None)
        if callable(value):
            motion = as_motion(value, f"'{handle.name}': {name}")
            courses[kind, handle._index, name] = Course(handle, name, motion)
