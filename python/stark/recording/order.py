"""Times of a recording go forward: frames, states and lines of telemetry, each for itself."""

from __future__ import annotations

import math
from pathlib import Path

from .format import RecordingError


class Forward:
    """The times of the last frame, state and line of telemetry [s], minus infinity before the first."""

    def __init__(self, folder: Path, *, frame: float = -math.inf, step: float = -math.inf) -> None:
        self._folder = folder
        self._last = {"frame": frame, "state": step, "step": step}

    @property
    def last_frame(self) -> float:
        """Of the last frame [s]."""
        return self._last["frame"]

    def require(self, what: str, time: float) -> float:
        """The time [s] of the next ``what``: "frame", "state" or "step". Raises RecordingError where it is
        before that of the last one, and changes nothing."""
        last = self._last[what]
        if not math.isfinite(time):
            raise RecordingError(f"recording '{self._folder}': a {what} at {time} s; must have a finite time")
        if time < last:
            raise RecordingError(
                f"recording '{self._folder}': a {what} at {time:.9g} s follows one at {last:.9g} s: the "
                f"simulation went back (sim.reset(), sim.state = ..., or another one), and times of a "
                f"recording must go forward; make another Recorder, with a folder of its own, for each "
                f"episode. What was recorded up to here stays"
            )
        return time

    def note(self, what: str, time: float) -> None:
        """It has been recorded."""
        self._last[what] = time
