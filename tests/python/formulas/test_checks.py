"""Reports of checks of formulas, invariance, listings, timings."""

from __future__ import annotations

import pytest
from _scenes import anchor, sheet, sheet_and_box, spring, tie

import stark


@stark.energy
def kinked(e: stark.Edge, k: float = 10.0):
    return k * stark.maximum(e.length - e.rest_length, 0.0)


@stark.energy
def jumping(e: stark.Edge, k: float = 10.0):
    return stark.where(e.length > e.rest_length, k, 0.5 * k) * e.length


@stark.energy
def rubbing(p: stark.Point, h: stark.TimeStep):
    return h * stark.abs(p.v[0])


@stark.energy
def idle(e: stark.Edge, gap: float = 0.001):
    return 10 * stark.maximum(stark.abs(e.length - e.rest_length) - gap * e.rest_length, 0.0)


@stark.energy
def stepping(p: stark.Point, depth: float = 0.002):
    return p.x @ p.x + stark.where(p.x[2] < p.X[2] - 1e-4, depth, 0.0) * 0.01


@stark.energy
def steep(p: stark.Point, width: float = 1e-4):
    return stark.tanh((p.x[2] - p.X[2]) / width) + stark.sqrt((p.x[0] - p.X[0]) ** 2 + width**2)


@stark.energy(translation_invariant=True)
def wrongly_declared(e: stark.Edge, k: float = 10.0):
    return k * stark.squared_norm(e[0].x + e[1].x)


def test_reports_name_what_is_wrong() -> None:
    _, cloth = sheet(4)
    good = spring.check(cloth.edges)
    assert good.ok and "nothing is wrong" in str(good)
    assert good["gradient"].value < 1e-8 and good["hessian"].value < 1e-8
    assert {good[name].status for name in ("translation", "rotation", "start", "back ends")} == {"ok"}
    assert good["definiteness"].status == "note" and 0.2 < good["definiteness"].value < 0.8
    kink = kinked.check(cloth.edges)
    assert kink.ok and kink["continuous forces"].status == "note"
    jump = jumping.check(cloth.edges)
    assert not jump.ok and jump["continuous energy"].status == "wrong"
    assert not wrongly_declared.check(cloth.edges).ok
    pulled = anchor.check(cloth.vertices, target=(0.0, 0.0, 0.3))
    assert pulled.ok
    assert {pulled[name].status for name in ("translation", "rotation", "start")} == {"note"}
    with pytest.raises(KeyError, match="no finding"):
        good["colour"]


def test_kinks_are_no_jumps_of_the_energy_wherever_they_are() -> None:
    """At the start exactly, where all rates are zero, and 1 % of an element beside it; for a single point,
    too, whose way does not lead through a kink by luck."""
    scene, cloth = sheet(4)
    ball = scene.add_sphere(0.05, mass=0.1, position=(0, 0, 1))
    for report in (
        rubbing.check(cloth.vertices), rubbing.check(ball.points((0, 0, 0))), rubbing.check(ball.vertices),
        idle.check(cloth.edges), kinked.check(cloth.edges),
    ):  # fmt: skip
        assert report.ok, report
        assert report["continuous energy"].value < 1e-5
        assert report["continuous forces"].status == "note"
        assert report["continuous forces"].value > 0.4
        assert "the forces jump near the start by" in str(report) and "has a kink" in str(report)


def test_small_jumps_are_found_and_steep_energies_are_smooth() -> None:
    _, cloth = sheet(4)
    report = stepping.check(cloth.vertices)
    assert not report.ok and "the energy jumps near the start by" in str(report)
    smooth = steep.check(cloth.vertices)
    assert smooth["continuous energy"].status == smooth["continuous forces"].status == "ok"


def test_invariance_under_translation_is_found_in_the_formula() -> None:
    scene, cloth, box = sheet_and_box()
    assert spring(cloth.edges).translation_invariant
    assert tie(cloth.vertices, box.points((0.0, 0.0, 0.0))).translation_invariant
    assert not anchor(cloth.vertices, target=(0.0, 0.0, 0.0)).translation_invariant

    @stark.energy
    def about_the_middle(t: stark.Triangle):
        return sum(stark.squared_norm(p.x - t.center) for p in t)

    @stark.energy
    def damped(e: stark.Edge, h: stark.TimeStep):
        # The velocity of a point changes when positions are moved and previous ones are not.
        return h * stark.squared_norm(e[0].v + e[1].v)

    assert about_the_middle(cloth.faces).translation_invariant
    assert not damped(cloth.edges).translation_invariant
    assert not wrongly_declared.trace().translation_invariant
    scene.add(about_the_middle(cloth.faces))
    stark.Simulation(scene)  # checks declared invariance numerically


def test_listings_counts_and_timings() -> None:
    _, cloth = sheet(2)
    text = str(spring.graph())
    assert text.startswith("spring(e, stiffness):")
    assert all(word in text for word in ("e[1].x[0]", "e[0].X[2]", "stiffness", "sqrt"))
    statistics = spring.statistics
    assert statistics.instructions["hessian"] > statistics.instructions["value"] > 10
    assert statistics.algorithm and statistics.backend in str(statistics)
    nanoseconds = spring.benchmark(cloth.edges)
    assert list(nanoseconds) == ["value", "gradient", "hessian"]
    assert all(0.0 < ns < 1e5 for ns in nanoseconds.values())
    assert spring.name == "spring" and "Spring between" in spring.__doc__
    assert repr(spring(cloth.edges)) == "<spring on 16 elements; add it with scene.add>"
