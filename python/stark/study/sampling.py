"""Which options the runs of a study have: a grid, a list, or points drawn from ranges with a seed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

#: A value of an option, as TOML has them.
Value = bool | int | float | str

Options = dict[str, Value]


class Drawn(int):
    """An integer drawn between two integers; ``exact`` is the number that it was rounded from, which an
    option takes whose default is no integer."""

    exact: float

    def __new__(cls, whole: int, exact: float = 0.0) -> Drawn:
        drawn = super().__new__(cls, whole)
        drawn.exact = exact
        return drawn


@dataclass(frozen=True)
class Range:
    """Numbers from ``low`` to ``high``, both included; ``count`` of them in a grid. ``log``: equal ratios
    instead of equal differences. ``whole``: rounded to integers; ``either``: where the default of the option
    is an integer (``Drawn``)."""

    low: float
    high: float
    count: int = 0
    log: bool = False
    whole: bool = False
    either: bool = False

    def at(self, share: float) -> Value:
        """The number at a share in [0, 1] of the way; the ends are met exactly."""
        whole = self._rounded(share) if self.whole or self.either else 0
        if self.whole:
            return whole
        if share <= 0.0:
            number = self.low
        elif share >= 1.0:
            number = self.high
        elif self.log:
            number = math.exp(math.log(self.low) + share * (math.log(self.high) - math.log(self.low)))
        else:
            number = self.low + share * (self.high - self.low)
        return Drawn(whole, float(number)) if self.either else number

    def _rounded(self, share: float) -> int:
        """Each integer has an equal part of the range; with ``log``, the nearest one."""
        if not self.log:
            steps = min(int(share * (self.high - self.low + 1)), int(self.high - self.low))
            return int(self.low) + steps
        low, high = math.log(self.low), math.log(self.high)
        return round(math.exp(low + min(max(share, 0.0), 1.0) * (high - low)))

    def grid(self) -> list[Value]:
        """``count`` numbers, evenly spaced."""
        return [self.at(k / max(1, self.count - 1)) for k in range(self.count)]


#: What an option is taken from: the values of a list, or a range.
Axis = Range | Sequence[Value]


def _values(axis: Axis) -> list[Value]:
    return axis.grid() if isinstance(axis, Range) else list(axis)


def grid(axes: dict[str, Axis]) -> list[Options]:
    """All combinations; the last option varies fastest."""
    return [dict(zip(axes, row, strict=True)) for row in itertools.product(*map(_values, axes.values()))]


def one_at_a_time(bases: Sequence[Options], variations: dict[str, Axis]) -> list[Options]:
    """Each base, and after it the base with each value of one variation at a time."""
    changes: list[Options] = [{name: value} for name, axis in variations.items() for value in _values(axis)]
    return [{**base, **change} for base in bases for change in [{}, *changes]]


def random(axes: dict[str, Axis], count: int, seed: int) -> list[Options]:
    """``count`` independent draws, the same for the same seed."""
    return _points(axes, np.random.default_rng(seed).random((count, len(axes))))


def latin_hypercube(axes: dict[str, Axis], count: int, seed: int) -> list[Options]:
    """``count`` draws of which each option has one in every ``count``-th of its range. Raises ImportError
    without SciPy."""
    try:
        from scipy.stats import qmc
    except ImportError:
        raise ImportError(
            "sampling.kind = 'latin_hypercube' needs SciPy: pip install 'stark-sim[sweep]'"
        ) from None
    return _points(axes, qmc.LatinHypercube(d=len(axes), rng=np.random.default_rng(seed)).random(count))


def _points(axes: dict[str, Axis], shares: Any) -> list[Options]:
    """Options at points (n, number of axes) of the unit cube."""
    return [{name: _pick(axes[name], float(u)) for name, u in zip(axes, row, strict=True)} for row in shares]


def _pick(axis: Axis, share: float) -> Value:
    if isinstance(axis, Range):
        return axis.at(share)
    return axis[min(int(share * len(axis)), len(axis) - 1)]
