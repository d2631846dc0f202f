"""Forces far beyond what a scene is made for: gaps keep their least distance, what is gripped stays or the
step fails, and the cause is named."""

from __future__ import annotations

import numpy as np
import pytest

import stark

LEAST = 1e-3  # contact.min_separation_factor


def gripper(cap: float) -> stark.Simulation:
    """A cube of 5 cm between two fingers on sliders, driven by motors with a cap [N]."""
    scene = stark.Scene()
    scene.default_friction = 0.6
    scene.add_floor(2.0)
    scene.add_box(0.05, mass=0.2, position=(0, 0, 0.0265), name="cube")
    for side, name in ((-1, "left"), (1, "right")):
        at = (side * 0.045, 0, 0.04)
        finger = scene.add_box((0.02, 0.06, 0.06), mass=0.3, position=at, name=name)
        slider = scene.add_slider(None, finger, anchor=at, axis=(-side, 0, 0), name=f"slide {name}")
        slider.add_motor(0.1, cap=cap, delta=0.01)
    return stark.Simulation(scene)


@pytest.mark.parametrize("cap", [1e3, 1e5, 1e6, 1e9])
def test_a_grip_neither_crushes_nor_ejects(cap: float) -> None:
    sim = gripper(cap)
    start = sim["cube"].position
    # The floor is closer to the cube than its contact distance, so their own is as small as the gap.
    apart = min(sim["cube"].contact_distance + sim["left"].contact_distance, 1.39e-3)
    for _ in range(30):
        report = sim.step()
        if report.failed:
            assert report.diagnosis.cause in ("crushing_load", "blocked_motion"), report.message
            assert {"rigid body 'cube'"} < set(report.diagnosis.bodies)
            break
        assert report.min_distance >= LEAST * apart * (1.0 - 1e-9)
        limit = 0.02 if report.at_rounding else 0.01  # [m/s^2]
        assert report.acceleration < limit or "round_off" in report.caveats
        assert np.abs(sim["cube"].position - start).max() < 5e-3
    assert cap > 1e6 or not report.failed, report.message
