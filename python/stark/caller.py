"""Warnings that point to the line of the user, however deep in the package they are found."""

from __future__ import annotations

import sys
import warnings

from stark.errors import StarkWarning


def warn(message: str) -> None:
    """A StarkWarning at the nearest line that is not of this package. Counts frames, as depths written by
    hand go wrong with every function between."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and _is_ours(frame.f_globals.get("__name__", "")):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, StarkWarning, stacklevel=level)


def _is_ours(module: object) -> bool:
    """Whether calls of a module are none of the user: of this package, and of ``with`` blocks between."""
    return isinstance(module, str) and (module.partition(".")[0] == "stark" or module == "contextlib")
