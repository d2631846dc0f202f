"""Steps that fail: what is yielded, raised and kept."""

from __future__ import annotations

import pytest

import stark
from stark import mesh


def test_a_failed_step_is_yielded_and_then_raised() -> None:
    scene = stark.Scene()
    scene.add_cloth(mesh.grid(0.4, 0.4, 6), pins=[0])
    # A swinging cloth cannot converge in one iteration at such tolerances, and the step may not be halved.
    sim = stark.Simulation(
        scene,
        time_step=0.05,
        **{"time.min_step": 0.05, "newton.max_iterations": 1, "newton.step_tolerance": 1e-12,
           "newton.acceleration_tolerance": 1e-12},
    )  # fmt: skip
    before, reports = sim.state, []
    with pytest.raises(stark.StepFailed) as caught:
        for report in sim.run(until=1.0):
            reports.append(report)
    assert reports[-1].status == "failed" and caught.value.report.message
    assert sim.time < 1.0 and (len(reports) > 1 or sim.state == before)
