"""Which recorder of a simulation is the newest: what ``sim.show()`` replays."""

from __future__ import annotations

import weakref
from typing import Any, Protocol

from .reader import Recording


class Recorded(Protocol):
    """A recorder."""

    def recorded(self) -> Recording | None:
        """What it has recorded so far; None if that is nothing, or not there any more."""


#: Neither keeps the other alive.
_RECORDERS: weakref.WeakKeyDictionary[Any, Recorded] = weakref.WeakKeyDictionary()


def remember(sim: Any, recorder: Recorded) -> None:
    """The recorder is the newest one of ``sim`` from now on."""
    try:
        _RECORDERS[sim] = recorder
    except TypeError:  # something that cannot be referred to weakly only looks like a simulation
        return


def latest_recording(sim: Any) -> Recording | None:
    """The newest recording of a simulation with all of its frames, written so far or not; None where there is
    none, or the folder is not that of it any more."""
    recorder = _RECORDERS.get(sim)
    return None if recorder is None else recorder.recorded()
