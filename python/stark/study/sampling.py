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


@dataclass(frozen=True)
class Range:
    """Numbers from ``low`` to ``high``, both included; ``count`` of them in a grid. ``log``: equal ratios
    instead of equal differences. ``whole``: rounded to integers."""

    low: float
    high: float
    count: int = 0
    log: bool = False
    whole: bool = False

    def at(self, share: float) -> Value:
        """The number at a share in [0, 1] of the way; the ends are met exactly."""
        if self.whole and not self.log:
            return int(self.low) + min(int(share * (self.high - self.low + 1)), int(self.high - self.low))
        if share <= 0.0:
            number = self.low
        elif share >= 1.0:
            number = self.high
        elif self.log:
            number = math.exp(math.log(self.low) + share * (math.log(self.high) - math.log(self.low)))
        else:
            number = self.low + share * (self.high - self.low)
        return round(number) if self.whole else number

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
