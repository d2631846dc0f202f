"""None in formulas, as of a limit that was never set: named in the message. It ended the process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark

ORDINARY: list[Callable[[Any], object]] = [
    lambda x: stark.sqrt(None),  # type: ignore[call-overload]
    lambda x: stark.minimum(x, None),  # type: ignore[call-overload]
    lambda x: stark.where(x > 0.0, x, None),
    lambda x: stark.where(None, x, 1.0),  # type: ignore[call-overload]
    lambda x: stark.vec(x, None),
    lambda x: stark.vec(x, 1.0) * None,
    lambda x: stark.dot(stark.vec(x, x), None),  # type: ignore[arg-type]
    lambda x: stark.vec(x, x) + np.array([None, 1.0]),
    lambda x: x * stark.sqrt(np.array(None)),
]


@pytest.mark.parametrize("formula", ORDINARY)
def test_none_is_refused(formula: Callable[[Any], object]) -> None:
    with pytest.raises(stark.TraceError, match="got NoneType"):
        formula(stark.symbolic.symbols("x"))


def test_none_in_an_energy_names_the_line() -> None:
    ceiling = None

    @stark.energy
    def soft_ceiling(p: stark.Point):
        return stark.maximum(p.x[2] - stark.abs(ceiling), 0.0) ** 2  # type: ignore[call-overload]

    ball = stark.Scene().add_sphere(0.1, mass=1.0)
    with pytest.raises(stark.TraceError, match=r"(?s)soft_ceiling: abs: got NoneType.*stark\.abs\(ceiling\)"):
        soft_ceiling(ball.points((0, 0, 0)))
