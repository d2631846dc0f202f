"""What controllers remember, as JSON beside arrays: numbers, texts, None, lists, tuples, dictionaries by text
and NumPy arrays come back as they were, in every bit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import CheckpointError

Arrays = dict[str, NDArray[Any]]

_DEEPEST = 50
_LONGEST = 14_000  # bits: Python writes and reads integers of up to 4,300 digits as text


def check(memory: Any) -> None:
    """Before it is copied: what cannot be encoded may not be copied either."""
    if not isinstance(memory, (dict, type(None))):
        kind = type(memory).__name__
        raise CheckpointError(f"memory is a {kind}: must be a dictionary of what a controller remembers")
    encode(memory, {})


def encode(value: Any, arrays: Arrays, *, place: str = "memory", depth: int = 0) -> Any:
    """A JSON value; arrays are appended to ``arrays`` and named in it."""
    if depth > _DEEPEST:
        raise CheckpointError(f"{place}: is nested deeper than {_DEEPEST} levels, or holds itself")
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf" and value.dtype.itemsize <= 8:
        name = f"memory/{len(arrays)}"
        arrays[name] = np.ascontiguousarray(value, dtype=value.dtype.newbyteorder("<")).reshape(value.shape)
        return {"$array": name}
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, int) and value.bit_length() > _LONGEST:
        raise CheckpointError(
            f"{place}: is an integer of {value.bit_length()} bits: must be at most {_LONGEST}"
        )
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (list, tuple)):
        items = [encode(v, arrays, place=f"{place}[{k}]", depth=depth + 1) for k, v in enumerate(value)]
        return {"$tuple": items} if isinstance(value, tuple) else items
    if isinstance(value, dict):
        for key in value:
            if not isinstance(key, str) or key.startswith("$"):
                raise CheckpointError(f"{place}: key {key!r}: must be a text that does not start with '$'")
        return {k: encode(v, arrays, place=f"{place}['{k}']", depth=depth + 1) for k, v in value.items()}
    raise CheckpointError(
        f"{place} is a {type(value).__name__}: must be a number, text, None, array, or a list, tuple or "
        f"dictionary of them; store what it is made from"
    )


def decode(value: Any, arrays: Arrays) -> Any:
    """What was encoded. Raises KeyError, TypeError or ValueError for what encode() never writes."""
    if isinstance(value, list):
        return [decode(v, arrays) for v in value]
    if not isinstance(value, dict):
        return value
    if "$array" in value:
        return arrays[value["$array"]].copy()
    if "$tuple" in value:
        return tuple(decode(v, arrays) for v in value["$tuple"])
    return {key: decode(v, arrays) for key, v in value.items()}
