"""Parts of a scene in their order, which are found by number and by name: ``sim.joints[1]``,
``sim.joints["elbow"]``."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Mapping
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
    """A list of the parts of a simulation; ``kind`` is what messages call one of them.

    With ``of``, parts are those of the scene of a simulation. Each becomes that of the simulation when it is
    asked for, and all of them before anything else is done with the list: thousands of handles take longer to
    make than a single one to read."""

    _of: Any = None

    def __init__(self, kind: str, parts: Iterable[Part], of: Any = None) -> None:
        super().__init__(parts)
        self._kind, self._of = kind, of
        self._places: dict[str, int] = {} if of is None else of._scene._places.setdefault(kind, {})

    def _at(self, at: Any) -> Any:
        if isinstance(at, slice):
            self._bind()
        found: Any = super().__getitem__(at)
        if self._of is not None and found._of is not self._of:
            found = found._bound_to(self._of)
            super().__setitem__(at, found)
        return found

    def _bind(self) -> None:
        """Makes all parts those of the simulation."""
        if self._of is not None:
            bound = [part if part._of is self._of else part._bound_to(self._of) for part in self._unbound()]
            self._of = None
            self[:] = bound

    def _unbound(self) -> Iterator[Any]:
        """The parts as they are."""
        return super().__iter__()

    @overload
    def __getitem__(self, at: SupportsIndex | str) -> Part: ...

    @overload
    def __getitem__(self, at: slice) -> list[Part]: ...

    def __getitem__(self, at: SupportsIndex | slice | str) -> Any:
        return _part_at(self, at, self._at)

    def __contains__(self, part: object) -> bool:
        if isinstance(part, str):
            return any(known.name == part for known in self._unbound())
        self._bind()
        return super().__contains__(part)

    def __radd__(self, other: list[Any]) -> list[Any]:
        # A plain list on the left would take the parts as they are.
        return other + list(self)


def _after_binding(name: str) -> Callable[..., Any]:
    plain = getattr(list, name)

    @functools.wraps(plain)
    def method(self: NamedList[Any], *given: Any, **named: Any) -> Any:
        self._bind()
        return plain(self, *given, **named)

    return method


for _name in (
    *("__add__", "__eq__", "__ge__", "__gt__", "__iadd__", "__imul__", "__iter__", "__le__", "__lt__"),
    *("__mul__", "__ne__", "__repr__", "__reversed__", "__rmul__", "__setitem__", "__delitem__", "append"),
    *("clear", "copy", "count", "extend", "index", "insert", "pop", "remove", "reverse", "sort"),
):
    setattr(NamedList, _name, _after_binding(_name))


class NamedTuple(tuple[Part, ...], Generic[Part]):
    """The same as a tuple, of the parts of a scene."""

    _kind: str

    _places: dict[str, int]

    def __new__(cls, kind: str, parts: Iterable[Part], of: Any = None) -> NamedTuple[Part]:
        made = super().__new__(cls, parts)
        made._kind = kind
        made._places = {} if of is None else of._places.setdefault(kind, {})
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

    def _unbound(self) -> Iterator[Part]:
        return iter(self)

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
        return numbered(_place_of(parts, at))
    try:
        return numbered(at)
    except IndexError:
        count = len(parts)
        there = f"in [-{count}, {count})" if count else "of one that there is: there are none"
        raise IndexError(f"{parts._kind} number {at}: must be {there}") from None


def _place_of(parts: Any, name: str) -> int:
    """Number of the part of a name. The scene remembers places, which are tried first: names never change,
    but what is added as a whole and fails is taken out again."""
    known: dict[str, int] = parts._places
    place = known.get(name, len(parts))
    if place < len(parts) and parts[place].name == name:
        return place
    known.clear()
    for number, part in enumerate(parts._unbound()):
        known.setdefault(part.name, number)
    if name not in known:
        _refuse(name, [part.name for part in parts._unbound()], parts._kind)
    return known[name]


def _refuse(name: str, known: list[str], kind: str) -> NoReturn:
    some = ", ".join(f"'{one}'" for one in known[:8]) + (", ..." if len(known) > 8 else "")
    there = f"there {'is' if len(known) == 1 else 'are'} {len(known)}: {some}" if known else "there are none"
    raise InvalidArgument(
        f"unknown {kind} '{name}'{nearest_hint(name, known)}: must be the name of one; {there}"
    )
