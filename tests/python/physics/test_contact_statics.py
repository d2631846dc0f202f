"""Rest, incline, stopping and toppling of rigid boxes: V20, V21."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import G, advance, inclined_floor
from _validation import validate

import stark

GAP = 1e-4  # contact distance of each body [m]
STICK = 1e-3  # stick velocity [m/s]


def on_incline(
    angle: float,
    mu: float,
    *,
    size: tuple[float, float, float] = (0.1, 0.1, 0.1),
    velocity: float = 0.0,
    time_step: float = 1e-2,
    **settings: Any,
) -> tuple[stark.Simulation, Any, np.ndarray]:
    """A box of 1 kg on a plane inclined by an angle [deg]; the columns downhill, across, normal."""
    scene = stark.Scene()
    axes = inclined_floor(scene, angle)
    # Beside the middle, where the diagonal of the floor runs; near the gap at rest, because a start deeper
    # inside the barrier is a push, with friction to it.
    position = axes @ (0.0, 0.4, size[2] / 2 + 1.9 * GAP)
    box = scene.add_box(
        size, mass=1.0, name="box", rotation=axes, position=position, velocity=velocity * axes[:, 0]
    )
    scene.friction["box", "floor"] = mu
    settings = {"contact.stick_velocity": STICK, **settings}
    return stark.Simulation(scene, time_step=time_step, contact_distance=GAP, **settings), box, axes


def test_forces_at_rest() -> None:
    settings = {"newton.residual_tolerance": 1e-8, "newton.acceleration_tolerance": 0.0}
    sim, box, _ = on_incline(0.0, 0.5, **settings)
    advance(sim, 2.0)
    validate("V20.weight", box.contact_force[2] / G)


def test_creep_in_stick() -> None:
    sim, box, axes = on_incline(20.0, 0.5)
    advance(sim, 0.5)
    start = box.position @ axes[:, 0]
    advance(sim, 10.5)
    validate("V20.creep", abs(box.position @ axes[:, 0] - start))


def test_sliding_and_its_limit_angle() -> None:
    for name, angle, mu in (("slides", 20.0, 0.3), ("beyond", 27.0, 0.5)):
        sim, box, axes = on_incline(angle, mu)
        advance(sim, 0.3)
        start = box.velocity @ axes[:, 0]
        advance(sim, 0.8)
        validate(f"V20.{name}", (box.velocity @ axes[:, 0] - start) / 0.5)
    sim, box, axes = on_incline(26.0, 0.5)
    advance(sim, 2.0)
    validate("V20.holds", box.velocity @ axes[:, 0])


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_stopping_distance(integrator: str) -> None:
    sim, box, _ = on_incline(0.0, 0.2, velocity=1.0, time_step=2e-3, **{"time.integrator": integrator})
    # Until it creeps: below the stick velocity friction no longer brakes with all it has.
    for report in sim.run(1.0):
        assert not report.failed, report.message
        if box.velocity[0] < STICK:
            break
    validate(f"V21.stop_{integrator}", box.position[0])


@pytest.mark.parametrize("angle", [26.0, 27.0])
def test_slender_block_topples(angle: float) -> None:
    """Half as wide as high, it stands up to 26.565 degrees if it does not slide."""
    sim, box, axes = on_incline(angle, 1.0, size=(0.1, 0.1, 0.2))
    for report in sim.run(3.0):
        assert not report.failed, report.message
        tilt = np.degrees(np.arccos(np.clip(box.rotation[:, 2] @ axes[:, 2], -1, 1)))
        if tilt > 30.0:
            break
    if angle < 26.5:
        validate("V21.stands", tilt)
    else:
        assert tilt > 30.0
