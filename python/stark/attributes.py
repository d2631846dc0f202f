"""Objects whose attributes are all known: a misspelt assignment is an error instead of an attribute that
nothing reads, and errors say what was probably meant."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from types import FunctionType
from typing import TYPE_CHECKING, Any, ClassVar

from stark.arguments import nearest


def attribute_error(message: str, name: str) -> AttributeError:
    """An error that has its own hint: without an object, Python adds none to the traceback."""
    return AttributeError(message, name=name, obj=None)


def own_names(module: str, names: Mapping[str, Any]) -> list[str]:
    """What a module defines itself, without what it imports: for the completion of names."""
    return [
        name
        for name, value in names.items()
        if not name.startswith("_")
        and (isinstance(value, dict) or getattr(value, "__module__", "") == module)
    ]


class KnownAttributes:
    """Refuses to assign public attributes that its class does not declare, by a property or an annotation."""

    #: What to write instead of names that users of other simulators try.
    _elsewhere: ClassVar[Mapping[str, str]] = {}
    #: What to write instead of assigning to attributes that can only be read.
    _given_by: ClassVar[Mapping[str, str]] = {}

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_"):
            object.__setattr__(self, name, value)
            return
        if not _declares(type(self), name):
            raise attribute_error(self._unknown_attribute(name), name)
        if isinstance(known := getattr(type(self), name, None), property) and known.fset is None:
            raise AttributeError(self._read_only_attribute(name))
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        if isinstance(getattr(type(self), name, None), property):
            raise AttributeError(
                f"{self!r}: {name} cannot be deleted: assign another value, where it has one"
            )
        object.__delattr__(self, name)

    def _read_only_attribute(self, name: str) -> str:
        """What is said of an assignment to an attribute that can only be read."""
        remedy = f": write {self._given_by[name]}" if name in self._given_by else ""
        return f"{self!r}: {name} can be read, not assigned{remedy}"

    def _unknown_attribute(self, name: str) -> str:
        """What is said of an attribute that there is not."""
        return _unknown(self, name, self._elsewhere)


def _unknown(owner: object, name: str, elsewhere: Mapping[str, str]) -> str:
    if name in elsewhere:
        return f"{owner!r} has no attribute '{name}': write {elsewhere[name]}"
    cls: Any = type(owner)
    near = _nearest_attribute(cls, name)
    hint = f"; did you mean '{near}'?" if near else ""
    return f"{owner!r} has no attribute '{name}'{hint}"


@functools.lru_cache(maxsize=256)  # getattr(body, "color", None) of every body of every frame throws it away
def _nearest_attribute(cls: type, name: str) -> str:
    return nearest(name, [other for other in dir(cls) if not other.startswith("_")])


def answer_attributes(cls: type, elsewhere: Mapping[str, str]) -> None:
    """Lets a class of the core say what was meant where an unknown attribute is read."""

    def answer(self: object, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"{cls.__name__!r} object has no attribute {name!r}")
        raise attribute_error(_unknown(self, name, elsewhere), name)

    cls.__getattr__ = answer  # type: ignore[attr-defined]


def _declares(cls: type, name: str) -> bool:
    return hasattr(cls, name) or any(name in vars(base).get("__annotations__", {}) for base in cls.__mro__)


class AnsweredAttributes(KnownAttributes):
    """Also says what was meant where an unknown attribute is read. For objects that are read rarely: it
    makes every attribute 50 ns slower."""

    if not TYPE_CHECKING:  # checkers would take every name for known

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_") or _declares(type(self), name):  # a property that raised: its own error
                return object.__getattribute__(self, name)
            raise attribute_error(self._unknown_attribute(name), name)


def name_methods(cls: type) -> None:
    """Lets methods from the parts of a class, the bases that no other class has, bear its name: Python's
    errors on arguments then say Scene.add_box(), as users call it."""
    for part in cls.__mro__[1:-1]:
        if len(part.__subclasses__()) == 1:
            for name, member in vars(part).items():
                if isinstance(member, FunctionType):
                    member.__qualname__ = f"{cls.__qualname__}.{name}"
