"""A one-line progress bar on a terminal; silent anywhere else."""

from __future__ import annotations

import math
import os
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
        elapsed = now - self._begin
        left = f"{elapsed * (1.0 / share - 1.0):.0f} s left" if 0.02 < share < 1.0 else f"{elapsed:.1f} s"
        words = f"{100 * share:3.0f} %  {left}  {text}"
        # In one row, without its last place: the next drawing removes no row but that of the cursor.
        columns = self._columns() - 1
        width = max(0, min(self._WIDTH, columns - 1 - len(words)))
        filled = round(share * width)
        line = ("━" * filled + "─" * (width - filled) + " " + words)[:columns]
        self._stream.write(f"\r\033[K{line}")
        self._stream.flush()

    def _columns(self) -> int:
        """Of the terminal as it is now; 80 where it does not say."""
        try:
            return os.get_terminal_size(self._stream.fileno()).columns or 80
        except (OSError, ValueError):
            return 80

    def close(self) -> None:
        """Removes the bar."""
        if self._on:
            self._stream.write("\r\033[K")
            self._stream.flush()
