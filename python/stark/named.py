"""Parts of a scene in their order, which are found by number and by name: ``sim.joints[1]``,
``sim.joints["elbow"]``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Generic, NoReturn, Protocol, SupportsIndex, TypeVar

from stark._core import InvalidArgument
from stark.arguments import nearest_hint
from stark.overloads import overload


class Named(Protocol):
    """What has a name that no other part of its kind has."""

    @property
    def name(self) -> str: ...


Part = TypeVar("Part", bound=Named)
Value = TypeVar("Value")


class NamedList(list[Part], Generic[Part]):
    """A list of the parts of a simulation; ``kind`` is what messages call one of them."""

    def __init__(self, kind: str, parts: Iterable[Part]) -> None:
        super().__init__(parts)
        self._kind = kind

    @overload
    def __getitem__(self, at: SupportsIndex | str) -> Part: ...

    @overload
    def __getitem__(self, at: slice) -> list[Part]: ...

    def __getitem__(self, at: SupportsIndex | slice | str) -> Any:
        return _part_at(self, at, super().__getitem__)

    def __contains__(self, part: object) -> bool:
        return (
            any(known.name == part for known in self) if isinstance(part, str) else super().__contains__(part)
        )


class NamedTuple(tuple[Part, ...], Generic[Part]):
    """The same as a tuple, of the parts of a scene."""

    _kind: str

    def __new__(cls, kind: str, parts: Iterable[Part]) -> NamedTuple[Part]:
        made = super().__new__(cls, parts)
        made._kind = kind
        return made

    def __getnewargs__(self) -> tuple[str, tuple[Part, ...]]:
        """For copies, which are of the same parts."""
        return self._kind, tuple(self)

    @overload
    def __getitem__(self, at: SupportsIndex | str) -> Part: ...

    @overload
    def __getitem__(self, at: slice) -> tuple[Part, ...]: ...

    def __getitem__(self, at: SupportsIndex | slice | str) -> Any:
        return _part_at(self, at, super().__getitem__)

    def __contains__(self, part: object) -> bool:
        return (
            any(known.name == part for known in self) if isinstance(part, str) else super().__contains__(part)
        )


class NamedDict(dict[str, Value]):
    """Parts by name, which says what there is where a name is unknown."""

    def __init__(self, kind: str, parts: Mapping[str, Value]) -> None:
        super().__init__(parts)
        self._kind = kind

    def __missing__(self, name: object) -> NoReturn:
        if not isinstance(name, str):
            raise InvalidArgument(f"{self._kind} {name!r}: must be a name, not a number: one of {list(self)}")
        _refuse(name, list(self), self._kind)


def _part_at(parts: Any, at: SupportsIndex | slice | str, numbered: Callable[[Any], Any]) -> Any:
    """By name, or by number as a list or a tuple has it."""
    if isinstance(at, str):
        return _named(parts, at, parts._kind)
    try:
        return numbered(at)
    except IndexError:
        count = len(parts)
        there = f"in [-{count}, {count})" if count else "of one that there is: there are none"
        raise IndexError(f"{parts._kind} number {at}: must be {there}") from None


def _named(parts: Iterable[Part], name: str, kind: str) -> Part:
    for part in parts:
        if part.name == name:
            return part
    _refuse(name, [part.name for part in parts], kind)


def _refuse(name: str, known: list[str], kind: str) -> NoReturn:
    some = ", ".join(f"'{one}'" for one in known[:8]) + (", ..." if len(known) > 8 else "")
    there = f"there {'is' if len(known) == 1 else 'are'} {len(known)}: {some}" if known else "there are none"
    raise InvalidArgument(
        f"unknown {kind} '{name}'{nearest_hint(name, known)}: must be the name of one; {there}"
    )
