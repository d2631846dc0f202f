"""Steps that fail: what is yielded, raised and kept."""

from __future__ import annotations

import copy
import pickle
import warnings
from typing import Any

import numpy as np
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


def test_steps_that_nobody_asks_for_are_warned_about() -> None:
    """``sim.run(until=1.0)`` alone on a line does nothing."""
    scene = stark.Scene()
    scene.add_sphere(0.1, mass=1.0)
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.warns(
        stark.StarkWarning, match=r"run\(until=0\.05\) alone takes no step.*run_until\(0\.05\)"
    ):
        sim.run(until=0.05)
    assert sim.time == 0.0
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        steps = sim.run(until=0.03)
        assert next(steps).time == 0.01 and len(list(steps)) == 2
        for _ in sim.run(until=0.05):
            pass
        sim.run(until=sim.time)  # has nothing to take
    assert sim.time == 0.05 and not caught


def blocked() -> stark.Simulation:
    """A press that goes through a box on an anvil: the second step fails."""
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box")
    scene.add_box((0.3, 0.3, 0.1), name="anvil", motion="fixed", position=(0, 0, -0.11))
    scene.add_box((0.3, 0.3, 0.1), name="press", motion="scripted", position=(0, 0, 0.11))
    return stark.Simulation(scene, time_step=0.01, **{"time.min_step": 0.006})


def test_reports_are_copied_and_sent_to_other_processes() -> None:
    sim = blocked()
    reports = [sim.step()]
    sim["press"].position = (0.0, 0.0, 0.0)
    reports.append(sim.step())
    assert [report.failed for report in reports] == [False, True]
    for report in reports:
        assert copy.copy(report) is report and copy.deepcopy([report])[0] is report  # it does not change
        kept = pickle.loads(pickle.dumps(report))
        for again in (kept, pickle.loads(pickle.dumps(kept)), copy.deepcopy(kept)):
            assert again.to_dict() == report.to_dict() and again.brief() == report.brief()
            assert repr(again) == repr(report)
            for name in ("status", "time", "energy", "phases", "caveats", "failed", "residual"):
                assert getattr(again, name) == getattr(report, name)
            assert np.array_equal(again.momentum, report.momentum)
    assert kept.diagnosis.cause == report.diagnosis.cause == "blocked_motion"
    assert kept.diagnosis.to_dict() == report.diagnosis.to_dict()
    with pytest.raises(AttributeError):
        _ = kept.nothing


def test_a_report_says_which_attribute_was_meant() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    report: Any = stark.Simulation(scene).step()
    for name, hint in (
        ("iterations", "write newton_iterations"),
        ("contacts", "write contact_count, or sim.contacts"),
        ("converged", "write not report.failed"),
        ("newton_iteration", "did you mean 'newton_iterations'"),
    ):
        with pytest.raises(AttributeError, match=f"<stark.StepReport .*> has no attribute '{name}'.*{hint}"):
            getattr(report, name)
    assert not hasattr(report, "nothing") and not hasattr(report, "_nothing")
    assert report.newton_iterations >= 0 and copy.copy(report).step == report.step


@pytest.mark.parametrize("rest", [1e-7, 1e-5, 1e-3, 5e-3])
@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_ends_between_steps_leave_reactions_as_they_are(rest: float, integrator: str) -> None:
    """A pendulum: after a last step of 10 microseconds its hinge read two hundred times its weight."""
    scene = stark.Scene()
    bob = scene.add_box(0.05, mass=0.1, position=(0, 0, 0))
    hinge = scene.add_hinge(None, bob, anchor=(0, 0.3, 0), axis="x")
    sim = stark.Simulation(scene, time_step=0.01, time={"integrator": integrator})
    sim.run_until(0.49)
    before = hinge.reaction.force
    lengths = [report.time_step for report in sim.run(until=0.5 + rest)]
    assert lengths == pytest.approx([0.005 + rest / 2] * 2) and sim.time == 0.5 + rest
    after = hinge.reaction.force
    assert np.linalg.norm(after - before) < 0.3 * np.linalg.norm(before)
