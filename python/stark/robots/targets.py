"""Values for joints of a robot: one number for all, one for each, some by joint, functions of the time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import nearest_hint, real_array, real_number
from stark.courses import TimeValue, at_start
from stark.motion import through_same_knots

Floats = NDArray[np.float64]

JointValues: TypeAlias = ArrayLike | Mapping[str, TimeValue] | Callable[[float], Any]
"""A number for all joints or (k,) numbers; numbers or functions of the time [s] by joint; a function of the
time that gives a number or (k,) of them."""


def by_joint(values: JointValues, names: Sequence[str], what: str) -> dict[int, TimeValue]:
    """What is given to which of the joints ``names``; InvalidArgument calls anything else ``what``. Functions
    are tried at time 0."""
    if isinstance(values, Mapping):
        return {
            _place(name, names, what): _valid(value, f"{what}['{name}']") for name, value in values.items()
        }
    if callable(values):
        course = _Course(values, what, names)
        at_start(course, what)
        return {k: course.of(k) for k in range(len(names))}
    return dict(enumerate(spread(values, len(names), what, names).tolist()))


def spread(values: Any, count: int, what: str, names: Sequence[str]) -> Floats:
    """One number for all, or one for each."""
    numbers = real_array(values, what)
    if numbers.shape not in ((), (count,)):
        raise InvalidArgument(
            f"{what} has the shape {numbers.shape}: must be a number or ({count},), for {', '.join(names)}"
        )
    if not np.isfinite(numbers).all():
        raise InvalidArgument(f"{what} = {numbers.tolist()}: must be finite; check where it is computed")
    return numbers if numbers.ndim else np.full(count, float(numbers))


class _Course:
    """A function of the time that gives the values of all joints; called once a time."""

    def __init__(self, function: Callable[[float], Any], what: str, names: Sequence[str]) -> None:
        self._function, self._what, self._names = function, what, names
        self._last: tuple[float, Floats] | None = None

    def __call__(self, time: float) -> Floats:
        if self._last is None or self._last[0] != time:
            values = self._function(time)
            self._last = time, spread(values, len(self._names), f"{self._what} at {time:g} s", self._names)
        return self._last[1]

    def of(self, k: int) -> Callable[[float], Any]:
        """That of one joint; of a motion through knots one through the same."""
        column = through_same_knots(self._function, lambda v: v[:, k] if v.ndim > 1 else v)
        return column or (lambda time: float(self(time)[k]))


def _place(name: str, names: Sequence[str], what: str) -> int:
    if name not in names:
        hint = nearest_hint(str(name), names)
        raise InvalidArgument(f"{what}['{name}']{hint}: must be one of its joints: {', '.join(names)}")
    return names.index(name)


def _valid(value: Any, what: str) -> TimeValue:
    number = real_number(at_start(value, what), what)
    if not np.isfinite(number):
        raise InvalidArgument(f"{what} = {number}: must be finite; check where it is computed")
    return value if callable(value) else number
