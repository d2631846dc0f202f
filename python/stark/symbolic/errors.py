"""Errors of formulas told in the user's terms: which formula, and which of the user's own lines."""

from __future__ import annotations

import linecache
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

import numpy as np

from stark._core import TraceError

_OWN = (str(Path(__file__).resolve().parents[1]), str(Path(np.__file__).resolve().parent))


class TraceIndexError(TraceError, IndexError):
    """An index in a formula that is out of range."""


def location_text(filename: str, line: int, function: str) -> str:
    """File, line, function and the source text of the line, as tracebacks show them."""
    source = linecache.getline(filename, line).strip()
    text = f'  File "{filename}", line {line}, in {function}'
    return f"{text}\n    {source}" if source else text


def definition_of(function: Callable[..., object]) -> str:
    """Where a function is defined."""
    code = function.__code__
    # The first line may be a decorator; that of a lambda is its own, and the next def is another function.
    line, name = code.co_firstlineno, code.co_name
    heads = (f"def {name}(", f"async def {name}(")
    for number in range(line, line + 20):
        if linecache.getline(code.co_filename, number).lstrip().startswith(heads):
            line = number
            break
    return location_text(code.co_filename, line, code.co_name)


def user_line(traceback: TracebackType | None) -> str | None:
    """The innermost line of a traceback that is neither of this package nor of NumPy."""
    found = None
    while traceback is not None:
        code = traceback.tb_frame.f_code
        if not str(Path(code.co_filename).absolute()).startswith(_OWN):
            found = location_text(code.co_filename, traceback.tb_lineno, code.co_name)
        traceback = traceback.tb_next
    return found


@contextmanager
def recording(formula: str) -> Iterator[None]:
    """Runs the user's formula: a TraceError gets the formula's name and the user's line, any other exception
    a note with them."""
    try:
        yield
    except TraceError as error:
        place = user_line(error.__traceback__)
        if not getattr(error, "located", False):
            error.args = (f"{formula}: {error}" + (f"\n{place}" if place else ""),)
            error.__dict__["located"] = True
        raise
    except Exception as error:
        place = user_line(error.__traceback__)
        error.add_note(f"while {formula} was recorded" + (f":\n{place}" if place else ""))
        raise


def formula_error(formula: str, message: str, function: Callable[..., object] | None = None) -> TraceError:
    """TraceError that points at the definition of the formula."""
    place = f"\n{definition_of(function)}" if function is not None and hasattr(function, "__code__") else ""
    error = TraceError(f"{formula}: {message}{place}")
    error.__dict__["located"] = True
    return error
