"""Values drawn from bytes: the first choice of everything is a good one, and a byte 0 takes it, so that zeros
are good input, and input with few other bytes is good but for a few values."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")

#: Numbers that go wrong: not finite, of any scale, of any type, and what is no number at all.
ODD_NUMBERS: tuple[Any, ...] = (
    0.0, -1.0, float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1e-308, 5e-324, 1e16, 1e-16, 1.0,
    2**31, 2**63, 10**400, True, None, "1", "x", b"1", 1j, [], [1.0], (1.0, 2.0), {}, object(),
    np.float32(1.0), np.int8(3), np.uint64(2**64 - 1), np.nan, np.array(2.0), np.array([1.0]),
    np.array([], dtype=int), np.array("a"), np.array([None]), np.datetime64("2020-01-01"),
    np.zeros((3, 3, 3)),
    range(3), len,
)  # fmt: skip

#: Types that arrays are turned into.
_TYPES = ("f8", "f4", "i4", "i8", "u1", "?", "c16", "U4", "O", "f2", "M8[s]", "S2")


class Draw:
    """Takes decisions from bytes, zeros once they are used up."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0
        #: What was done, for the message of a failure.
        self.trace: list[str] = []
        #: Where temporary files go: in memory, as disks take longer than what is tested.
        self.memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None

    def byte(self) -> int:
        self._at += 1
        return self._data[self._at - 1] if self._at <= len(self._data) else 0

    def integer(self, count: int) -> int:
        """In [0, count). Raises IndexError where there is nothing to choose from."""
        if count == 0:
            raise IndexError("nothing to choose from")
        return (self.byte() * 256 + self.byte()) % count if count > 256 else self.byte() % count

    def pick(self, choices: Sequence[T]) -> T:
        return choices[self.integer(len(choices))]

    @property
    def is_odd(self) -> bool:
        """Whether the next value goes wrong: one byte of eight."""
        return self.byte() % 8 == 1

    def value(self, good: Any, odd: Sequence[Any] = ODD_NUMBERS) -> Any:
        """A good value, or one that is not."""
        return self.pick(odd) if self.is_odd else good

    def text(self, *good: str | None) -> Any:
        return self.value(
            self.pick(good), ("", "x", "box", "floor", 7, None, b"a", "\0", "é" * 300, ["a"], {}, 1.5)
        )

    def count(self, good: int) -> Any:
        """How many of something; none that fills the memory of a computer."""
        return self.value(
            good, (0, -1, 1, 2, 3.0, 2.5, True, None, "3", float("nan"), float("inf"), -(2**70), [2], 2**40)
        )

    def array(self, good: Any) -> Any:
        """A good array, or one with another value, type, shape or order."""
        if not self.is_odd:
            return good
        array, kind = np.array(good), self.integer(12)
        if kind < 4 and array.size and array.dtype.kind in "if":
            place = self.integer(array.size)
            odd: Sequence[Any] = (np.nan, np.inf, -np.inf, 1e308, 1e30, 1e-30, 0.0, -1.0)
            if array.dtype.kind == "i":
                odd = (-1, len(array), 10**6, 2**31 - 1, -(2**31), 0, 1)
            array.reshape(-1)[place] = self.pick(odd)
            return array
        changes: tuple[Callable[[], Any], ...] = (
            lambda: _as_type(array, self.pick(_TYPES)),
            lambda: array[:0],
            lambda: array.reshape(-1),
            lambda: array[None],
            lambda: array.T,
            lambda: array[..., :-1],
            lambda: np.concatenate([array, array]),
            lambda: [*array.tolist()[:-1], [1]],
            lambda: np.zeros_like(array),
            lambda: array[::-1],
            lambda: np.asfortranarray(array)[::2],
            lambda: self.pick(ODD_NUMBERS),
        )
        try:
            return self.pick(changes)()
        except (ValueError, IndexError, TypeError):
            return array

    def vector(self, *good: float) -> Any:
        return self.array(np.array(good)) if self.byte() % 2 else self.array(list(good))


def _as_type(array: np.ndarray, kind: str) -> Any:
    with np.errstate(all="ignore"):
        return array.astype(kind)
