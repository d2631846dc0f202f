"""Surfaces that come nearer than the least distance: the step says so, and the certificate names it as a
limit; what no step says is violated."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from _recorded_runs import edit_rows, record

import stark
from stark.verify import verify

_CAVEAT = "below_least_distance"
_DISTANCE = 1e-3  # contact distance of each body [m]
_LEAST = 1e-3 * 2.0 * _DISTANCE


def soft_impact(stiffness: float = 1e3, gap: float = 0.01) -> stark.Scene:
    """A steel box, which nothing drives, meets a fixed plate that is too soft for it."""
    scene = stark.Scene("soft_impact")
    scene.add_box((0.4, 0.4, 0.05), motion="fixed", name="plate", position=(0, 0, -0.025))
    scene.add_box(
        0.05,
        density=8000.0,
        name="box",
        position=(0, 0, 0.025 + gap),
        velocity=(0, 0, -40.0),
        contact_stiffness=stiffness,
    )
    return scene


SETTINGS = {"time_step": 1e-3, "contact_distance": _DISTANCE}


def test_a_step_says_that_surfaces_are_too_near() -> None:
    sim = stark.Simulation(soft_impact(), **SETTINGS)
    said = 0
    for _ in range(10):
        report = sim.step()
        assert not report.failed, report.message
        below = report.min_distance < _LEAST * (1.0 - 1e-6)
        assert (_CAVEAT in report.caveats) == below
        if below:
            assert "'plate' and 'box' are" in report.message or "'box' and 'plate' are" in report.message
            assert "below the least distance 2e-06 m" in report.message
            assert re.search(r" are [\d.e-]{1,9} m apart", report.message)  # three digits
        said += below
    assert said > 0


def test_ordinary_impacts_say_nothing() -> None:
    sim = stark.Simulation(soft_impact(stiffness=1e9), **SETTINGS)
    for _ in range(10):
        report = sim.step()
        assert report.min_distance >= _LEAST and _CAVEAT not in report.caveats


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("soft") / "run", soft_impact(), 10, **SETTINGS)


def test_the_certificate_names_it_as_a_limit(run: Path) -> None:
    certificate = verify(run)
    claim = certificate["minimum_distance"]
    assert claim.status == "verified" and "which the run says itself" in claim.detail
    assert claim.worst is not None and claim.tolerance is not None and claim.worst < claim.tolerance
    assert any("where 2e-06 m are asked for" in limit for limit in certificate.limits)


def test_without_the_caveat_it_is_violated(run: Path) -> None:
    def hide(rows: list[dict[str, object]]) -> None:
        for row in rows:
            row["caveats"] = []

    edit_rows(run, hide)
    certificate = verify(run)
    assert certificate["minimum_distance"].status == certificate.verdict == "violated"


def test_a_start_that_is_nearer_is_said_too(tmp_path: Path) -> None:
    """From a gap of half of the least distance: until the box has left it."""
    scene = stark.Scene()
    scene.add_box((0.4, 0.4, 0.05), motion="fixed", name="plate", position=(0, 0, -0.025))
    scene.add_box(0.05, mass=1.0, name="box", position=(0, 0, 0.025 + 0.5 * _LEAST))
    with pytest.warns(stark.StarkWarning):
        folder = record(tmp_path / "run", scene, 3, **SETTINGS)
    claim = verify(folder)["minimum_distance"]
    assert claim.status == "verified" and "says itself" in claim.detail
