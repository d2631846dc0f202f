"""Numbers that a formula takes from around its function, closures and modules: recording makes them fixed."""

from __future__ import annotations

import dis
import functools
import types
from collections.abc import Callable, Hashable, Iterator, Mapping
from typing import Any

import numpy as np

from stark.caller import warn

_DEPTH = 4  # of lists and dictionaries within others
_ROOTS = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_DEREF")
_ATTRIBUTES = ("LOAD_ATTR", "LOAD_METHOD")


def captured(function: Callable[..., object]) -> dict[str, Hashable]:
    """Equal as long as recording the function again would give the same: the numbers that it names, and those
    of functions that it names."""
    return _of_function(function, [])


def changed(before: Mapping[str, Hashable], now: Mapping[str, Hashable]) -> list[str]:
    """Names of what is not the same: of a variable rather than of its attributes, where both differ."""
    names = sorted(name for name in {*before, *now} if before.get(name) != now.get(name))
    return [name for name in names if not any(name.startswith(f"{other}.") for other in names)]


def warn_of_changes(
    name: str, kind: str, function: Callable[..., object], before: Mapping[str, Hashable], location: str
) -> None:
    """Of numbers around a function that are not what they were when it was recorded as a ``kind``."""
    if not (names := changed(before, captured(function))):
        return
    which = ", ".join(f"'{variable}'" for variable in names)
    those = "it a parameter" if len(names) == 1 else "them parameters"
    warn(
        f"{name}: {which} changed after the {kind} was recorded, which keeps what it found then: make "
        f"{those} of the {kind}, or define the {kind} again\n{location}"
    )


def _of_function(function: Any, seen: list[object]) -> dict[str, Hashable]:
    function = getattr(function, "function", function)  # of an energy within another
    code = getattr(function, "__code__", None)
    if code is None or any(function is other for other in seen):
        return {}
    if seen and function.__module__.partition(".")[0] in ("stark", "numpy"):  # their numbers do not change
        return {}
    seen.append(function)
    paths = _paths(code)
    values = {path[0]: function.__globals__.get(path[0]) for path in paths if path[0] in function.__globals__}
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        try:
            values[name] = cell.cell_contents
        except ValueError:  # not assigned yet
            continue
    values |= {".".join(path): _reached(values[path[0]], path[1:]) for path in paths if path[0] in values}
    return {name: _of_value(values[name], seen, _DEPTH) for name in sorted(values)}


@functools.lru_cache(maxsize=1024)
def _paths(code: types.CodeType) -> frozenset[tuple[str, ...]]:
    """Names from around a function, each with the attributes that it takes of them: ("Sheet", "modulus")."""
    found: set[tuple[str, ...]] = set()
    path: tuple[str, ...] = ()
    for inner in _codes(code):
        for step in dis.get_instructions(inner):
            if step.opname in _ROOTS:
                path = (step.argval,)
            elif path and step.opname in _ATTRIBUTES:
                path = (*path, step.argval)
            elif step.opname != "EXTENDED_ARG":
                path = ()
            if path:
                found.add(path)
    return frozenset(found)


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """That of a function and of those within it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _reached(value: Any, attributes: tuple[str, ...]) -> Any:
    """An attribute of an attribute of a value; None where there is none."""
    for name in attributes:
        try:
            value = getattr(value, name)
        except Exception:  # a property of the user may raise anything; recording says so
            return None
    return value


def _of_value(value: Any, seen: list[object], depth: int) -> Hashable:
    if value is None or isinstance(value, (bool, int, float, complex, str, np.generic)):
        return type(value).__name__, repr(value)
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, hash(value.tobytes())
    if depth == 0 or isinstance(value, (types.ModuleType, type)):
        return None
    if any(isinstance(f, types.FunctionType) for f in (value, getattr(value, "function", None))):
        return tuple(_of_function(value, seen).items())
    if isinstance(value, (list, tuple)):
        return tuple(_of_value(entry, seen, depth - 1) for entry in value)
    if isinstance(value, dict):
        return tuple((repr(name), _of_value(entry, seen, depth - 1)) for name, entry in value.items())
    if isinstance(value, functools.partial):
        return tuple(_of_value(part, seen, depth - 1) for part in (value.func, value.args, value.keywords))
    # Of other objects their own numbers, arrays and lists of them.
    inner = min(depth, 2) - 1
    return tuple(
        (name, _of_value(entry, seen, inner)) for name, entry in getattr(value, "__dict__", {}).items()
    )
