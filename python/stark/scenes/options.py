"""Options of scene files: what a caller may choose, and how it becomes the type of the default."""

from __future__ import annotations

import numbers
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from .._core import InvalidArgument


class SceneFileError(InvalidArgument):
    """A scene file that cannot be used: names the file, the defect and the remedy."""


def converted_options(name: str, defaults: Mapping[str, Any], chosen: Mapping[str, Any]) -> dict[str, Any]:
    """What was chosen, as the types of the defaults. Raises SceneFileError; ``name`` is that of the scene."""
    converted = {}
    for key, value in chosen.items():
        if key not in defaults:
            known = ", ".join(defaults) or "none"
            raise SceneFileError(f"scene '{name}' has no option '{key}'; its options: {known}")
        owner = f"scene '{name}': option {key}"
        rule = rule_of(defaults[key])
        if rule is None:
            kind = type(defaults[key]).__name__
            raise SceneFileError(
                f"{owner} = {value!r}: its default is a {kind}: only numbers, texts, true and false, and "
                f"lists of one of these can be chosen; give the option such a default"
            )
        try:
            converted[key] = _as(defaults[key], value)
        except (TypeError, ValueError, OverflowError):
            raise SceneFileError(f"{owner} = {value!r}; must be {rule}") from None
    return converted


def option_text(value: Any) -> str:
    """A value as a text that becomes it again: what the command line would be given."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return ", ".join(map(str, value))
    return str(value)


def _kind(default: Any) -> type | None:
    """bool, int, float or str; None for everything else."""
    if isinstance(default, (bool, np.bool_)):
        return bool
    return next((kind for kind in (int, float, str) if isinstance(default, kind)), None)


def _item_kind(default: Any) -> type | None:
    """The one kind of all items of a list or tuple; whole numbers among others are numbers, too."""
    kinds = {_kind(item) for item in default}
    if kinds == {int, float}:
        return float
    return kinds.pop() if len(kinds) == 1 else None


def rule_of(default: Any) -> str | None:
    """What must be chosen instead of a default; None where nothing can be."""
    names = {bool: "true or false", int: "an int", float: "a float", str: "a str"}
    kind = _kind(default)
    if kind is not None:
        return names[kind]
    if not isinstance(default, (list, tuple)) or (item := _item_kind(default)) is None:
        return None
    each = {bool: "true and false", int: "ints", float: "floats", str: "texts"}[item]
    count = f"{len(default)} " if isinstance(default, tuple) else ""
    example = ", ".join(str(item).lower() if isinstance(item, bool) else str(item) for item in default)
    return f"{count}{each}, {example} for example"


def _as(default: Any, value: Any) -> Any:
    """A value as a default is. Raises TypeError, ValueError or OverflowError."""
    kind = _kind(default)
    if kind is not None:
        return _number(kind, value)
    items = value
    if isinstance(value, str):
        text = value.strip()
        text = text[1:-1] if text[:1] + text[-1:] in ("[]", "()") else text
        items = (
            [_unquoted(item.strip()) for item in text.removesuffix(",").split(",")] if text.strip() else []
        )
    elif isinstance(value, np.ndarray):
        items = value.tolist()
    elif not isinstance(value, (list, tuple)):
        raise TypeError
    item_kind = _item_kind(default)
    assert item_kind is not None
    found = [_number(item_kind, item) for item in items]
    if isinstance(default, tuple) and len(found) != len(default):
        raise ValueError
    if item_kind is str and any("," in item for item in found):
        raise ValueError  # would not come back from a text
    return tuple(found) if isinstance(default, tuple) else found


def _unquoted(text: str) -> str:
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] and text[0] in "'\"" else text


def _number(kind: type, value: Any) -> Any:
    """A number, a text, true or false. Texts, those of the command line, are read; no other value becomes
    one of another type, but for whole numbers."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if kind is str:
        if isinstance(value, (str, os.PathLike)):
            return os.fspath(value)
    elif kind is bool:
        if isinstance(value, (bool, np.bool_)):
            return bool(value)
        if isinstance(value, str) and value.lower() in ("true", "false"):
            return value.lower() == "true"
    elif isinstance(value, str):
        return kind(value)
    elif isinstance(value, numbers.Real) and not isinstance(value, bool):
        number = kind(value)
        if kind is float or number == value:
            return number
    raise TypeError
