"""Which recording of a simulation is the newest: what ``sim.show()`` replays."""

from __future__ import annotations

import weakref
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from .format import RecordingError
from .reader import Recording


class Recorded(Protocol):
    """A recorder."""

    folder: Path

    def sync_if_open(self) -> None:
        """Writes what it has recorded so far."""


class _Made(NamedTuple):
    """Where a recording was begun, and when; who does, as long as it is there."""

    recorder: weakref.ref[Recorded]
    folder: Path
    created: str


#: Keeps neither simulations nor recorders.
_RECORDINGS: weakref.WeakKeyDictionary[Any, _Made] = weakref.WeakKeyDictionary()


def remember(sim: Any, recorder: Recorded, created: str) -> None:
    """The recording that was begun at the time ``created`` is the newest one of ``sim`` from now on."""
    try:
        _RECORDINGS[sim] = _Made(weakref.ref(recorder), recorder.folder, created)
    except TypeError:  # something that cannot be referred to weakly only looks like a simulation
        return


def latest_recording(sim: Any) -> Recording | None:
    """The newest recording of a simulation with all of its frames, those included that its recorder has not
    written yet; None without frames, and where the folder is gone or holds a later recording."""
    made = _RECORDINGS.get(sim)
    if made is None:
        return None
    recorder = made.recorder()
    if recorder is not None:
        recorder.sync_if_open()
    try:
        recording = Recording(made.folder)
    except RecordingError:
        return None
    return recording if len(recording) and recording.manifest.get("created") == made.created else None
