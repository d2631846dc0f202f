"""Reproducers: a time step as a folder of its own, to be taken again anywhere.

    report = sim.step()
    if report.failed:
        sim.write_reproducer("failure")

    $ python failure/reproduce.py

The folder holds ``step.npz`` (the scene as data, formulas of the user included, the settings, the state
before the step) and a script that takes the step again. ``load`` gives the simulation to look into. What
cannot be written is listed in the script and by ``load``: laws that were made by other means than
``@stark.material``, formulas of more operations than a scene document holds."""

from .errors import ReproducerError
from .loading import load
from .writing import write

__all__ = ["ReproducerError", "load", "write"]
