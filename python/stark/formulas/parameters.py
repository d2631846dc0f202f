"""Parameters of formulas: declaration with default, unit and range; values given for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument, TraceError
from stark.arguments import refuse_masked, shown_value

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Declaration:
    """What ``stark.parameter`` makes; its fields are the arguments."""

    default: Any
    unit: str
    min: float | None
    max: float | None
    above: float | None
    below: float | None
    doc: str

    @property
    def rule(self) -> str:
        """The range in words, "" without one."""
        bounds = (("> ", self.above), (">= ", self.min), ("< ", self.below), ("<= ", self.max))
        return " and ".join(f"{sign}{bound:g}" for sign, bound in bounds if bound is not None)

    @property
    def range(self) -> tuple[float, float, bool, bool]:
        """(low, high, low_open, high_open), as the core reads it."""
        lows = [
            (bound, is_open)
            for bound, is_open in ((self.min, False), (self.above, True))
            if bound is not None
        ]
        highs = [
            (bound, is_open)
            for bound, is_open in ((self.max, False), (self.below, True))
            if bound is not None
        ]
        low, low_open = max(lows, default=(-np.inf, True))
        high, high_open = min(highs, default=(np.inf, True), key=lambda pair: (pair[0], not pair[1]))
        return float(low), float(high), low_open, high_open

    def refused(self, values: Array) -> NDArray[np.bool_]:
        """Mask of the numbers that are out of range."""
        wrong = np.zeros(values.shape, dtype=bool)
        if self.above is not None:
            wrong |= ~(values > self.above)
        if self.min is not None:
            wrong |= ~(values >= self.min)
        if self.below is not None:
            wrong |= ~(values < self.below)
        if self.max is not None:
            wrong |= ~(values <= self.max)
        return wrong


def parameter(
    default: Any = None,
    *,
    unit: str = "1",
    min: float | None = None,
    max: float | None = None,
    above: float | None = None,
    below: float | None = None,
    doc: str = "",
) -> Any:
    """Declares a parameter of an energy or a material, as the default of an argument::

        def spring(e: stark.Edge, stiffness: float = stark.parameter(10.0, unit="N/m", min=0.0)): ...

    default: a number or array, None if a value has to be given. unit: for messages. min, max: closed bounds
    of every number of a value; above, below: open ones."""
    if not isinstance(unit, str):
        raise TraceError(f"stark.parameter: unit = {unit!r}: must be a text such as 'N/m'")
    for name, bound in (("min", min), ("max", max), ("above", above), ("below", below)):
        if bound is not None and (isinstance(bound, bool) or not isinstance(bound, (int, float, np.number))):
            raise TraceError(f"stark.parameter: {name} = {bound!r}: must be a number or None")
    return Declaration(default, unit, min, max, above, below, doc)


UNBOUNDED = (-np.inf, np.inf, True, True)


@dataclass(frozen=True)
class Parameter:
    """A parameter of a formula: its name, its shape () (k,) or (r, c), how it was declared, and whether it is
    annotated ``int``: then it takes whole numbers only."""

    name: str
    shape: tuple[int, ...]
    declaration: Declaration
    is_whole: bool = False

    @property
    def width(self) -> int:
        return int(np.prod(self.shape, dtype=int))

    @property
    def unit(self) -> str:
        return self.declaration.unit

    def describe(self, value: Any = None) -> str:
        """'stiffness' [N/m], for messages; what has no unit is its name alone."""
        return f"'{self.name}'" if self.unit == "1" else f"'{self.name}' [{self.unit}]"


class Value:
    """Value of a parameter: one of the parameter's shape for all elements, or one more leading dimension with
    a row for each element."""

    __slots__ = ("array", "exposed", "per_element", "version", "written")

    def __init__(self, array: Array, per_element: bool) -> None:
        self.array: Array = array
        self.per_element: bool = per_element
        self.version: int = 0  # counts assignments
        self.exposed: bool = False  # whether someone may change the array in place
        self.written: Array | None = None  # of an exposed array: what was last written to it

    def expose(self) -> Array:
        """The array, which may be changed in place from now on."""
        if not self.exposed:
            self.exposed, self.written = True, self.array.copy()
        return self.array

    def write(self, array: Array) -> None:
        """In place: arrays that were handed out stay live."""
        self.array[...] = array
        self.version += 1
        if self.exposed:
            self.written = self.array.copy()

    @property
    def numbers(self) -> Array:
        """All numbers in a row."""
        return np.ascontiguousarray(self.array).reshape(-1)


def numbers_of(owner: str, parameter: Parameter, given: Any) -> Array:
    """A new array of the real numbers given, or InvalidArgument that names the parameter."""
    refuse_masked(given, f"{owner}: {parameter.describe()}")
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "biuf":
            raise TypeError
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(
            f"{owner}: {parameter.describe()} = {shown_value(given)}: must be {_needed(parameter)}"
            + ("; it is constant in time" if callable(given) else "")
        ) from None
    return np.array(array, dtype=np.float64)


def read_value(owner: str, parameter: Parameter, given: Any, element_count: int) -> Value:
    """The value, checked; InvalidArgument otherwise."""
    array = numbers_of(owner, parameter, given)
    per_element = array.shape == (element_count, *parameter.shape)
    if not per_element and array.shape != parameter.shape:
        rows = ", ".join(map(str, (element_count, *parameter.shape)))
        raise InvalidArgument(
            f"{owner}: {parameter.describe()} has the shape {array.shape}: must be {_needed(parameter)}, or "
            f"an array of shape ({rows}{',' if not parameter.shape else ''}) with a value for each element"
        )
    check_range(owner, parameter, array, per_element)
    return Value(array, per_element)


def check_range(owner: str, parameter: Parameter, array: Array, per_element: bool) -> None:
    """Raises InvalidArgument that names the first number that is not finite, out of range or not whole."""
    wrong = ~np.isfinite(array)
    rule = "finite; check where it is computed"
    if not wrong.any():
        wrong, rule = parameter.declaration.refused(array), parameter.declaration.rule
    if parameter.is_whole and not wrong.any():
        wrong, rule = array != np.rint(array), "a whole number, as its annotation says int"
    if wrong.any():
        place = np.argwhere(wrong)[0]
        where = f"[{', '.join(map(str, place))}]" if place.size else ""
        element = f" of element {place[0]}" if per_element else ""
        unit = "" if parameter.unit == "1" else f" {parameter.unit}"
        raise InvalidArgument(
            f"{owner}: {parameter.name}{where}{element} = {array[tuple(place)]:g}{unit}: must be {rule}"
        )


def _needed(parameter: Parameter) -> str:
    if not parameter.shape:
        return "a number"
    return f"{parameter.width} numbers of shape {parameter.shape}"
