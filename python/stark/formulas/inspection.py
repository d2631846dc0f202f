"""Energies of some elements, evaluated for tests and benchmarks."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from stark.formulas.binding import BoundEnergy
from stark.formulas.statistics import ORDERS


def sample_inputs(
    binding: BoundEnergy, x: np.ndarray, x_prev: np.ndarray, rows: np.ndarray, time_step: float = 1.0 / 60.0
) -> dict[str, Any]:
    """Inputs of some elements for Formula.evaluate. x, x_prev (elements, points, 3); rows: their numbers."""
    rest = stacked(binding, "rest_positions", rows)
    start = stacked(binding, "positions", rows)
    values = {}
    for name, (numbers, per_element) in binding.core_values().items():
        width = len(numbers) // (binding.element_count if per_element else 1)
        given = numbers.reshape(-1, width)
        values[name] = np.ascontiguousarray(given[rows if per_element else np.zeros_like(rows)]).reshape(-1)
    flat = {"x": x, "x_prev": x_prev, "X": rest, "x_initial": start}
    arrays = {key: np.ascontiguousarray(value).reshape(-1, 3) for key, value in flat.items()}
    return {**arrays, "values": values, "time_step": time_step, "time": time_step}


def stacked(binding: BoundEnergy, kind: str, rows: np.ndarray) -> np.ndarray:
    """ "positions" or "rest_positions" of the points of some elements (elements, points, 3)."""
    columns = [getattr(c, kind) for c in binding.columns]
    return np.stack([c[rows if len(c) > 1 else np.zeros_like(rows)] for c in columns], axis=1)


def benchmark(binding: BoundEnergy, seconds: float = 0.05) -> dict[str, float]:
    """Nanoseconds per element and order on one thread, the best of several runs."""
    count = 4096
    rows = np.arange(count) % binding.element_count
    x = stacked(binding, "positions", rows)
    sample = binding.trace.formula.sample(sample_inputs(binding, x, x, rows))
    result = {}
    for order, name in enumerate(ORDERS):
        sample.run(order)
        best, begin = float("inf"), time.perf_counter()
        while time.perf_counter() - begin < seconds:
            start = time.perf_counter()
            sample.run(order)
            best = min(best, time.perf_counter() - start)
        result[name] = 1e9 * best / count
    return result
