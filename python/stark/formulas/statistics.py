"""What the compiler made of a formula."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stark import _core
from stark.symbolic.statistics import Statistics

ORDERS = ("value", "gradient", "hessian")


class FormulaStatistics(Statistics):
    """Counts of a formula for "value", "gradient" and "hessian"."""

    @classmethod
    def of(cls, formula: _core.Formula, backend: str = "automatic") -> FormulaStatistics:  # type: ignore[override]
        """Compiles the formula with all parameters shared, and counts."""
        s: Mapping[str, Any] = formula.statistics(backend)
        columns = ("operations", "instructions", "code_bytes", "build_seconds")
        counts = {c: dict(zip(ORDERS, s[c], strict=True)) for c in columns}
        return cls(s["backend"], **counts, algorithm=s["algorithm"])
