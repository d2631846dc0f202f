"""Names and numbers that users give."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument

#: Of one file or folder, in all file systems that matter [bytes].
_LONGEST_NAME = 255


def given_name(name: Any) -> str:
    """A name for the core: "" for None, which has one chosen. Raises InvalidArgument for anything but a text,
    and for characters that no message, file or terminal shows."""
    if name is None:
        return ""
    if not isinstance(name, str) or not name:
        raise InvalidArgument(f"name = {name!r}: must be a non-empty text, or None to have one chosen")
    if any(character < " " or "\ud800" <= character <= "\udfff" for character in name):
        raise InvalidArgument(f"name = {name!r}: must be of characters that can be shown, on one line")
    return name


def refuse_masked(value: Any, what: str) -> None:
    """InvalidArgument for arrays of ``numpy.ma`` with masked values, which would count as if they were not
    masked; also for those in a list."""
    for part in value if isinstance(value, (list, tuple)) else (value,):
        if isinstance(part, np.ma.MaskedArray) and (count := int(np.ma.getmaskarray(part).sum())):
            values = "1 value is" if count == 1 else f"{count} values are"
            raise InvalidArgument(f"{what}: {values} masked: must have all; fill them, array.filled(...)")


_OF_TIME = "; only values of loads, actuators and added energies may be functions of the time"


def real_number(value: Any, what: str) -> float:
    """A real number, NaN and infinities included; InvalidArgument calls anything else ``what``."""
    refuse_masked(value, what)
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 0 or array.dtype.kind not in "iuf":
        raise InvalidArgument(f"{what} = {value!r}: must be a number{_OF_TIME if callable(value) else ''}")
    return float(array)


def as_array(value: Any, what: str) -> NDArray[Any]:
    """An array of any type and shape; InvalidArgument for rows of different lengths."""
    refuse_masked(value, what)
    try:
        return np.asarray(value)
    except (TypeError, ValueError):
        raise InvalidArgument(f"{what} = {value!r}: must be an array, with rows of one length") from None


def real_array(value: Any, what: str) -> NDArray[np.float64]:
    """An array of float64 of any shape; InvalidArgument for what is not made of real numbers."""
    array = as_array(value, what)
    try:
        if array.dtype.kind not in "biufO" or (array.dtype.kind == "O" and None in array.ravel().tolist()):
            raise TypeError  # None would become NaN, which nobody gave
        return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(f"{what} = {value!r}: must be of real numbers") from None


def given_path(value: Any, what: str) -> Path:
    """A path of a file or folder, which need not exist. InvalidArgument for anything but a text or path, for
    an empty one (which would be the current folder), and for what cannot be the name of a file."""
    try:
        text = os.fspath(value)
    except TypeError:
        text = None
    if not isinstance(text, str) or not text:
        raise InvalidArgument(f"{what} = {value!r}: must be a path: a non-empty text or a pathlib.Path")
    try:
        name = os.fsencode(text)
        writable = b"\0" not in name and max(map(len, name.split(b"/"))) <= _LONGEST_NAME
    except UnicodeEncodeError:
        writable = False
    if not writable:
        raise InvalidArgument(
            f"{what} = {shown_value(value)}: must be of characters that names of files can have, in "
            f"names of at most {_LONGEST_NAME} bytes"
        )
    return Path(text)


def given_flag(value: Any, what: str) -> bool:
    """True or False, also as 1 or 0."""
    if isinstance(value, (bool, np.bool_)) or (isinstance(value, (int, np.integer)) and value in (0, 1)):
        return bool(value)
    raise InvalidArgument(f"{what} = {value!r}: must be True or False")


def given_word(value: Any, what: str) -> str:
    """A text; which ones there are is for the core to say."""
    if not isinstance(value, str):
        raise InvalidArgument(f"{what} = {value!r}: must be a text")
    return value


def is_iterable(value: Any) -> bool:
    """Whether there are parts to go through: not in arrays without axes, which say that they are iterable."""
    return isinstance(value, Iterable) and not (isinstance(value, np.ndarray) and value.ndim == 0)


def given_task(value: Any, what: str, example: str) -> None:
    """InvalidArgument for what is neither None nor can be called."""
    if value is not None and not callable(value):
        raise InvalidArgument(f"{what} = {shown_value(value)}: must be {example}, or left out")


def given_coordinate(value: Any, what: str) -> str:
    """A coordinate of a joint, by name: "" for None, which is its only one."""
    if value is not None and not isinstance(value, str):
        raise InvalidArgument(
            f"{what} = {value!r}: must be the name of a coordinate, such as 'angle', or None"
        )
    return value or ""


def given_choice(value: Any, known: tuple[str, ...], what: str) -> str:
    """One of some words."""
    if not isinstance(value, str) or value not in known:
        hint = nearest_hint(value, known) if isinstance(value, str) else ""
        raise InvalidArgument(f"{what} = {value!r}: must be {' or '.join(map(repr, known))}{hint}")
    return value


def shown_value(value: object, most: int = 60) -> str:
    """A value as messages show it, cut to so many characters; of large arrays what they are."""
    text = repr(value)
    if len(text) <= most:
        return text
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape} and type {value.dtype}"
    return text[: most - 3] + "..."


def nearest(name: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """The known name that is most like one that is not known; empty if none is like it, by the ratio of
    letters that ``cutoff`` asks for."""
    import difflib  # not at start-up

    return next(iter(difflib.get_close_matches(name[:80], list(known), n=1, cutoff=cutoff)), "")


def nearest_hint(name: str, known: Iterable[str]) -> str:
    """' (did you mean ...?)' for a name that is not known, or nothing: as the core says it."""
    near = nearest(name, known)
    return f" (did you mean '{near}'?)" if near else ""


def refuse_unknown_values(
    owner: str, given: Iterable[str], known: list[str], options: Iterable[str], kind: str
) -> None:
    """InvalidArgument for a name that is none of the ``known`` values of a part; ``options`` are what its
    function takes beside them, which the name may have meant."""
    takes = f"takes {', '.join(known)}" if known else "takes no values"
    for name in given:
        if name not in known:
            hint = nearest_hint(name, [*known, *options])
            raise InvalidArgument(f"{owner}: unknown value '{name}'{hint}: {kind} {takes}")


class NotCopyable(InvalidArgument, TypeError):  # noqa: N818 (says what it is)
    """What holds handles of the core was copied or pickled. Also a TypeError, as Python has it."""


def needs_simulation(owner: str, what: str) -> InvalidArgument:
    """For what only a simulation can tell of a part of a scene."""
    verb = "need" if what.endswith("s") else "needs"
    return InvalidArgument(
        f"{owner}: {what} {verb} a simulation; create one with sim = stark.Simulation(scene) and keep it"
    )


def added_later(owner: str, what: str) -> InvalidArgument:
    """For parts of a scene that the simulation was made without."""
    return InvalidArgument(
        f"{owner} was added after the simulation was created, so it has no {what} there: create a new "
        f"stark.Simulation(scene)"
    )


def refuse_copy(what: str, instead: str) -> NoReturn:
    """For ``__reduce_ex__``, which copy, deepcopy and pickle call."""
    raise NotCopyable(f"{what} cannot be copied or pickled: {instead}")


def wrong_mass(owner: str, mass: Any) -> InvalidArgument:
    """Of a body whose material has a density."""
    given = np.asarray(mass, dtype=object)
    if given.ndim > 0:
        return InvalidArgument(
            f"{owner}: mass has {given.size} numbers: must be one, the mass of the whole body [kg]; where it "
            f"differs by place, give a density for each element, material.replace(density=values): "
            f"vertices get their shares of it"
        )
    return InvalidArgument(f"{owner}: mass = {mass!r} kg: must be a number > 0 and finite")
