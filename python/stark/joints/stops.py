"""What ``add_limit`` takes."""

from __future__ import annotations

import math
from typing import Any

from stark._core import InvalidArgument
from stark.arguments import real_number
from stark.caller import warn
from stark.courses import TimeValue, at_start


def checked_stops(
    title: str, lower: TimeValue | None, upper: TimeValue | None, is_angle: bool
) -> dict[str, Any]:
    """Those that are given, by name. Warns of degrees, at the caller of ``add_limit``."""
    given: dict[str, Any] = {k: v for k, v in (("lower", lower), ("upper", upper)) if v is not None}
    first = {k: real_number(at_start(v, f"add_limit: {k}"), f"add_limit: {k}") for k, v in given.items()}
    if not given:
        raise InvalidArgument("add_limit: neither lower nor upper is given: give one of them or both")
    for name, value in first.items():
        if not math.isfinite(value):
            other = "upper" if name == "lower" else "lower"
            raise InvalidArgument(
                f"{title}: add_limit: {name} = {value}: must be finite; leave out a stop that is not there: "
                f"joint.add_limit({other}=...)"
            )
    if len(first) == 2 and not first["lower"] < first["upper"]:
        raise InvalidArgument(f"add_limit: lower = {lower}, upper = {upper}: lower must be below upper")
    if is_angle and all(abs(value) > 8.0 * math.pi for value in first.values()):
        warn(
            f"{title}: add_limit: {', '.join(f'{k} = {v} rad' for k, v in given.items())}: angles are in "
            f"radians; write 90 * stark.deg if degrees are meant"
        )
    return given
