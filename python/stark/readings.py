"""What handles hand out of a simulation: copies that cannot be written into. ``body.velocity[2] = 5.0`` would
change a copy that nobody keeps, so it is an error that says what to write instead."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Generic, NoReturn, Protocol, SupportsIndex, TypeVar

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument

Number = TypeVar("Number", bound=np.generic)
Value = TypeVar("Value")


class Titled(Protocol):
    """What readings are of."""

    @property
    def _title(self) -> str: ...


class Reading(np.ndarray):
    """A copy of what a simulation has, read-only. What is computed from it is a plain array; so are
    ``np.array(reading)`` and ``reading.copy()``, which can be written into."""

    __array_priority__: float = -1.0  # results with plain arrays are plain

    _of: tuple[Titled, str, bool | str] | None = None  # owner, name, whether it can be assigned, or remedy

    def __setitem__(self, key: Any, value: Any) -> None:
        if not self.flags.writeable:
            raise InvalidArgument(self._refusal(key))
        super().__setitem__(key, value)

    def _refusal(self, key: Any) -> str:
        if self._of is None:  # a part of one
            return (
                "this is a part of a copy that Stark returned, and writing into it would change nothing: "
                "write into a copy() of the whole array, then assign that"
            )
        owner, name, assign = self._of
        place = key if isinstance(key, int) else "..."
        whole = f"write new = x.{name}.copy(); new[{place}] = ...; x.{name} = new"
        remedy = assign if isinstance(assign, str) else whole if assign else "it cannot be set"
        return f"{owner._title}: {name} is a copy, and writing into it would change nothing: {remedy}"

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return array[()] if return_scalar else np.asarray(array)

    # body.velocity += (0, 0, 1) computes a new array, and assigns it.

    def __iadd__(self, other: Any) -> Any:  # type: ignore[misc]
        return super().__iadd__(other) if self.flags.writeable else self + other

    def __isub__(self, other: Any) -> Any:  # type: ignore[misc]
        return super().__isub__(other) if self.flags.writeable else self - other

    def __imul__(self, other: Any) -> Any:  # type: ignore[misc]
        return super().__imul__(other) if self.flags.writeable else self * other

    def __itruediv__(self, other: Any) -> Any:  # type: ignore[misc]
        return super().__itruediv__(other) if self.flags.writeable else self / other

    def __imatmul__(self, other: Any) -> Any:  # type: ignore[misc]
        return super().__imatmul__(other) if self.flags.writeable else self @ other

    # Elsewhere it is a plain array.

    def copy(self, order: Any = "C") -> NDArray[Any]:  # type: ignore[override]
        return np.array(self, order=order)

    def __copy__(self) -> NDArray[Any]:  # type: ignore[override]
        return np.array(self)

    def __deepcopy__(self, memo: Any) -> NDArray[Any]:  # type: ignore[override]
        return np.array(self)

    def __reduce_ex__(self, protocol: SupportsIndex) -> Any:
        return self.view(np.ndarray).__reduce_ex__(protocol)

    def __repr__(self) -> str:
        return repr(self.view(np.ndarray))


class NamedReadings(dict[str, Value], Generic[Value]):
    """A dictionary of copies, read-only; ``dict(readings)`` can be written into."""

    _of: tuple[Titled, str, bool]

    def __setitem__(self, name: str, value: Value) -> NoReturn:
        owner, what, can_be_assigned = self._of
        remedy = f"x.{what} = {{{name!r}: ...}}" if can_be_assigned else f"x.{name} = ..."
        raise InvalidArgument(
            f"{owner._title}: {what} is a copy, and writing into it would change nothing: write {remedy}"
        )

    def __missing__(self, name: object) -> NoReturn:
        owner, what, _ = self._of
        raise KeyError(f"{owner._title}: {what} has no {name!r}: there is {', '.join(self) or 'nothing'}")

    def __reduce_ex__(self, protocol: SupportsIndex) -> Any:
        return dict, (dict(self),)


def reading(
    array: NDArray[Number], owner: Titled, name: str, *, assign: bool | str = False
) -> NDArray[Number]:
    """The array, which belongs to nobody else, as a reading. ``assign``: ``owner.name = ...`` takes one, or
    what to write instead."""
    result = array.view(Reading)
    result.setflags(write=False)
    result._of = owner, name, assign
    return result


def named_readings(
    values: Mapping[str, Value], owner: Titled, what: str, *, assign: bool = False
) -> dict[str, Value]:
    """Values by name as readings. ``assign``: ``owner.what = {...}`` takes some; else ``owner.name = ...``
    takes each."""
    result = NamedReadings(values)
    result._of = owner, what, assign
    return result
