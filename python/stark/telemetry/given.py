"""Numbers that users give to be recorded: NaN says that there is none, and is ``null`` in files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from .._core import InvalidArgument
from ..arguments import shown_value

#: What a number to be recorded must be.
RULE = "must be a finite number; NaN where there is none"


def given_number(value: Any) -> float:
    """A number as it is recorded. Raises ValueError for arrays, texts, None and infinite numbers: JSON has no
    infinity, and a number that comes back as none would be a lie."""
    if isinstance(value, (str, bytes, bytearray)) or value is np.ma.masked:
        raise ValueError(value)
    try:
        number = float(value)
    except (TypeError, OverflowError) as error:
        raise ValueError(value) from error
    if math.isinf(number):
        raise ValueError(value)
    return number


def given_numbers(extra: Mapping[str, Any], taken: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers, and groups of numbers by name, beside those that are ``taken``. Raises InvalidArgument."""
    found: dict[str, Any] = {}
    for name, value in extra.items():
        if name in taken:
            raise InvalidArgument(
                f"report: '{name}' is a series of the step itself; give yours as measured={{'{name}': ...}}"
            )
        if isinstance(value, Mapping):
            found[name] = {str(key): _number(f"{name}[{key!r}]", item) for key, item in value.items()}
        else:
            found[name] = _number(name, value)
    return found


def _number(owner: str, value: Any) -> float | None:
    try:
        number = given_number(value)
    except ValueError:
        raise InvalidArgument(f"report: {owner} = {shown_value(value, 80)}: {RULE}") from None
    return None if math.isnan(number) else number
