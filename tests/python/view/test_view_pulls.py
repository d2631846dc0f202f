"""Springs that a view pulls with: no trace while they do not pull, Hooke's law while they do."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from _views import falling

import stark
from stark.view.pulls import add_pulls, pulls_of


def test_springs_that_do_not_pull_leave_every_bit_as_it_is() -> None:
    plain, prepared = falling(), falling()
    add_pulls(prepared)
    hashes = []
    for scene in (plain, prepared):
        sim = stark.Simulation(scene, time_step=0.01)
        sim.run_until(0.1)
        hashes.append(sim.state.hash)
    assert hashes[0] == hashes[1]


def test_a_ball_hangs_where_hookes_law_says() -> None:
    """At rest k (t - x) = m g: 0.6 kg on 300 N/m hang 19.6 mm below the target, straight below it."""
    scene = stark.Scene()
    scene.add_sphere(0.05, name="ball", mass=0.6, position=(0, 0, 1.0))
    pulls = add_pulls(scene)
    sim = stark.Simulation(scene, time_step=0.02)
    pulls.hold("ball", (0.05, 0, 1.0), stiffness=300.0)
    pulls.move((0.0, 0.0, 1.2))
    sim.run_until(6.0)
    stretch = 0.6 * 9.81 / 300.0
    # A hundredth of the stretch: what still swings after 6 s.
    np.testing.assert_allclose(pulls.point, [0.0, 0.0, 1.2 - stretch], atol=0.01 * stretch)
    held_at = np.linalg.norm(np.asarray(pulls.point) - sim["ball"].position)
    assert held_at == pytest.approx(0.05, rel=1e-6), "the point stays on the ball"
    pulls.let_go()
    before = sim["ball"].velocity[2]
    sim.run_until(6.1)
    assert sim["ball"].velocity[2] - before == pytest.approx(-0.981, rel=1e-3), "it falls freely"


def test_a_vertex_of_a_solid_follows_and_the_formulas_pass_their_check() -> None:
    scene = falling()
    pulls = add_pulls(scene)
    sim = stark.Simulation(scene, time_step=0.01)
    pulls.hold(sim["jelly"], (0.1, 0.1, 0.15))
    assert pulls.held is not None and pulls.held.vertex is not None
    start = np.asarray(pulls.point)
    pulls.move(start + np.array([0.0, 0.0, 0.1]))
    sim.run_until(0.3)
    assert np.asarray(pulls.point)[2] > start[2] + 0.02
    for spring in pulls.energies:
        spring.check()


def test_only_what_moves_freely_can_be_pulled() -> None:
    scene = falling()
    pulls = add_pulls(scene)
    assert set(pulls.bodies) == {"jelly", "ball"}
    assert add_pulls(scene) is pulls
    with pytest.raises(stark.InvalidArgument, match=r"pull of 'floor': must be one of jelly, ball"):
        pulls.hold("floor", (0, 0, 0))
    with pytest.raises(stark.InvalidArgument, match=r"nothing is held: call hold"):
        pulls.move((0, 0, 0))
    with pytest.raises(stark.InvalidArgument, match=r"stiffness = -1 N/m: must be > 0"):
        pulls.hold("ball", (0, 0, 0), stiffness=-1.0)
    with pytest.raises(stark.InvalidArgument, match=r"must be a stark\.Scene"):
        add_pulls("scene")


def test_springs_that_come_too_late_are_refused() -> None:
    scene = falling()
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.raises(stark.InvalidArgument, match=r"before stark\.Simulation\(scene\) is made"):
        add_pulls(scene)
    assert pulls_of(sim) is None
    del sim
    gc.collect()
    add_pulls(scene)
    assert pulls_of(stark.Simulation(scene, time_step=0.01)) is not None
