"""Friction is no couple: it conserves the angular momentum of free bodies."""

from __future__ import annotations

import numpy as np
import pytest

import stark


def _change(friction: float, gap: float, step: float, integrator: str) -> float:
    """Change of the angular momentum, over itself, in an oblique hit of two free boxes."""
    scene = stark.Scene()
    scene.default_friction = friction
    scene.add_box((0.2, 0.2, 0.1), mass=1.0, position=(0, 0, 0.05))
    above = 0.15 + gap + 0.002
    scene.add_box((0.1, 0.1, 0.1), mass=1.0, position=(-0.02, 0, above), velocity=(1.0, 0, -0.5))
    settings = {"gravity": (0, 0, 0), "contact_distance": 0.5 * gap, "time.integrator": integrator}
    sim = stark.Simulation(scene, time_step=step, **settings)
    reports = list(sim.run(until=0.03))
    assert any(r.energy["friction"] > 1e-3 for r in reports) == (friction > 0.0)
    first, last = (np.array(r.angular_momentum)[1] for r in (reports[0], reports[-1]))
    return float((last - first) / first)


@pytest.mark.parametrize("gap", [0.01, 0.001])
def test_free_boxes_keep_their_angular_momentum(gap: float) -> None:
    """At 0.1 ms the integrator errs by 1e-8; a couple of friction and gap would be 1.6e-2 at 10 mm."""
    assert abs(_change(0.0, gap, 1e-4, "bdf2")) < 1e-7
    assert abs(_change(0.5, gap, 1e-4, "bdf2")) < 1e-7


def test_long_steps_keep_it_too() -> None:
    """Bound: 10 mm of gap times what it changes by between the last two refreshes."""
    assert abs(_change(0.5, 0.01, 1e-3, "bdf2")) < 3e-6


def test_implicit_euler_loses_no_more_with_friction_than_without() -> None:
    """What it loses is its own error of rotations, of first order."""
    with_friction, without = (_change(mu, 0.01, 1e-4, "implicit_euler") for mu in (0.5, 0.0))
    assert abs(with_friction) <= abs(without) + 1e-6


def test_a_box_that_tilts_with_its_board_does_not_slip() -> None:
    """Turning together is no slip: a board and the box on it turn by 20 degrees, bristles hold the load."""
    scene = stark.Scene()
    scene.default_friction = 1.0
    board = scene.add_box((1.0, 1.0, 0.1), motion="scripted", name="board")
    scene.add_box((0.2, 0.2, 0.1), mass=1.0, position=(0, 0, 0.11), name="box")
    board.follow(rotation=lambda t: stark.rotation(axis="y", angle=np.radians(20.0) * min(t, 1.0)))
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=5e-3)
    sim.run_until(1.2)
    turned = stark.rotation(axis="y", angle=np.radians(20.0))
    place = np.linalg.solve(turned, sim["box"].position)
    assert abs(place[0]) < 3e-5  # bristles bend by less than 10 um
