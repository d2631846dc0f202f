"""What the compiler made of a formula."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Statistics:
    """Counts by order: "value", "gradient" and "hessian", or "value" and "jacobian"."""

    backend: str
    operations: dict[str, int]  # of the expression graph
    instructions: dict[str, int]  # after expansion of functions and fusion
    code_bytes: dict[str, int]  # of machine code; 0 for the interpreter
    build_seconds: dict[str, float]  # differentiation, lowering, code
    algorithm: str  # how the hessian was formed

    @classmethod
    def of(cls, backend: str, orders: Mapping[str, Mapping[str, Any]]) -> Statistics:
        """From the counts of each order."""
        columns = ("operations", "instructions", "code_bytes", "build_seconds")
        counts: dict[str, Any] = {c: {order: values[c] for order, values in orders.items()} for c in columns}
        return cls(backend, **counts, algorithm=str(orders.get("hessian", {}).get("algorithm", "")))

    def __str__(self) -> str:
        lines = [f"{'':10}{'operations':>12}{'instructions':>14}{'code [B]':>10}{'build [ms]':>12}"]
        for order in self.operations:
            lines.append(
                f"{order:10}{self.operations[order]:12}{self.instructions[order]:14}"
                f"{self.code_bytes[order]:10}{1e3 * self.build_seconds[order]:12.2f}"
            )
        how = f", hessian by {self.algorithm}" if self.algorithm else ""
        return "\n".join([*lines, f"back end {self.backend}{how}"])
