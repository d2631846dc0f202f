"""What is measured of the runs of other simulators: benchmarks/peers."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from benchmarks.peers import cases, in_stark, page  # noqa: E402


def test_overlaps_of_cubes() -> None:
    """Cubes side by side, one through the floor, one through an edge of another by a known depth."""
    upright = np.eye(3)
    places = np.array([[0.0, 0.0, 0.05], [0.101, 0.0, 0.05], [5.0, 0.0, 0.048]])
    found = cases.of_pile(places, np.array([upright] * 3))
    assert (found["overlaps"], found["deepest"]) == (1.0, pytest.approx(0.002))
    turned = stark.rotation(axis="z", angle=45 * stark.deg)
    half = 0.05 * np.sqrt(2.0)  # of the turned cube, along x
    places = np.array([[0.0, 0.0, 0.05], [0.05 + half - 0.003, 0.0, 0.05]])
    found = cases.of_pile(places, np.array([upright, turned]))
    assert (found["overlaps"], found["deepest"]) == (1.0, pytest.approx(0.003))
    places[1, 0] += 0.0031
    assert cases.of_pile(places, np.array([upright, turned]))["overlaps"] == 0.0


def test_creep_acceleration_and_spin() -> None:
    times = 0.01 * np.arange(1, 201)
    assert cases.of_incline(1e-3 * times, 0.01, cases.BELOW)["creep"] == pytest.approx(1e-3)
    exact = 0.5 * cases.sliding() * times**2 + 0.1 * times
    assert cases.of_incline(exact, 0.01, cases.ABOVE)["error"] < 1e-9
    assert cases.of_incline(1.02 * exact, 0.01, cases.ABOVE)["error"] == pytest.approx(0.02)
    spin = np.array(cases.SPIN)
    assert np.linalg.norm(spin) == pytest.approx(10.0, abs=1e-4)
    assert cases.of_spin(np.eye(3), 0.9 * spin) == pytest.approx({"lost": 0.1, "error": 0.1})


def test_stark_is_within_the_bounds() -> None:
    names = ("incline_below", "free_spin")
    rows = [{"case": case, "system": "Stark"} | in_stark.run(case)[0] for case in names]
    for row in page.with_errors(rows):
        assert row["shown"] < 1e-6 * page.CASES[row["case"]].most


def test_page_tells_who_is_faster() -> None:
    """Only rows that are accurate enough are compared, whoever wins."""

    def row(system: str, cpu: float, creep: float) -> dict[str, Any]:
        return {"case": "incline_below", "system": system, "settings": "", "cpu_s": cpu, "creep": creep}

    peers = [row("A 1", 0.1, 1e-7), row("B 1", 0.8, 0.0), row("C 1", 0.1, 1.0)]
    text = page.page([row("Stark 0", 0.4, 0.0), *peers])
    assert "A 1 is 4.0 times as fast as Stark." in text
    assert "Stark is 2.0 times as fast as B 1." in text
    assert "C 1 is not accurate enough" in text
    assert text.count("**") == 2
