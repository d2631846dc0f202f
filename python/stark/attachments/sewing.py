"""Threads that draw the points of a seam together."""

from __future__ import annotations

from typing import Any

from stark._core import InvalidArgument
from stark.arguments import real_number
from stark.formulas import Point, Time, energy, parameter
from stark.symbolic import Scalar, dot, maximum, sqrt

_TINY = 1e-9  # keeps the length differentiable where both ends are at the same place [m]


@energy
def threads(
    a: Point,
    b: Point,
    now: Time,
    length: float = parameter(unit="m", min=0.0, doc="at time 0"),
    duration: float = parameter(unit="s", above=0.0, doc="time after which a thread has no length left"),
    force: float = parameter(unit="N", min=0.0, doc="most that a thread pulls with"),
    reach: float = parameter(1e-3, unit="m", above=0.0, doc="extension at which it pulls with 0.7 of it"),
) -> Scalar:
    """A thread that is wound up: slack where its ends are nearer than it is long."""
    d = a.x - b.x
    left = length * maximum(1.0 - now / duration, 0.0)
    extension = maximum(sqrt(dot(d, d) + _TINY**2) - left, 0.0)
    return force * (sqrt(extension * extension + reach * reach) - reach)


def check_thread(name: str | None, duration: Any, force: Any) -> None:
    """InvalidArgument for a duration [s] or a force [N] that no thread has; before anything is added."""
    owner = "seam" if name is None else f"seam '{name}'"
    for what, value, unit in (("duration", duration, "s"), ("force", force, "N")):
        if not 0.0 < real_number(value, f"{owner}: {what}") < float("inf"):
            raise InvalidArgument(f"{owner}: {what} = {value!r} {unit}: must be > 0 and finite")
