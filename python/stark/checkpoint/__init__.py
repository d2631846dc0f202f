"""Checkpoints: where a simulation is, as a value and as a file, to go on from bit for bit.

    sim.save("settled.stark")
    ...
    sim = stark.Simulation(scene, settings)     # the same scene, in another process or on another day
    sim.load("settled.stark")

A file holds the state, the live values of energies, what a controller remembers, and hashes of the scene, so
that a file of another scene is refused with a list of what differs. It is written whole or not at all, has a
CRC on every array and a hash of the state; a damaged file gives a ``CheckpointError``, never anything else.
``docs/checkpoints.md`` has the format."""

from .errors import CheckpointError
from .value import Checkpoint

__all__ = ["Checkpoint", "CheckpointError"]
