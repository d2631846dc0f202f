"""A live view of a simulation in a browser, with the packages of the extra 'view' (docs/view.md). Nothing of
it is imported, and no thread runs, before a view is asked for."""

from .pulls import Held, Pulls, add_pulls
from .view import View

__all__ = ["Held", "Pulls", "View", "add_pulls"]
