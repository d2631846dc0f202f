"""The list of all scenes."""

from __future__ import annotations

from . import deformables, degenerate, impacts, piles, tight
from .case import Case

CASES: dict[str, Case] = {
    case.name: case
    for case in (*impacts.CASES, *tight.CASES, *piles.CASES, *deformables.CASES, *degenerate.CASES)
}
