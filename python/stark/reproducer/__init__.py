"""Reproducers: a time step as a folder of its own, to be taken again anywhere.

    report = sim.step()
    if report.failed:
        sim.write_reproducer("failure")

    $ python failure/reproduce.py

The folder holds ``step.npz`` (the scene as data, the settings, the state before the step) and a script that
takes the step again. ``load`` gives the simulation to look into. Formulas of the user's own are code, not
data: what cannot be written is listed in the script and by ``load``."""

from .errors import ReproducerError
from .loading import load
from .writing import write

__all__ = ["ReproducerError", "load", "write"]
