"""Tables of docs/validation.md as data: what tests measure must agree with what is documented.

A row of a table is ``| `case.quantity` | what | reference | measured | tolerance |``. Numbers in a cell are
the entries of the value; ``<= x`` as the reference stands for a bound, without a tolerance."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

PAGE = Path(__file__).parents[3] / "docs" / "validation.md"
_ROW = re.compile(r"^\| `([^`]+)` \|([^|]*)\|([^|]*)\|([^|]*)\|([^|]*)\|$", re.MULTILINE)
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
# Runs have the same bits on every machine of this kind; a compiler or another processor may move what grows
# from rounding. A documented number is wrong when it is off by more than this part of the tolerance.
_STALE = 0.25


class Row(NamedTuple):
    reference: np.ndarray
    is_bound: bool
    measured: np.ndarray
    tolerance: float


def rows() -> dict[str, Row]:
    """All rows by name."""
    result = {}
    for name, _, reference, measured, tolerance in _ROW.findall(PAGE.read_text()):
        assert name not in result, f"{name} occurs twice in {PAGE.name}"
        is_bound = reference.strip().startswith("<=")
        result[name] = Row(
            _numbers(reference),
            is_bound,
            _numbers(measured),
            0.0 if is_bound else float(_numbers(tolerance)[0]),
        )
    return result


def validate(name: str, measured: ArrayLike) -> None:
    """Compares what was measured with the reference and with the documented value. With the environment
    variable STARK_WRITE_VALIDATION the document takes the measured value first, in a new row if need be."""
    values = np.atleast_1d(np.asarray(measured, dtype=float))
    if os.environ.get("STARK_WRITE_VALIDATION"):
        _write(name, values)
    row = rows()[name]
    if row.is_bound:
        assert np.all(values <= row.reference), f"{name}: {values} is beyond {row.reference}"
        stale = np.abs(values - row.measured) > _STALE * row.reference
    else:
        assert values.shape == row.reference.shape, (
            f"{name}: {values.size} values, {row.reference.size} expected"
        )
        error = np.abs(values - row.reference)
        assert np.all(error <= row.tolerance), f"{name}: {values}, expected {row.reference}, off by {error}"
        stale = np.abs(values - row.measured) > _STALE * row.tolerance
    assert not np.any(stale), f"{name}: {PAGE.name} says {row.measured}, measured {values}"


def _numbers(cell: str) -> np.ndarray:
    return np.array([float(text) for text in _NUMBER.findall(cell)])


def _digits(value: float, tolerance: np.ndarray) -> int:
    """Significant digits that show a hundredth of the tolerance, at least six."""
    if tolerance.size == 0 or value == 0.0:
        return 6
    return max(6, 2 + int(np.ceil(np.log10(abs(value) / tolerance[0]))))


def _write(name: str, values: np.ndarray) -> None:
    text = _with_row(name, PAGE.read_text())
    match = next(m for m in _ROW.finditer(text) if m[1] == name)
    tolerance = _numbers(match[5])[:1]
    cell = ", ".join(f"{v:.{_digits(v, tolerance)}g}" for v in values)
    PAGE.write_text(text[: match.start(4)] + f" {cell} " + text[match.end(4) :])


def _with_row(name: str, text: str) -> str:
    """The page with a row of this name: a new one follows the last of its case, with the same reference."""
    case, _, quantity = name.partition(".")
    of_case = [m for m in _ROW.finditer(text) if m[1].partition(".")[0] == case]
    if not of_case or any(m[1] == name for m in of_case):
        return text
    last = of_case[-1]
    row = f"| `{name}` | {quantity.replace('_', ' ')} |{last[3]}|{last[4]}|{last[5]}|"
    return f"{text[: last.end()]}\n{row}{text[last.end() :]}"
