"""A one-line progress bar on a terminal; silent anywhere else."""

from __future__ import annotations

import math
import sys
import time
from typing import TextIO


class Progress:
    """Shows how far something has come. Nothing is written when the stream is not a terminal or ``quiet`` is
    set."""

    #: Between two drawings [s].
    PERIOD = 0.1
    _WIDTH = 28

    def __init__(self, total: float, *, quiet: bool = False, stream: TextIO | None = None) -> None:
        self._stream = sys.stderr if stream is None else stream  # None where that is closed, as of a service
        self._on = not quiet and self._stream is not None and self._stream.isatty()
        self._total = total
        self._begin = time.perf_counter()
        self._shown = -math.inf

    def update(self, done: float, text: str = "") -> None:
        """Draws the bar at ``done`` of the total, once in a ``PERIOD`` at most."""
        now = time.perf_counter()
        if not self._on or (now - self._shown < self.PERIOD and done < self._total):
            return
        self._shown = now
        share = min(1.0, max(0.0, done / self._total)) if self._total > 0 else 1.0
        filled = round(share * self._WIDTH)
        elapsed = now - self._begin
        left = f"{elapsed * (1.0 / share - 1.0):.0f} s left" if 0.02 < share < 1.0 else f"{elapsed:.1f} s"
        bar = "━" * filled + "─" * (self._WIDTH - filled)
        self._stream.write(f"\r\033[K{bar} {100 * share:3.0f} %  {left}  {text}")
        self._stream.flush()

    def close(self) -> None:
        """Removes the bar."""
        if self._on:
            self._stream.write("\r\033[K")
            self._stream.flush()
